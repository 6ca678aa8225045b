//! The scene format, version 1: what a RON scene may say.
//!
//! Units are SI throughout: m, s, kg, N, Pa, rad. Compression, contraction and anticlockwise
//! rotation are positive. `some(x)` may be written as plain `x`; newtype variants need no second
//! pair of parentheses. Unknown fields are errors.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::unique_keys;

/// Version of the format that this build reads.
pub const VERSION: u32 = 1;

/// A scene: materials, a specimen, walls, and the stages that happen to them.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Version of the format: 1.
    pub version: u32,
    /// One line that says what the scene shows.
    pub title: String,
    /// Out-of-plane thickness h, m.
    #[serde(default = "one")]
    pub thickness: f64,
    /// Acceleration of gravity (x, y), m/s^2.
    #[serde(default)]
    pub gravity: (f64, f64),
    /// Static or dynamic; a stage may say otherwise for itself.
    #[serde(default)]
    pub analysis: Analysis,
    /// Friction law of unbonded contacts.
    #[serde(default)]
    pub friction_law: FrictionLaw,
    /// Rules of rupture.
    #[serde(default)]
    pub rupture: Rupture,
    /// Whether increments are solved again with the geometry that they lead to.
    #[serde(default)]
    pub corrector: Option<Corrector>,
    /// The solver.
    #[serde(default)]
    pub solver: Solver,
    /// What an increment must satisfy to be committed.
    #[serde(default)]
    pub acceptance: Acceptance,
    /// Particle materials by name.
    #[serde(deserialize_with = "unique_keys::deserialize")]
    pub materials: BTreeMap<String, Material>,
    /// The particles.
    pub specimen: Specimen,
    /// Bonds that are there from the start, free of stress; cementing stages add more.
    #[serde(default)]
    pub bonds: Vec<ExplicitBond>,
    /// Names under which the history records particles, by index: for those that are not listed one
    /// by one.
    #[serde(default, deserialize_with = "unique_keys::deserialize")]
    pub probes: BTreeMap<String, u32>,
    /// Straight walls.
    #[serde(default)]
    pub walls: Vec<Wall>,
    /// What happens, in order.
    pub stages: Vec<Stage>,
    /// How this rig defines strain and stress.
    #[serde(default)]
    pub measures: Measures,
    /// What is written.
    #[serde(default)]
    pub output: Output,
}

fn one() -> f64 {
    1.0
}

/// Kind of analysis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Analysis {
    /// No inertia, no damping.
    #[default]
    Static,
    /// Theta-method with theta-averaged elastic forces.
    Dynamic {
        /// Time step of an increment, s.
        dt: f64,
        /// 0 < theta <= 1: 1/2 keeps energy, 1 is plastic impact; rebound is (1 - theta)/theta.
        #[serde(default = "one")]
        theta: f64,
    },
}

/// Friction law of unbonded contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum FrictionLaw {
    /// The paper's associated law: sliding opens a contact by mu |slip|.
    #[default]
    Associated,
    /// Coulomb's law in dynamic stages, the associated one in static stages.
    ByAnalysis,
    /// Coulomb's law: sliding does not open a contact.
    Coulomb {
        /// Factorisations of one solve at most.
        #[serde(default = "coulomb_factorisations")]
        factorisations: u32,
        /// Read for scenes of earlier builds, and without effect.
        #[serde(default, skip_serializing)]
        tolerance: f64,
        /// The same.
        #[serde(default, skip_serializing)]
        max_passes: u32,
    },
}

impl Scene {
    /// Whether a contact law of the scene has restitution: then velocities of dynamic stages are those of theta 1.
    #[must_use]
    pub fn has_restitution(&self) -> bool {
        let materials = self.materials.values().map(|material| material.contact);
        let walls = self.walls.iter().map(|wall| wall.contact);
        materials.chain(walls).any(|contact| contact.restitution > 0.0)
    }
}

impl FrictionLaw {
    /// Coulomb's law with the defaults.
    pub const COULOMB: Self =
        Self::Coulomb { factorisations: FACTORISATIONS, tolerance: 0.0, max_passes: 0 };
}

/// Default of [`FrictionLaw::Coulomb`].
const FACTORISATIONS: u32 = clastic_components::increment::Coulomb::FACTORISATIONS;

fn coulomb_factorisations() -> u32 {
    FACTORISATIONS
}

