//! Strains: of distances, of the particles in a region, and the angle of dilation.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::DVec2;

use clastic_components::prelude::*;

use super::principal::Principal;
use crate::control_walls::wall_distance;

/// Where bodies are, and where the particles were at the start of the reference stage.
#[derive(SystemParam)]
pub struct StrainTables<'w, 's> {
    walls: Query<'w, 's, (&'static Wall, &'static BodyPosition)>,
    particles: Query<'w, 's, (&'static BodyId, &'static BodyPosition), With<Particle>>,
    membranes: Query<'w, 's, &'static MembraneShape>,
    cell: Option<Res<'w, PeriodicCell>>,
    start: Option<Res<'w, StrainReference>>,
}

impl StrainTables<'_, '_> {
    /// Current value of the distance of a strain measure, m. For a shear of the periodic cell it is
    /// the strain itself. `None` for a measure that compares no distance, or whose bodies are not
    /// all in the world.
    pub fn distance(&self, measure: &StrainMeasure) -> Option<f64> {
        match *measure {
            StrainMeasure::Walls(a, b) => self.between(a, b),
            StrainMeasure::Particles(a, b) => {
                let place = |particle| self.particles.get(particle).ok().map(|(_, x)| x.0);
                Some(place(a)?.distance(place(b)?))
            }
            StrainMeasure::Membrane(membrane) => self.membranes.get(membrane).ok()?.width(),
            StrainMeasure::Cell(CellStrain::Width) => Some(self.cell.as_ref()?.width),
            StrainMeasure::Cell(CellStrain::Height) => Some(self.cell.as_ref()?.height),
            StrainMeasure::Cell(CellStrain::Shear) => Some(self.cell.as_ref()?.shear),
            StrainMeasure::Region { .. } => None,
        }
    }

    /// Where the particles were at the start of the reference stage, m; `None` before it.
    pub(super) fn starts(&self) -> Option<&[(BodyId, DVec2)]> {
        Some(&self.start.as_ref().filter(|start| !start.0.is_empty())?.0)
    }

    /// Displacement of a particle since the start of the reference stage, m: 0 for a particle that
    /// was not there then, `None` before this stage.
    pub(super) fn motion(&self, id: BodyId, now: DVec2) -> Option<f64> {
        let start = self.starts()?;
        let found = start.binary_search_by_key(&id, |(id, _)| *id);
        Some(found.map_or(0.0, |k| now.distance(start[k].1)))
    }

    /// Centres of the particles in the order of identities, m.
    fn places(&self) -> Vec<(BodyId, DVec2)> {
        let mut places: Vec<_> = self.particles.iter().map(|(id, x)| (*id, x.0)).collect();
        places.sort_unstable_by_key(|(id, _)| *id);
        places
    }

    /// Distance of two walls, m; `None` if one of them was removed.
    pub fn between(&self, a: Entity, b: Entity) -> Option<f64> {
        let there = self.walls.contains(a) && self.walls.contains(b);
        there.then(|| wall_distance(a, b, &self.walls))
    }

    /// A strain, with the distance at the start of the reference stage if it compares one.
    pub fn strain(&self, measure: &StrainMeasure, reference: Option<f64>) -> Option<f64> {
        let StrainMeasure::Region { component, min, max } = *measure else {
            let (then, now) = (reference?, self.distance(measure)?);
            return Some(match measure {
                StrainMeasure::Cell(CellStrain::Shear) => now - then,
                _ => (then - now) / then,
            });
        };
        let (min, max) = (DVec2::from(min), DVec2::from(max));
        let start = self.start.as_ref()?;
        let now = self.places();
        let inside = |x: DVec2| x.cmpge(min).all() && x.cmple(max).all();
        let (mut places, mut motions) = (Vec::new(), Vec::new());
        for (id, place) in start.0.iter().filter(|(_, place)| inside(*place)) {
            if let Ok(k) = now.binary_search_by_key(id, |(id, _)| *id) {
                places.push(*place);
                motions.push(now[k].1 - *place);
            }
        }
        let field = AffineField::fit(&places, &motions)?;
        let (xx, yy) = (-field.along_x.x, -field.along_y.y);
        let xy = -0.5 * (field.along_x.y + field.along_y.x);
        Some(match component {
            StrainComponent::Xx => xx,
            StrainComponent::Yy => yy,
            StrainComponent::Xy => xy,
            StrainComponent::Major => Principal::of(xx, yy, xy).major,
            StrainComponent::Minor => Principal::of(xx, yy, xy).minor,
            StrainComponent::Volumetric => xx + yy,
            StrainComponent::Rotation => 0.5 * (field.along_x.y - field.along_y.x),
        })
    }
}

/// Shear strain of the displacement gradient that fits motions of the particles best,
/// `du_x/dy + du_y/dx`; `None` where they lie in a line.
pub fn shear_of(bodies: &BodyTable) -> Option<f64> {
    let n = bodies.particles;
    let motions =
        bodies.last_motion[..n].iter().map(|u| DVec2::new(u[0], u[1])).collect::<Vec<_>>();
    let field = AffineField::fit(&bodies.positions[..n], &motions)?;
    Some(field.along_x.y + field.along_y.x)
}

