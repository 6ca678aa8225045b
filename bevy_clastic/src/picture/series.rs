//! Measures of a world, and their values over the increments.

use bevy::ecs::prelude::*;
use clastic::components::measure::{NamedMeasures, Quantity, Readings};
use clastic::components::observation::Observation;
use clastic::frames::Frame;

/// A measure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Unit of the values; empty for a number. Strains are in %.
    pub unit: &'static str,
}

/// Values of measures over the increments, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// The measures.
    pub columns: Vec<Column>,
    /// Increment and values. A value that is not defined is `None`.
    pub rows: Vec<(u64, Vec<Option<f64>>)>,
}

impl Series {
    /// Adds a row. Rows of this and of later increments go, since the world has gone back. With
    /// other measures the series begins anew.
    pub fn add(&mut self, columns: &[Column], increment: u64, row: Vec<Option<f64>>) {
        if self.columns != columns {
            *self = Self { columns: columns.to_vec(), rows: Vec::new() };
        }
        self.back_to(increment.saturating_sub(1));
        self.rows.push((increment, row));
    }

    /// Forgets the rows after an increment to which the world has gone back.
    pub fn back_to(&mut self, increment: u64) {
        let kept = self.rows.partition_point(|(earlier, _)| *earlier <= increment);
        self.rows.truncate(kept);
    }

    /// Points of a curve, where both measures are defined.
    #[must_use]
    pub fn curve(&self, x: usize, y: usize) -> Vec<[f64; 2]> {
        let point = |(_, row): &(u64, Vec<Option<f64>>)| Some([(*row.get(x)?)?, (*row.get(y)?)?]);
        self.rows.iter().filter_map(point).collect()
    }
}

/// The first measures, which every world has.
const ALWAYS: [(&str, &str); 13] = [
    ("increment", ""),
    ("time", "s"),
    ("axial_strain", "%"),
    ("lateral_strain", "%"),
    ("volumetric_strain", "%"),
    ("axial_stress", "Pa"),
    ("lateral_stress", "Pa"),
    ("kinetic_energy", "J"),
    ("contacts", ""),
    ("bonds", ""),
    ("broken_tension", ""),
    ("broken_shear", ""),
    ("coordination", ""),
];

/// Values of a probe, after its name.
const OF_PROBE: [(&str, &str); 6] = [
    ("x", "m"),
    ("y", "m"),
    ("rotation", "rad"),
    ("force_x", "N"),
    ("force_y", "N"),
    ("moment", "N m"),
];

/// The measures of a world: those that every world has, those of its scene, and those of its probes.
#[must_use]
pub fn columns(world: &World) -> Vec<Column> {
    let of = |(name, unit): (&str, &'static str)| Column { name: name.to_owned(), unit };
    let named = world.resource::<NamedMeasures>().list.iter();
    let named = named.map(|(name, quantity)| Column {
        name: name.clone(),
        unit: shown(quantity.as_ref().map_or("", Quantity::unit), quantity.as_ref()),
    });
    let probes = world.resource::<Observation>().probes.iter();
    let probes = probes.flat_map(|probe| {
        OF_PROBE.map(|(what, unit)| Column { name: format!("{}.{what}", probe.name), unit })
    });
    ALWAYS.into_iter().map(of).chain(named).chain(probes).collect()
}

/// Values of the [`columns`] after the last increment.
#[must_use]
pub fn row(world: &World, frame: &Frame) -> Vec<Option<f64>> {
    let now = world.resource::<Observation>();
    let percent = |strain: Option<f64>| strain.map(|strain| 100.0 * strain);
    let number = |n: usize| Some(n as f64);
    let always: [Option<f64>; ALWAYS.len()] = [
        Some(frame.increment as f64),
        Some(frame.time_s),
        percent(now.axial_strain),
        percent(now.lateral_strain),
        percent(now.volumetric_strain),
        now.axial_stress,
        now.lateral_stress,
        Some(now.kinetic_energy),
        number(now.contacts),
        number(now.bonds),
        number(now.broken[0]),
        number(now.broken[1]),
        coordination(frame),
    ];
    let named = &world.resource::<NamedMeasures>().list;
    let readings = &world.resource::<Readings>().0;
    let named = named.iter().enumerate().map(|(k, (_, quantity))| {
        let reading = readings.get(k).copied().flatten();
        if is_strain(quantity.as_ref()) { percent(reading) } else { reading }
    });
    let probes = now.probes.iter().flat_map(|probe| {
        let [x, y, rotation] = probe.motion;
        let [force_x, force_y, moment] = probe.force;
        [x, y, rotation, force_x, force_y, moment].map(Some)
    });
    always.into_iter().chain(named).chain(probes).collect()
}

/// Mean number of pairs with force per disk.
fn coordination(frame: &Frame) -> Option<f64> {
    let disks = frame.bodies.id.len();
    let ends = (0..frame.pairs.a.len()).filter(|k| frame.pairs.p_n[*k] != 0.0);
    let ends: usize = ends.map(|k| 1 + usize::from(frame.row(frame.pairs.b[k]).is_some())).sum();
    (disks > 0).then(|| ends as f64 / disks as f64)
}

fn is_strain(quantity: Option<&Quantity>) -> bool {
    matches!(quantity, Some(Quantity::Strain(_) | Quantity::VolumetricStrain))
}

fn shown(unit: &'static str, quantity: Option<&Quantity>) -> &'static str {
    if is_strain(quantity) { "%" } else { unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_after_a_state_to_which_the_world_goes_back_are_forgotten() {
        let columns =
            [Column { name: "x".into(), unit: "" }, Column { name: "y".into(), unit: "" }];
        let mut series = Series::default();
        for k in 1..=5 {
            series.add(&columns, k, vec![Some(k as f64), (k > 1).then_some(7.0)]);
        }
        assert_eq!(series.curve(0, 1).len(), 4, "the first row has no y");
        series.add(&columns, 3, vec![Some(30.0), Some(8.0)]);
        assert_eq!(series.curve(0, 1), [[2.0, 7.0], [30.0, 8.0]]);
    }
}