/// Rules of rupture.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rupture {
    /// What a bond does at its rolling limit.
    pub rolling: RollingLimit,
    /// The order in which bonds break.
    pub order: RuptureOrder,
    /// With `Events`: a bond breaks at an overload between 1 - tolerance and 1.
    pub tolerance: f64,
    /// With `Events`: bonds break together that reach their limit while the forces change by this fraction.
    pub group: f64,
    /// With `AllAtOnce`: cap on the rounds.
    pub rounds: u32,
    /// With `Events`: what happens after the first bond of an avalanche.
    #[serde(skip_serializing_if = "Avalanche::is_default")]
    pub avalanche: Avalanche,
}

impl Default for Rupture {
    fn default() -> Self {
        Self {
            rolling: RollingLimit::Breaks,
            order: RuptureOrder::default(),
            tolerance: 5e-4,
            group: 0.0,
            rounds: 200,
            avalanche: Avalanche::default(),
        }
    }
}

/// How the specimen comes to rest at constant load after a bond has broken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Avalanche {
    /// The most overloaded bond breaks, equilibrium by equilibrium.
    #[default]
    MostOverloaded,
    /// All bonds above their limits break, equilibrium by equilibrium.
    Together,
    /// The motion is followed, and bonds break in it as they reach their limits.
    Dynamic,
}

impl Avalanche {
    /// Whether it is what a scene has that does not say: records of such scenes do not say either.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The order in which bonds break.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum RuptureOrder {
    /// One after the other, each at the load at which it reaches its limit.
    #[default]
    Events,
    /// All that are on a limit at the end of an increment, once.
    OneRound,
    /// All that are on a limit, and those that follow, within the increment.
    AllAtOnce,
}

/// Solves an increment again with normals and gaps at the new place.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Corrector {
    /// Cap on the passes.
    pub passes: u32,
    /// Greatest error of a gap or slip over the greatest displacement, and of a normal.
    pub tolerance: f64,
}

impl Default for Corrector {
    fn default() -> Self {
        Self { passes: 20, tolerance: 1e-6 }
    }
}

/// What a bond does at its rolling limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum RollingLimit {
    /// It breaks.
    #[default]
    Breaks,
    /// Its moment stays on the limit.
    Yields,
}

/// The solver and its settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Solver {
    /// The engine's own condensed solver, with Clarabel as its last resort.
    #[default]
    Condensed,
    /// The interior-point solver Clarabel.
    Clarabel {
        /// Feasibility and gap tolerance that Clarabel is asked for.
        #[serde(default = "clarabel_tolerance")]
        tolerance: f64,
        /// Cap on its iterations.
        #[serde(default = "clarabel_iterations")]
        max_iterations: u32,
    },
}

fn clarabel_tolerance() -> f64 {
    1e-10
}

fn clarabel_iterations() -> u32 {
    200
}

/// What an increment must satisfy to be committed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Acceptance {
    /// Greatest of the four residuals. Where it is more than 1e-8, dynamic and without bonds, the
    /// default solver aims at it.
    pub residual: f64,
    /// Greatest motion of a grain about the mean field in a static increment, in its radii.
    pub throw: f64,
    /// Greatest strain of the mean field in a static increment beyond what is imposed: a specimen
    /// that strains further under its loads has collapsed.
    pub snap: f64,
    /// How often an increment may be halved.
    pub halvings: u32,
}

impl Default for Acceptance {
    fn default() -> Self {
        Self { residual: 1e-8, throw: 0.3, snap: 0.02, halvings: 6 }
    }
}

/// A particle material.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Density, kg/m^3; needed where there is gravity or dynamics.
    #[serde(default = "rock_density")]
    pub density: f64,
    /// Contacts between particles of this material.
    #[serde(default)]
    pub contact: Contact,
    /// Bonds between particles of this material.
    #[serde(default)]
    pub bond: Option<Bond>,
}

fn rock_density() -> f64 {
    2650.0
}

/// Law of a contact. Without a stiffness it is rigid, without friction frictionless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Contact {
    /// Normal stiffness k_N, N/m; none is rigid.
    pub normal_stiffness: Option<f64>,
    /// Tangential stiffness k_T, N/m; none is rigid.
    pub tangential_stiffness: Option<f64>,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of rolling friction. With 0 the contact has no rolling moment.
    pub rolling_friction: f64,
    /// Coefficient of restitution, 0 to 1, of a rigid contact in dynamic stages.
    pub restitution: f64,
}