/// Sets distances and places at the start of the reference stage. The stages run it once.
pub fn take_reference(
    tables: StrainTables,
    mut measures: ResMut<Measures>,
    mut named: ResMut<NamedMeasures>,
    path: Option<ResMut<StrainPath>>,
    mut commands: Commands,
) {
    let of =
        |m: &Option<StrainMeasure>| m.as_ref().and_then(|m| tables.distance(m)).unwrap_or(f64::NAN);
    measures.reference = Some([of(&measures.axial_strain), of(&measures.lateral_strain)]);
    let distance = |quantity: &Option<Quantity>| match quantity {
        Some(Quantity::Strain(m)) => tables.distance(m),
        _ => None,
    };
    named.references = named.list.iter().map(|(_, quantity)| distance(quantity)).collect();
    if let Some(mut path) = path {
        path.0 = vec![[0.0; 2]];
    }
    if tables.start.is_some() {
        commands.insert_resource(StrainReference(tables.places()));
    }
}

/// Keeps the strains from which angles of dilation are computed.
pub(crate) fn follow_path(
    named: Res<NamedMeasures>,
    attempt: Res<Attempt>,
    observation: Res<Observation>,
    path: Option<ResMut<StrainPath>>,
) {
    let Some(mut path) = path else { return };
    let committed = attempt.status.is_committed();
    let strains = (observation.axial_strain, observation.lateral_strain);
    let (true, (Some(axial), Some(lateral))) = (committed, strains) else { return };
    path.0.push([axial, lateral]);
    let over = named.list.iter().filter_map(|(_, quantity)| match quantity {
        Some(Quantity::DilationAngle { over }) => Some(*over),
        _ => None,
    });
    let over = over.fold(0.0, f64::max);
    let kept = start_of(&path.0, over).unwrap_or(0);
    path.0.drain(..kept);
}

/// Index of the last entry from which the axial strain has changed by at least `over`, so that the
/// change covers at least `over`; `None` if the strain has not changed so far.
fn start_of(path: &[[f64; 2]], over: f64) -> Option<usize> {
    let (last, before) = path.split_last()?;
    // Strains are sums over increments: round-off must not lengthen the path by an increment.
    let far = |point: &[f64; 2]| (last[0] - point[0]).abs() >= over * (1.0 - 1e-9);
    before.iter().rposition(far)
}

/// Angle of dilation at the end of a path of axial and lateral strains, rad. `None` before the
/// axial strain has changed by `over`, and without shear, that is, if the two strains change
/// equally.
pub(crate) fn dilation_angle(path: &[[f64; 2]], over: f64) -> Option<f64> {
    let (from, to) = (path[start_of(path, over)?], path.last()?);
    let change = |k: usize| -((1.0 - to[k]) / (1.0 - from[k])).ln();
    let (axial, lateral) = (change(0), change(1));
    let sine = -(axial + lateral) / (axial - lateral).abs();
    (sine.abs() <= 1.0).then(|| sine.asin())
}

/// Displacement gradient of the affine field that fits the motions of bodies best.
struct AffineField {
    /// `du/dx`.
    along_x: DVec2,
    /// `du/dy`.
    along_y: DVec2,
}

impl AffineField {
    /// Fits by least squares; `None` for less than three bodies, or collinear ones.
    fn fit(x: &[DVec2], u: &[DVec2]) -> Option<Self> {
        let n = x.len().max(1) as f64;
        let origin = x.iter().sum::<DVec2>() / n;
        let mean = u.iter().sum::<DVec2>() / n;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        let (mut ux, mut uy) = (DVec2::ZERO, DVec2::ZERO);
        for (x, u) in x.iter().zip(u) {
            let d = *x - origin;
            xx += d.x * d.x;
            xy += d.x * d.y;
            yy += d.y * d.y;
            ux += d.x * (*u - mean);
            uy += d.y * (*u - mean);
        }
        let det = xx * yy - xy * xy;
        (det > 1e-6 * (xx + yy) * (xx + yy)).then(|| Self {
            along_x: (yy * ux - xy * uy) / det,
            along_y: (xx * uy - xy * ux) / det,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_of_dilation_is_that_of_a_slope() {
        // A block that slides at psi over a plane at 45 + psi / 2 degrees: e_a + e_l over
        // e_a - e_l is -sin psi in every increment, small or large.
        let psi = 0.2_f64;
        let ratio = (1.0 + psi.sin()) / (1.0 - psi.sin());
        let strains = |n: usize| (0..=n).map(|k| 1e-3 * k as f64);
        let path: Vec<_> =
            strains(20).map(|e| [1.0 - (-e).exp(), 1.0 - (ratio * e).exp()]).collect();
        for over in [0.0, 0.002, 0.015] {
            let found = dilation_angle(&path, over).unwrap();
            assert!((found - psi).abs() < 1e-12, "{over}: {found}");
        }
        assert_eq!(dilation_angle(&path, 0.03), None);
        // Extension, with the signs of the other axis.
        let turned: Vec<_> = path.iter().map(|[a, l]| [*l, *a]).collect();
        assert!((dilation_angle(&turned, 0.0).unwrap() - psi).abs() < 1e-12);
        // At constant volume, and without shear.
        let constant = [[0.0, 0.0], [0.01, 1.0 - 1.0 / 0.99]];
        assert!(dilation_angle(&constant, 0.0).unwrap().abs() < 1e-14);
        assert_eq!(dilation_angle(&[[0.0, 0.0], [0.01, 0.01]], 0.0), None);
        assert_eq!(dilation_angle(&[[0.0, 0.0]], 0.0), None);
    }
}
