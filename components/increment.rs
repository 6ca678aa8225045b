//! What is being analysed and how far it has come.

use bevy_ecs::prelude::*;
#[cfg(feature = "reflect")]
use bevy_ecs::reflect::ReflectResource;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body::Ramp;

/// How bodies resist motion.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum AnalysisKind {
    /// No inertia: every increment is an equilibrium.
    #[default]
    Static,
    /// Prepares packings (4.4.1 of the paper): rigid grains without friction make the smallest
    /// motion that separates them. Each has unit inertia, starts from rest, and theta is 1.
    Compaction {
        /// Whether the motion is the smallest relative to the mean motion, which is linear between
        /// the moving wall and the one opposite. Otherwise it is the smallest relative to the
        /// ground.
        affine: bool,
        /// Maximum of the random part of the reference motion, m, which shakes the packing.
        agitation: f64,
        /// Seed of the random part.
        seed: u64,
    },
    /// Theta-method with theta-averaged elastic forces.
    Dynamic {
        /// Time step, s.
        dt: f64,
        /// Weight of the end of the increment, 0 < theta <= 1.
        theta: f64,
    },
}

/// Kind of analysis, gravity and thickness.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Analysis {
    /// Static, compaction or dynamic.
    pub kind: AnalysisKind,
    /// Acceleration of gravity, m/s^2.
    pub gravity: DVec2,
    /// Out-of-plane thickness h, m.
    pub thickness: f64,
    /// Theta of the path of particles, where contacts have restitution: then the theta of
    /// [`kind`](Self::kind), which is that of velocities and forces, is 1. None: particles move by
    /// the displacements of the program.
    pub path_theta: Option<f64>,
}

impl Default for Analysis {
    fn default() -> Self {
        Self { kind: AnalysisKind::Static, gravity: DVec2::ZERO, thickness: 1.0, path_theta: None }
    }
}

/// Friction law of contacts without strength: the paper's, convex, by which sliding opens the
/// contact by mu |slip|, or Coulomb's.
// The scene's law is another type (`friction_law`): it names combinations of the two fields, and it
// reads fields of earlier builds that have no effect here.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct FrictionLaw {
    /// Coulomb's law in static increments; the paper's if there is none.
    pub in_statics: Option<Coulomb>,
    /// The same in dynamic ones.
    pub in_dynamics: Option<Coulomb>,
}

/// Coulomb's law: sliding and rolling do not open the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Coulomb {
    /// Factorisations of one solve at most.
    pub factorisations: u32,
}

impl Coulomb {
    /// Default of the factorisations.
    pub const FACTORISATIONS: u32 = 600;
}

impl Default for Coulomb {
    fn default() -> Self {
        Self { factorisations: Self::FACTORISATIONS }
    }
}

impl FrictionLaw {
    /// Coulomb's law, if it is the law of this kind of analysis.
    #[must_use]
    pub fn coulomb(&self, kind: AnalysisKind) -> Option<Coulomb> {
        match kind {
            AnalysisKind::Static => self.in_statics,
            AnalysisKind::Dynamic { .. } => self.in_dynamics,
            // A packing is made without friction.
            AnalysisKind::Compaction { .. } => None,
        }
    }
}

/// Solves an increment again with normals and gaps at the new place. The resource of a world
/// without it is [`OFF`](Self::OFF); the default is that of a scene that asks for it.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
#[serde(deny_unknown_fields, default)]
pub struct Corrector {
    /// Maximum number of passes of one increment; 0 keeps the geometry of its start.
    pub passes: u32,
    /// Maximum error of a gap or slip over the maximum displacement, and of a normal.
    pub tolerance: f64,
}

impl Corrector {
    /// No pass: an increment keeps the geometry of its start.
    pub const OFF: Self = Self { passes: 0, tolerance: 0.0 };
}

impl Default for Corrector {
    fn default() -> Self {
        Self { passes: 20, tolerance: 1e-6 }
    }
}

/// What a bond does at its rolling limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum RollingLimit {
    /// It breaks: the letter of 3.4.2 of the paper.
    #[default]
    Breaks,
    /// Its moment stays on the limit and the bond lives.
    Yields,
}

/// How the specimen comes to rest at constant load after a bond has broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Avalanche {
    /// By equilibria: of the bonds above their limits in one of them, the most overloaded breaks,
    /// or as many of these as a group takes.
    #[default]
    MostOverloaded,
    /// By equilibria: all bonds above their limits in one of them break.
    Together,
    /// By a motion with inertia and kinetic damping ([`Motion`](crate::motion::Motion)), in which
    /// bonds break as they reach their limits.
    Dynamic,
}

