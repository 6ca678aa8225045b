//! Rows of the tables of bodies: walls and bonds.

use crate::bond::BondId;
use crate::material::{BondLaw, ContactLaw};
use crate::wall::{WallControl, WallDrive};
use crate::wall_shape::{Nearest, WallShape};
use bevy_ecs::prelude::*;
use glam::DVec2;

/// A wall of [`BodyTable`](crate::contact::BodyTable).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct WallRow {
    /// Row of the body.
    pub body: u32,
    /// Unit normal into the specimen.
    pub inward: DVec2,
    /// Half the length of the drawn segment, m.
    pub half_length: f64,
    /// Shape for contact.
    pub shape: WallShape,
    /// Law of the wall's contacts.
    pub law: ContactLaw,
    /// Control of the wall in the stage.
    pub control: WallControl,
    /// Drive of the wall in the increment.
    pub drive: WallDrive,
}

impl WallRow {
    /// The point of the wall that is nearest to `place`, with the wall at `position`, m.
    #[inline]
    pub fn nearest(&self, position: DVec2, place: DVec2) -> Nearest {
        self.shape.nearest(self.inward, self.half_length, place - position)
    }

    /// The wall turned about its position by an angle, rad.
    pub fn turned(&self, angle: f64) -> Self {
        if angle == 0.0 {
            return *self;
        }
        let by = DVec2::from_angle(angle);
        Self { inward: by.rotate(self.inward).normalize(), shape: self.shape.turned(by), ..*self }
    }

    /// Maximum distance of a drawn point of the wall from its position, m.
    pub fn extent(&self) -> f64 {
        match self.shape {
            WallShape::Arc { centre, radius, .. } => centre.length() + radius,
            WallShape::Line | WallShape::Segment => self.half_length,
        }
    }

    /// Unit vector from the start to the end of the drawn segment.
    pub fn tangent(&self) -> DVec2 {
        -self.inward.perp()
    }

    /// Whether the wall is an infinite line.
    pub fn is_line(&self) -> bool {
        matches!(self.shape, WallShape::Line)
    }
}

/// An intact bond of [`BodyTable`](crate::contact::BodyTable).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct BondRow {
    /// Identity of the bond.
    pub id: BondId,
    /// Entity of the bond.
    pub entity: Entity,
    /// Row of the first body, a particle.
    pub a: u32,
    /// Row of the second body.
    pub b: u32,
    /// Gap at which the bond has no normal force, m.
    pub initial_gap: f64,
    /// Law of the bond.
    pub law: BondLaw,
}
