//! Fields of the disks, and their colours. Definitions and colours are those of the engine's
//! figures.

use std::collections::BTreeMap;

use bevy::color::LinearRgba;
use clastic::frames::{Frame, NONE, strains};
use glam::DVec2;

use super::Shown;
use super::colours::{Legend, Sample, colour};
use super::scale::{KINDS, Scale};

/// What the colours of the disks mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Field {
    /// Material.
    #[default]
    Material,
    /// Magnitude of the displacement since the reference, m.
    Displacement,
    /// Rotation since the reference, rad, anticlockwise positive.
    Rotation,
    /// Maximum shear strain since the reference, %.
    ShearStrain,
    /// Volumetric strain since the reference, %, contraction positive.
    VolumetricStrain,
    /// Speed, m/s. Static stages leave it as it is.
    Speed,
    /// Mean stress of the disk, Pa, compression positive.
    MeanStress,
    /// Maximum shear stress of the disk, Pa.
    ShearStress,
    /// Number of contacts and bonds with force.
    Coordination,
    /// Fragment: disks that intact bonds hold together.
    Fragment,
}

impl Field {
    /// All fields, in the order in which a key goes through them.
    pub const ALL: [Self; 10] = [
        Self::Material,
        Self::Displacement,
        Self::Rotation,
        Self::ShearStrain,
        Self::VolumetricStrain,
        Self::Speed,
        Self::MeanStress,
        Self::ShearStress,
        Self::Coordination,
        Self::Fragment,
    ];

    /// The field after this one, or before it.
    #[must_use]
    pub fn next(self, back: bool) -> Self {
        let n = Self::ALL.len();
        let at = Self::ALL.iter().position(|field| *field == self).unwrap_or(0);
        Self::ALL[(at + if back { n - 1 } else { 1 }) % n]
    }
}

/// Colours of materials and of few contacts, pale so that strokes stand out.
const PALE: [&str; 8] =
    ["#f3f1ec", "#9ecae1", "#fdcf9c", "#b5dfae", "#d4c5e8", "#e8dc96", "#c4c4c4", "#e3b8c4"];
/// Colours of 0 to 6 contacts and more.
const CONTACTS: [&str; 7] =
    ["#ffffff", "#fee391", "#fec44f", "#c8d5de", "#90afca", "#5684b2", "#2b547e"];
/// Colours of the largest fragment, and of disks alone.
const FRAGMENTS: [&str; 2] = ["#d9d9d9", "#ffffff"];
/// Colour of a disk that has no value.
const NO_VALUE: &str = "#ffffff";

/// Colours of all disks of a picture, and their legend.
#[must_use]
pub fn colouring(shown: &Shown, field: Field) -> (Vec<LinearRgba>, Legend) {
    let (now, since) = (&shown.now.frame, &shown.since.frame);
    match field {
        Field::Material => materials(now),
        Field::Displacement => {
            let moved = changes(now, since, |frame, row| {
                let [x, y] = frame.bodies.displacement_m[row];
                DVec2::new(f64::from(x), f64::from(y))
            });
            let values: Vec<_> = moved.into_iter().map(|u| u.map(DVec2::length)).collect();
            magnitudes(&values, "displacement", "m")
        }
        Field::Rotation => {
            let turned =
                changes(now, since, |frame, row| f64::from(frame.bodies.rotation_rad[row]));
            scaled(&turned, &Scale::of_signed(&there(&turned), "rotation, anticlockwise +", "rad"))
        }
        Field::ShearStrain => {
            let strains = strains(&now.disks(), &since.disks());
            let values: Vec<_> = strains.into_iter().map(|s| Some(100.0 * s?.shear)).collect();
            magnitudes(&values, "maximum shear strain", "%")
        }
        Field::VolumetricStrain => {
            let strains = strains(&now.disks(), &since.disks());
            let values: Vec<_> = strains.into_iter().map(|s| Some(100.0 * s?.volumetric)).collect();
            let name = "volumetric strain, contraction +";
            scaled(&values, &Scale::of_signed(&there(&values), name, "%"))
        }
        Field::Speed => {
            let speed = |[x, y]: &[f32; 2]| Some(f64::from(x.hypot(*y)));
            let values: Vec<_> = now.bodies.velocity_m_s.iter().map(speed).collect();
            magnitudes(&values, "speed", "m/s")
        }
        Field::MeanStress => mean_stress(now),
        Field::ShearStress => {
            let shear = |[xx, yy, xy]: &[f32; 3]| Some(f64::from((0.5 * (xx - yy)).hypot(*xy)));
            let values: Vec<_> = now.bodies.stress_pa.iter().map(shear).collect();
            magnitudes(&values, "maximum shear stress of a disk", "Pa")
        }
        Field::Coordination => coordination(now),
        Field::Fragment => fragments(now),
    }
}

/// Change of a value of every disk since another frame; `None` for disks that were not there.
fn changes<T: std::ops::Sub<Output = T>>(
    now: &Frame,
    since: &Frame,
    of: impl Fn(&Frame, usize) -> T,
) -> Vec<Option<T>> {
    let ids = now.bodies.id.iter().enumerate();
    ids.map(|(row, id)| Some(of(now, row) - of(since, since.row(*id)?))).collect()
}

