//! Settings of contact detection: which pairs take part in an increment to begin with, and when the
//! list of candidates is rebuilt.
//!
//! No setting decides which contacts close: the check of the solution finds pairs that detection
//! left out. The sizes of the classes of the [grid](super::grid) and its allowance for rounding are
//! constants beside the code that uses them.

use bevy_ecs::prelude::*;
#[cfg(feature = "reflect")]
use bevy_ecs::reflect::ReflectResource;

/// Settings of contact detection. To change them, insert the resource before the first increment.
#[non_exhaustive]
#[derive(Resource, Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct DetectionSettings {
    /// Which candidates take part.
    pub reach: ReachSettings,
    /// The list of candidates.
    pub list: ListSettings,
}

/// Gap up to which a pair takes part in an increment.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ReachSettings {
    /// Gap over the expected relative displacement of the pair.
    ///
    /// 2: the expected motion may be wrong by as much again; no study.
    pub motion: f64,
    /// Additional gap, over the maximum imposed displacement.
    ///
    /// 0.5: imposed motion passes on to bodies on which it is not imposed; no study.
    pub imposed: f64,
    /// Additional gap in dynamics, over the displacement of the faster body.
    ///
    /// 0.25: a body that hits another gives it part of its motion, which the free flight of the two
    /// does not predict.
    pub hit: f64,
    /// Minimum gap in dynamics, mean radii.
    ///
    /// 0.06: more than in statics, for the same reason as [`hit`](Self::hit).
    pub min_in_dynamics: f64,
    /// Minimum gap in static and least-motion analysis, mean radii.
    ///
    /// 0.01: a little, for bodies that are expected to rest; no study.
    pub min: f64,
    /// Maximum gap, mean radii.
    ///
    /// 2: a few radii suffice at first. The check of the solution finds pairs that come from
    /// further away.
    pub max: f64,
    /// Distance to a wall, in radii of the particle or mean radii, beyond which the expected motion
    /// is not evaluated.
    ///
    /// 4: twice [`max`](Self::max).
    pub wall: f64,
}

impl Default for ReachSettings {
    fn default() -> Self {
        Self {
            motion: 2.0,
            imposed: 0.5,
            hit: 0.25,
            min_in_dynamics: 0.06,
            min: 0.01,
            max: 2.0,
            wall: 4.0,
        }
    }
}

/// How a list of candidate pairs was found. The pairs do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum SearchMethod {
    /// Edges of the Delaunay triangulation of the centres, where
    /// [`complete_reach`](super::delaunay::complete_reach) proves them complete.
    Delaunay,
    /// Exact search by [`pairs_within`](super::grid::pairs_within), which has no preconditions.
    Grid,
}

/// When the list of candidates is built, and how. The pairs that take part do not depend on it.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ListSettings {
    /// Skin of the list, mean radii.
    ///
    /// 0.1: a thicker skin means fewer rebuilds and a longer list.
    pub skin: f64,
    /// Minimum part of the skin that the Delaunay bound must leave for the triangulation to be
    /// used.
    ///
    /// 0.5: a thinner skin would cost more rebuilds than it saves.
    pub min_skin: f64,
    /// Maximum width of a complete list beyond what is asked for, mean radii. A wider one is
    /// rebuilt.
    ///
    /// 1: after one violent increment all quiet ones would otherwise go through its many pairs.
    pub max_excess: f64,
    /// [`Delaunay`](SearchMethod::Delaunay) to triangulate where that is provably complete, else
    /// search by grid; [`Grid`](SearchMethod::Grid) never to triangulate.
    ///
    /// Delaunay: the edges of the triangulation are the candidates, without a search.
    pub preferred: SearchMethod,
}

impl Default for ListSettings {
    fn default() -> Self {
        Self { skin: 0.1, min_skin: 0.5, max_excess: 1.0, preferred: SearchMethod::Delaunay }
    }
}
