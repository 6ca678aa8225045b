//! A periodic cell and its control.

use serde::{Deserialize, Serialize};

/// A periodic cell: the specimen repeats along its width and its height, without walls. Stages may
/// shear it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Width and height, m.
    pub size: (f64, f64),
}

/// Control of a periodic cell in a stage. A component that is left out keeps its stress if it is
/// under one, and otherwise stays as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CellControl {
    /// Width, or sigma_xx.
    pub xx: Option<CellTarget>,
    /// Height, or sigma_yy.
    pub yy: Option<CellTarget>,
    /// Mean of xx and yy in their place: strain (xx + yy)/2, or mean stress. Width and height
    /// strain alike but for `difference`.
    pub mean: Option<CellTarget>,
    /// Difference, yy less xx, of the strains or of the stresses; fixed if left out.
    pub difference: Option<CellTarget>,
    /// Shear: the top moves along x over the bottom; or the traction along x on the top.
    pub shear: Option<CellTarget>,
}

impl CellControl {
    /// Whether the mean of width and height is controlled, in place of each of them.
    pub(crate) fn is_by_mean(&self) -> bool {
        self.mean.is_some() || self.difference.is_some()
    }

    /// All components, with their fields.
    pub fn targets(&self) -> [(&'static str, Option<CellTarget>); 5] {
        [
            ("xx", self.xx),
            ("yy", self.yy),
            ("mean", self.mean),
            ("difference", self.difference),
            ("shear", self.shear),
        ]
    }
}

/// What a component of the deformation of a cell does in a stage.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum CellTarget {
    /// It stays as it is.
    Fixed,
    /// Strain over the stage: part of the width or height at its start by which the cell shortens,
    /// or displacement of the top over the height at the start.
    Strain(f64),
    /// Stress at the end of the stage, Pa.
    Stress(f64),
}