/// Law of a bond. Without a stiffness it is rigid.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Bond {
    /// Normal stiffness k_N, N/m; none is rigid.
    #[serde(default)]
    pub normal_stiffness: Option<f64>,
    /// Tangential stiffness k_T, N/m; none is rigid.
    #[serde(default)]
    pub tangential_stiffness: Option<f64>,
    /// Internal friction coefficient.
    #[serde(default)]
    pub friction: f64,
    /// Coefficient of rolling friction. With 0 the bond has no rolling moment and never breaks in rolling.
    #[serde(default)]
    pub rolling_friction: f64,
    /// Cohesion c, Pa.
    pub cohesion: f64,
    /// Tensile strength sigma_t, Pa.
    pub tensile_strength: f64,
}

/// Where the particles come from.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Specimen {
    /// One by one.
    Particles(Vec<Particle>),
    /// A triangular lattice of equal, touching disks; the outermost ring is the group `boundary`.
    Lattice {
        /// Disks in a row; every other row has one less.
        columns: u32,
        /// Rows.
        rows: u32,
        /// Radius, m.
        radius: f64,
        /// Centre of the lower left disk, m.
        #[serde(default)]
        origin: (f64, f64),
        /// Material; may be left out where the scene has only one.
        #[serde(default)]
        material: Option<String>,
    },
    /// Random disks on a loose square grid, one in each cell and at a random place in it; a
    /// `Compact` stage makes a packing of them.
    Packing {
        /// Number of disks.
        count: u32,
        /// Columns of the grid.
        columns: u32,
        /// Spacing of the grid, m; at least the greatest diameter.
        spacing: f64,
        /// Lower left corner of the grid, m.
        #[serde(default)]
        origin: (f64, f64),
        /// Size distribution.
        sizes: Sizes,
        /// Seed of sizes and places.
        seed: u64,
        /// Material; may be left out where the scene has only one.
        #[serde(default)]
        material: Option<String>,
    },
    /// A stored specimen: CSV with the columns x_m, y_m, radius_m (and optionally material).
    File {
        /// Path, relative to the scene file.
        path: String,
        /// Material of rows that name none.
        #[serde(default)]
        material: Option<String>,
    },
}

/// Size distribution of a packing.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Sizes {
    /// All alike.
    Equal {
        /// Radius, m.
        radius: f64,
    },
    /// Uniform by number between two radii.
    Uniform {
        /// Smallest and greatest radius, m.
        radius: (f64, f64),
    },
    /// Log-normal by number, cut off.
    LogNormal {
        /// Median radius, m.
        radius: f64,
        /// Standard deviation of the logarithm.
        deviation: f64,
        /// Smallest and greatest radius, m.
        limits: (f64, f64),
    },
}

/// One particle.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Particle {
    /// Centre (x, y), m.
    pub position: (f64, f64),
    /// Radius, m.
    pub radius: f64,
    /// Material; may be left out where the scene has only one.
    #[serde(default)]
    pub material: Option<String>,
    /// Initial velocity, m/s.
    #[serde(default)]
    pub velocity: (f64, f64),
    /// Initial angular velocity, rad/s.
    #[serde(default)]
    pub angular_velocity: f64,
    /// Group for selection by stages.
    #[serde(default)]
    pub group: Option<String>,
    /// Name under which the history records it.
    #[serde(default)]
    pub probe: Option<String>,
}

/// A bond between two particles, by their index in the specimen (from 0).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ExplicitBond {
    /// First particle.
    pub a: u32,
    /// Second particle.
    pub b: u32,
}

/// A straight wall. Material lies on the left of the way from start to end.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name.
    pub name: String,
    /// Start of the drawn segment, m.
    pub start: (f64, f64),
    /// End of the drawn segment, m.
    pub end: (f64, f64),
    /// Law of its contacts with particles; without it rigid and frictionless.
    #[serde(default)]
    pub contact: Contact,
    /// Bonds of particles to it; without it they have the law of the particle's material.
    #[serde(default)]
    pub bond: Option<Bond>,
    /// Whether it is there from the start; a stage can bring it in.
    #[serde(default = "yes")]
    pub present: bool,
    /// Name under which the history records it.
    #[serde(default)]
    pub probe: Option<String>,
}

fn yes() -> bool {
    true
}

