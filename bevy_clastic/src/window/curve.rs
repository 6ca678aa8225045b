//! The curve of a measure against another one.

use bevy::prelude::*;

use super::panel::{Part, Plot};
use super::plot::Chart;
use super::write;
use crate::draw::scale::with_unit;
use crate::engine::Measured;
use crate::picture::Series;

/// Measures of the curve by name: abscissa and ordinate.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Axes(pub [Option<String>; 2]);

/// What a curve shows where nothing else is chosen, the first that has values.
const FIRST: [&[&str]; 2] =
    [&["axial_strain", "time", "increment"], &["axial_stress", "kinetic_energy", "contacts"]];

impl Axes {
    /// Another measure that has values: the next one, or the one before.
    pub(super) fn next(&mut self, series: &Series, axis: usize, back: bool) {
        let names: Vec<&str> = (0..series.columns.len())
            .filter(|k| has_values(series, *k))
            .map(|k| series.columns[k].name.as_str())
            .collect();
        let Some(last) = names.len().checked_sub(1) else { return };
        let now = names.iter().position(|name| Some(*name) == self.0[axis].as_deref());
        let next = match (now, back) {
            (None, _) => 0,
            (Some(0), true) => last,
            (Some(k), true) => k - 1,
            (Some(k), false) => (k + 1) % (last + 1),
        };
        self.0[axis] = Some(names[next].to_owned());
    }
}

fn has_values(series: &Series, k: usize) -> bool {
    series.rows.iter().any(|(_, row)| row.get(k).is_some_and(Option::is_some))
}

/// A measure that varies: a static run has no time, and its grains no speed.
fn varies(series: &Series, k: usize) -> bool {
    let mut values = series.rows.iter().filter_map(|(_, row)| *row.get(k)?);
    let first = values.next();
    values.any(|value| Some(value) != first)
}

/// Measures that the user has chosen stay.
pub(super) fn choose(
    measured: Res<Measured>,
    mut axes: ResMut<Axes>,
    mut chosen: Local<[Option<String>; 2]>,
) {
    if !measured.is_changed() {
        return;
    }
    let series = &measured.0;
    for axis in 0..2 {
        // What was chosen here may give way to what comes later, as strains do.
        if axes.0[axis] != chosen[axis] {
            continue;
        }
        let of = |name: &&&str| {
            let k = series.columns.iter().position(|column| column.name == **name);
            k.is_some_and(|k| varies(series, k))
        };
        let best = FIRST[axis].iter().find(of).map(|name| (*name).to_owned());
        if best.is_some() && best != axes.0[axis] {
            axes.0[axis].clone_from(&best);
        }
        chosen[axis].clone_from(&axes.0[axis]);
    }
}

pub(super) fn show(
    measured: Res<Measured>,
    axes: Res<Axes>,
    plot: Single<&ImageNode, With<Plot>>,
    mut images: ResMut<Assets<Image>>,
    mut texts: Query<(&Part, &mut Text)>,
) {
    if !measured.is_changed() && !axes.is_changed() {
        return;
    }
    let series = &measured.0;
    let column = |axis: usize| {
        let name = axes.0[axis].as_ref()?;
        series.columns.iter().position(|column| column.name == *name)
    };
    let chart = column(0).zip(column(1)).and_then(|(x, y)| {
        let chart = Chart::of(series.curve(x, y))?;
        Some((chart, [x, y]))
    });
    let mut labels = ["no curve yet: press space".to_owned(), String::new()];
    if let Some(mut image) = images.get_mut(&plot.image) {
        match &chart {
            Some((chart, _)) => image.data = Some(chart.pixels()),
            None => image.data.iter_mut().flatten().for_each(|byte| *byte = u8::MAX),
        }
    }
    if let Some((chart, columns)) = chart {
        let last = chart.points.last().copied().unwrap_or_default();
        labels = [1, 0].map(|axis| {
            let column = &series.columns[columns[axis]];
            let shown = |value: f64| with_unit(value, column.unit).trim_end().to_owned();
            let [low, high, step] = [chart.low[axis], chart.high[axis], chart.grid[axis]];
            format!(
                "{}: now {}\n    {} to {}, grid {}",
                column.name,
                shown(last[axis]),
                shown(low),
                shown(high),
                shown(step)
            )
        });
    }
    for (part, mut text) in &mut texts {
        match part {
            Part::Ordinate => write(&mut text, &labels[0]),
            Part::Abscissa => write(&mut text, &labels[1]),
            _ => {}
        }
    }
}