impl Avalanche {
    /// Whether it is what a scene has that does not say: records of such scenes do not say either.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// In which order bonds break.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum RuptureOrder {
    /// From event to event: an increment is committed at the fraction at which the next bond
    /// reaches its limit, that bond breaks, and the specimen comes to equilibrium at constant load
    /// before it is loaded further. Holds for static analysis where all bonds are elastic and have
    /// strength; elsewhere as `OneRound`.
    #[default]
    Events,
    /// All bonds that are on a limit at the end of an increment break, once (3.4.2 of the paper).
    OneRound,
    /// The increment is solved again without the bonds on a limit until no more break, at most
    /// [`rounds`](RuptureRules::rounds) times.
    AllAtOnce,
}

/// Rules of rupture: `rupture` of a scene, which has all fields but the last two.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
#[serde(rename = "Rupture", deny_unknown_fields, default)]
pub struct RuptureRules {
    /// At the rolling limit.
    pub rolling: RollingLimit,
    /// The order in which bonds break.
    pub order: RuptureOrder,
    /// With `Events`: a bond is at its limit when its overload R lies between 1 - tolerance and 1.
    pub tolerance: f64,
    /// With `Events`: bonds break together that reach their limit while the bond forces change by
    /// this fraction after the first; 0: one by one.
    pub group: f64,
    /// With `Events`: from this density of ruptures on, a share of the bonds per relative change of
    /// force, many bonds break together at the end of an increment; above 20: never.
    #[serde(skip_serializing_if = "is_usual_density")]
    pub density: f64,
    /// With `Events`: many bonds break together at the end of an increment where their ruptures
    /// release at most this multiple of the mean contact force; 0: only by `density`.
    #[serde(skip_serializing_if = "is_usual_brittleness")]
    pub brittleness: f64,
    /// With `AllAtOnce`: maximum number of rounds.
    pub rounds: u32,
    /// With `Events`: what happens after the first bond of an avalanche.
    #[serde(skip_serializing_if = "Avalanche::is_default")]
    pub avalanche: Avalanche,
    /// A bond is on a limit when its slack is below this fraction of the limit.
    #[serde(skip)]
    pub slack: f64,
    /// Relative rotation, rad, or slip over mean radius, above which a rigid limit counts as
    /// active.
    #[serde(skip)]
    pub multiplier: f64,
}

impl RuptureRules {
    /// Default of [`density`](Self::density).
    pub const DENSITY: f64 = 0.1;
    /// Default of [`brittleness`](Self::brittleness).
    pub const BRITTLENESS: f64 = 0.5;
}

/// Whether it is what a scene has that does not say: records of such scenes do not say either.
fn is_usual_density(density: &f64) -> bool {
    density.total_cmp(&RuptureRules::DENSITY).is_eq()
}

fn is_usual_brittleness(brittleness: &f64) -> bool {
    brittleness.total_cmp(&RuptureRules::BRITTLENESS).is_eq()
}

impl Default for RuptureRules {
    fn default() -> Self {
        Self {
            rolling: RollingLimit::default(),
            order: RuptureOrder::default(),
            tolerance: 5e-4,
            group: 0.0,
            density: Self::DENSITY,
            brittleness: Self::BRITTLENESS,
            rounds: 200,
            avalanche: Avalanche::default(),
            slack: 1e-7,
            multiplier: 1e-9,
        }
    }
}

/// What an increment must satisfy before it is committed: `acceptance` of a scene, which has
/// `residual`, `throw`, `snap` and `halvings`.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
#[serde(deny_unknown_fields, default)]
pub struct Acceptance {
    /// Greatest residual. Where it is more than 1e-8, dynamic and without bonds, the default solver
    /// aims at it.
    pub residual: f64,
    /// Greatest motion of a grain about the mean field, in its radii; static analysis only.
    pub throw: f64,
    /// Maximum strain of the mean field in one static solution beyond what is imposed. Where a
    /// loaded specimen strains further the motion is followed; one that strains ten times as far in
    /// that motion has collapsed.
    pub snap: f64,
    /// Travel of the furthest grain about the mean field that a step of a followed motion aims at,
    /// in its radii; at most half of [`MAX_TRAVEL`](Self::MAX_TRAVEL).
    #[serde(skip)]
    pub motion_step: f64,
    /// Greatest overlap of a pair that was not in the program, in mean radii.
    #[serde(skip)]
    pub overlap: f64,
    /// How often an increment may be halved.
    pub halvings: u32,
    /// Weight of the proximal term on bodies that nothing holds, in units of force scale over
    /// displacement scale: small enough that results do not depend on it.
    #[serde(skip)]
    pub regularisation: f64,
}