/// A stage.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Stage {
    /// Moves a wall against the particles, rigid and frictionless and with the least motion,
    /// until the packing is as dense or as high as wanted. All other walls stay.
    Compact(Compact),
    /// Bonds every pair closer than a length, free of stress. Takes no increment.
    Cement(Cement),
    /// Increments under controlled walls and particles.
    Load(Load),
}

impl Stage {
    /// Name of the stage.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Compact(s) => &s.name,
            Self::Cement(s) => &s.name,
            Self::Load(s) => &s.name,
        }
    }

    /// What it records; none where it takes no increments.
    #[must_use]
    pub fn record(&self) -> Option<&Record> {
        match self {
            Self::Compact(s) => Some(&s.record),
            Self::Cement(_) => None,
            Self::Load(s) => Some(&s.record),
        }
    }
}

/// See [`Stage::Compact`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Compact {
    /// Name.
    pub name: String,
    /// The wall that moves, along its inward normal.
    pub wall: String,
    /// The fixed wall opposite, from which the height counts.
    pub base: String,
    /// When it is done.
    pub target: CompactTarget,
    /// Greatest motion of the wall in an increment, m.
    pub step: f64,
    /// What the particles do where nothing pushes them.
    #[serde(default)]
    pub rest: CompactRest,
    /// Shaking: greatest random part of the motion that particles tend to in an increment, in mean
    /// radii. Without it a random packing jams before it is dense.
    #[serde(default)]
    pub agitation: f64,
    /// Seed of the shaking.
    #[serde(default)]
    pub seed: u64,
    /// What is recorded.
    #[serde(default)]
    pub record: Record,
}

/// What a stage leaves in the results. Ruptures and key results see every increment in any case.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Record {
    /// A row of the history every so many increments of the stage, and at its end.
    pub every: u32,
    /// A frame every so many increments of the stage, 0 for none; left out, as `output` says.
    pub frames_every: Option<u32>,
    /// Frames after these increments of the stage, from 1.
    pub frames: Vec<u32>,
}

impl Default for Record {
    fn default() -> Self {
        Self { every: 1, frames_every: None, frames: Vec::new() }
    }
}

/// When a compaction is done.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum CompactTarget {
    /// Distance of the two walls, m.
    Height(f64),
    /// Porosity between the two walls over the length of the base.
    Porosity(f64),
}

/// Reference motion of a compaction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum CompactRest {
    /// Particles follow the wall in proportion to their height: an even packing.
    #[default]
    Affine,
    /// Particles stay until they are pushed: the packing fills from the moving wall.
    Still,
}

/// See [`Stage::Cement`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cement {
    /// Name.
    pub name: String,
    /// Bond length g_int, m: pairs with a smaller gap are bonded (3.4.1 of the paper).
    pub length: f64,
    /// Whether particles are bonded to walls as well.
    #[serde(default)]
    pub walls: bool,
}

/// See [`Stage::Load`].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Name.
    pub name: String,
    /// Number of increments.
    pub increments: u32,
    /// Analysis of this stage, where it differs from the scene's.
    #[serde(default)]
    pub analysis: Option<Analysis>,
    /// Gravity of this stage, where it differs from the scene's.
    #[serde(default)]
    pub gravity: Option<(f64, f64)>,
    /// Control of walls by name. A wall that is not named keeps its load if it is loaded, else
    /// stays where it is.
    #[serde(default, deserialize_with = "unique_keys::deserialize")]
    pub walls: BTreeMap<String, WallControl>,
    /// Walls that are taken away at the start.
    #[serde(default)]
    pub remove_walls: Vec<String>,
    /// Walls that are brought in at the start.
    #[serde(default)]
    pub add_walls: Vec<String>,
    /// What is done to particles. Particles that are not selected are free.
    #[serde(default)]
    pub particles: Vec<ParticleControl>,
    /// Conditions that end the stage early.
    #[serde(default)]
    pub stop: Vec<Stop>,
    /// What is recorded.
    #[serde(default)]
    pub record: Record,
}