fn there(values: &[Option<f64>]) -> Vec<f64> {
    values.iter().flatten().copied().collect()
}

fn magnitudes(values: &[Option<f64>], name: &str, unit: &'static str) -> (Vec<LinearRgba>, Legend) {
    scaled(values, &Scale::of_magnitudes(&there(values), name, unit))
}

fn scaled(values: &[Option<f64>], scale: &Scale) -> (Vec<LinearRgba>, Legend) {
    let palette: Vec<LinearRgba> = scale.colors.iter().map(|hex| colour(hex)).collect();
    let none = colour(NO_VALUE);
    let colours = values.iter().map(|value| value.map_or(none, |v| palette[scale.class(v)]));
    let (numbers, name) = scale.labels();
    let legend =
        Legend { name, scale: scale.colors.to_vec(), numbers: Some(numbers), samples: Vec::new() };
    (colours.collect(), legend)
}

/// Few disks are in tension where a specimen is pressed.
fn mean_stress(now: &Frame) -> (Vec<LinearRgba>, Legend) {
    let mean = |[xx, yy, _]: &[f32; 3]| Some(0.5 * f64::from(xx + yy));
    let values: Vec<_> = now.bodies.stress_pa.iter().map(mean).collect();
    let all = there(&values);
    let [low, high] = [f64::min, f64::max].map(|of| all.iter().copied().fold(0.0, of));
    let name = "mean stress of a disk, compression +";
    let scale = match low < -0.02 * high {
        true => Scale::of_signed(&all, name, "Pa"),
        false => Scale::of_magnitudes(&all, name, "Pa"),
    };
    scaled(&values, &scale)
}

fn materials(now: &Frame) -> (Vec<LinearRgba>, Legend) {
    let palette = PALE.map(colour);
    let of = |k: &u32| palette[*k as usize % PALE.len()];
    let colours = now.bodies.material.iter().map(of).collect();
    let sample = |(k, name): (usize, &String)| {
        let number = now.bodies.material.iter().filter(|m| **m as usize == k).count();
        let text = format!("{number} disks of {name}");
        (number > 0).then(|| Sample { colour: PALE[k % PALE.len()], text })
    };
    let samples = now.materials.iter().enumerate().filter_map(sample).collect();
    (colours, Legend { name: "material".into(), samples, ..Legend::default() })
}

fn coordination(now: &Frame) -> (Vec<LinearRgba>, Legend) {
    let counts = contacts(now);
    let palette = CONTACTS.map(colour);
    let last = CONTACTS.len() - 1;
    let colours = counts.iter().map(|n| palette[(*n).min(last)]).collect();
    let sample = |(n, colour): (usize, &'static str)| {
        let text = if n == last { format!("{n} and more") } else { n.to_string() };
        Sample { colour, text }
    };
    let samples = CONTACTS.into_iter().enumerate().map(sample).collect();
    let name = "contacts and bonds with force".into();
    (colours, Legend { name, samples, ..Legend::default() })
}

/// Number of contacts and bonds with force of every disk.
pub(crate) fn contacts(now: &Frame) -> Vec<usize> {
    let mut counts = vec![0; now.bodies.id.len()];
    let pairs = &now.pairs;
    for k in (0..pairs.a.len()).filter(|k| pairs.p_n[*k] != 0.0) {
        for row in [pairs.a[k], pairs.b[k]].into_iter().filter_map(|id| now.row(id)) {
            counts[row] += 1;
        }
    }
    counts
}

fn fragments(now: &Frame) -> (Vec<LinearRgba>, Legend) {
    let mut sizes: BTreeMap<u32, usize> = BTreeMap::new();
    for fragment in &now.bodies.fragment {
        *sizes.entry(*fragment).or_default() += 1;
    }
    let largest = sizes.iter().max_by_key(|(first, size)| (**size, std::cmp::Reverse(**first)));
    let largest = largest.map_or(NONE, |(first, size)| if *size > 1 { *first } else { NONE });
    let (kinds, few) = (KINDS.map(colour), FRAGMENTS.map(colour));
    // A fragment keeps its colour while its first disk is in it.
    let of = |fragment: &u32| match sizes[fragment] {
        1 => few[1],
        _ if *fragment == largest => few[0],
        _ => kinds[*fragment as usize % KINDS.len()],
    };
    let colours = now.bodies.fragment.iter().map(of).collect();
    let alone = sizes.values().filter(|size| **size == 1).count();
    let whole = sizes.len() - alone;
    let most = sizes.get(&largest).copied().unwrap_or(0);
    let samples = vec![
        Sample { colour: FRAGMENTS[0], text: format!("largest: {most} disks") },
        Sample { colour: KINDS[0], text: format!("{} more (colours recur)", whole.max(1) - 1) },
        Sample { colour: FRAGMENTS[1], text: format!("{alone} disks without intact bond") },
    ];
    (colours, Legend { name: "fragments".into(), samples, ..Legend::default() })
}