impl Acceptance {
    /// Maximum travel of the furthest grain about the mean field in a step of a followed motion, in
    /// its radii: what normals that stay as they are allow.
    pub const MAX_TRAVEL: f64 = 0.3;
}

impl Default for Acceptance {
    fn default() -> Self {
        Self {
            residual: 1e-8,
            throw: 0.3,
            snap: 0.02,
            motion_step: 0.15,
            overlap: 1e-6,
            halvings: 6,
            regularisation: 1e-9,
        }
    }
}

/// How far the run has come. Increments count over all stages; an increment that had to be
/// halved is committed as several with a smaller fraction each.
#[derive(Resource, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Progress {
    /// Number of the increment under way, from 1.
    pub increment: u64,
    /// Index of the stage.
    pub stage: usize,
    /// Name of the stage.
    pub stage_name: String,
    /// Increments of the stage that are committed, counting fractions.
    pub done: f64,
    /// Number of increments of the stage.
    pub total: f64,
    /// Fraction of a whole increment that the trial takes; of a committed increment what it took.
    pub fraction: f64,
    /// Fraction that the increment tried before an [event](RuptureOrder::Events) shortened it.
    pub tried: f64,
    /// Whether bonds have just broken: the specimen comes to equilibrium at constant load first.
    pub relaxing: bool,
    /// Whether many bonds reach their limits soon after each other, so that
    /// [`Events`](RuptureOrder::Events) breaks them together.
    pub dense: bool,
    /// Time, s.
    pub time: f64,
}

impl Default for Progress {
    fn default() -> Self {
        Self {
            increment: 0,
            stage: 0,
            stage_name: String::new(),
            done: 0.0,
            total: 0.0,
            fraction: 1.0,
            tried: 1.0,
            relaxing: false,
            dense: false,
            time: 0.0,
        }
    }
}

impl Progress {
    /// Whether the stage is over: all its increments are done, and no avalanche is under way.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.done >= self.total && !self.relaxing
    }

    /// The ramp, over the next whole increment, of a load that goes linearly from one value to
    /// another over the stage. At the end of the stage the target is met exactly. The ramp goes on
    /// beyond it where only a part of the last increment is left: fractions are of whole
    /// increments.
    #[must_use]
    pub fn ramp(&self, from: f64, to: f64) -> Ramp {
        let at = |done: f64| {
            let is_end = self.total <= 0.0 || (done - self.total).abs() < 1e-9;
            if is_end { to } else { from + (to - from) * (done / self.total) }
        };
        Ramp { from: at(self.done), to: at(self.done + 1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::Progress;

    /// 46 commits of one stage had ended at 192.8 of 200 kPa.
    #[test]
    fn many_parts_of_the_last_increment_lose_no_load() {
        let mut progress = Progress { done: 19.0, total: 20.0, ..Progress::default() };
        for fraction in [0.5, 0.125, 0.25, 0.0625, 0.03125, 0.03125] {
            let ramp = progress.ramp(0.0, 200.0);
            let expected = 200.0 * (progress.done + fraction) / 20.0;
            let reached = ramp.at(fraction);
            assert!((reached - expected).abs() < 1e-10, "{reached} instead of {expected}");
            progress.done += fraction;
        }
        assert_eq!(progress.ramp(0.0, 200.0).from, 200.0);
    }

    #[test]
    fn a_whole_increment_at_the_end_meets_its_target_exactly() {
        let progress = Progress { done: 2.0, total: 3.0, ..Progress::default() };
        assert_eq!(progress.ramp(0.1, 0.7).at(1.0), 0.7);
        assert_eq!(Progress::default().ramp(0.1, 0.7).to, 0.7);
    }

    #[test]
    fn a_stage_is_not_over_within_an_avalanche() {
        let progress = Progress { done: 3.0, total: 3.0, ..Progress::default() };
        assert!(progress.is_over());
        assert!(!Progress { relaxing: true, ..progress }.is_over());
    }
}