/// Control of a wall.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum WallControl {
    /// It stays where it is.
    Fixed,
    /// Displacement (x, y) in every increment, m.
    Displacement(f64, f64),
    /// Velocity (x, y), m/s.
    Velocity(f64, f64),
    /// Force along the inward normal at the end of the stage, N.
    Force(f64),
    /// Stress along the inward normal at the end of the stage, Pa.
    Stress {
        /// Stress, Pa, compression positive.
        stress: f64,
        /// The two walls whose current distance is the loaded length; without them the length
        /// of the drawn segment.
        #[serde(default)]
        between: Option<(String, String)>,
    },
    /// A system of an embedding program drives it. The `clastic` program refuses it.
    Custom,
}

/// What a stage does to the particles that it selects.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ParticleControl {
    /// Which particles.
    pub select: Select,
    /// Along x.
    #[serde(default)]
    pub x: Motion,
    /// Along y.
    #[serde(default)]
    pub y: Motion,
    /// Rotation.
    #[serde(default)]
    pub rotation: Motion,
    /// Displacement gradient ((ux_x, ux_y), (uy_x, uy_y)) in every increment, about the origin,
    /// of positions at the start of the stage: imposes x and y.
    #[serde(default)]
    pub affine: Option<((f64, f64), (f64, f64))>,
    /// Force (x, y) at the end of the stage, N; it goes there linearly from what it was.
    #[serde(default)]
    pub force: Option<(f64, f64)>,
    /// Moment at the end of the stage, N m, likewise.
    #[serde(default)]
    pub moment: Option<f64>,
}

/// A selection of particles.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Select {
    /// Every particle.
    All,
    /// By index in the specimen, from 0.
    Index(Vec<u32>),
    /// By group.
    Group(String),
    /// By the name of its probe.
    Probe(String),
    /// Centres in a box at the start of the stage.
    Box {
        /// Lower left corner, m.
        min: (f64, f64),
        /// Upper right corner, m.
        max: (f64, f64),
    },
}

/// Imposed motion along one degree of freedom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Motion {
    /// An unknown.
    #[default]
    Free,
    /// Held.
    Held,
    /// Displacement (m) or rotation (rad) in every increment.
    Displacement(f64),
    /// Velocity (m/s) or angular velocity (rad/s).
    Velocity(f64),
}

/// A condition that ends a stage. A collapse always ends it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Stop {
    /// Axial strain reaches this value.
    AxialStrain(f64),
    /// After its peak, the axial stress falls below this fraction of the peak. The drop must be more than
    /// the error of the stress that `acceptance.residual` allows.
    StressDrop(f64),
    /// Time reaches this value, s.
    Time(f64),
    /// The greatest speed of a particle falls below this value, m/s (after the first increment).
    Rest(f64),
}

/// Definitions of strain and stress.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Measures {
    /// Stage at whose start strains are zero; the last stage where it is left out.
    pub reference_stage: Option<String>,
    /// Axial strain.
    pub axial_strain: Option<Strain>,
    /// Lateral strain.
    pub lateral_strain: Option<Strain>,
    /// Axial stress.
    pub axial_stress: Option<Stress>,
    /// Lateral stress.
    pub lateral_stress: Option<Stress>,
}

/// A strain: closing over the distance at the start of the reference stage.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Strain {
    /// Of the distance of two walls.
    Walls(String, String),
    /// Of the distance of the centres of two particles, by index.
    Particles(u32, u32),
}

/// A stress.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Stress {
    /// Mean of the normal forces on walls over a length times the thickness.
    Walls {
        /// The walls.
        walls: Vec<String>,
        /// The length.
        length: Length,
    },
    /// Component of the average stress sum f (x) l / V (Love, Weber).
    Average {
        /// Component.
        component: Component,
        /// The area.
        area: Area,
    },
}

/// A length under a wall stress.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Length {
    /// Fixed, m.
    Fixed(f64),
    /// Current distance of two walls.
    Between(String, String),
}

/// An area under an average stress.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Area {
    /// Fixed, m^2.
    Fixed(f64),
    /// Between two pairs of walls.
    Box((String, String), (String, String)),
}

/// Component of a stress tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Component {
    /// sigma_xx.
    Xx,
    /// sigma_yy.
    Yy,
    /// sigma_xy.
    Xy,
}

/// What is written beside the history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// A frame (CSV of all particles) every so many increments; 0 writes only the last.
    pub frames_every: u32,
    /// Pictures (SVG) of curves and specimen.
    pub plots: bool,
    /// The energy ledger in the history.
    pub energy: bool,
}

impl Default for Output {
    fn default() -> Self {
        Self { frames_every: 0, plots: true, energy: false }
    }
}
