//! Scenes that are part of the program, with the specimens that they name. An installed `clastic`
//! finds them from any directory.

use std::path::{Path, PathBuf};

/// Directory of the shipped scenes in messages. It exists in no file system.
const DIRECTORY: &str = "<clastic>/scenes";

macro_rules! files {
    ($($name:literal)*) => {
        [$(($name, include_bytes!(concat!("../../scenes/", $name)).as_slice())),*]
    };
}

/// Every file of `scenes/` by its path in that directory.
static FILES: &[(&str, &[u8])] = &files! {
    "acoustic_emission.ron" "angle_of_repose.ron" "biaxial_0kPa.ron" "biaxial_100kPa.ron"
    "biaxial_10kPa.ron" "biaxial_10kPa_letter.ron" "biaxial_50kPa.ron" "biaxial_membrane.ron"
    "biaxial_membrane_small.ron" "biaxial_periodic_constant_mean.ron" "biaxial_small.ron"
    "bounce.ron" "brazilian.ron" "cemented_under_load.ron" "column_collapse.ron"
    "column_collapse_small.ron" "direct_shear_-10N.ron" "direct_shear_0N.ron" "direct_shear_10N.ron"
    "direct_tension.ron" "footing.ron" "gate_under_moment.ron" "hopper.ron" "incline_held.ron"
    "incline_rests.ron" "incline_rolls.ron" "incline_rolls_with_resistance.ron" "incline_slips.ron"
    "isotropic_compression.ron" "lattice.ron" "notched_beam.ron" "oedometer.ron" "outflow.ron"
    "poured_bin.ron" "prepare_and_branch.ron" "prepare_and_branch_100kPa.ron"
    "prepare_and_branch_200kPa.ron" "prepare_and_branch_50kPa.ron" "prepare_biaxial.ron"
    "prepare_biaxial_small.ron" "radius_expansion.ron" "retaining_wall.ron" "rolling.ron"
    "rotating_drum.ron" "rotating_drum_small.ron" "scatter.ron" "shear_box.ron" "sieve_curve.ron"
    "simple_shear_periodic.ron" "simple_shear_periodic_undrained.ron" "slope.ron" "slope_block.ron"
    "stack.ron" "tension.ron" "three_point_bending.ron" "tunnel.ron" "tunnel_lining.ron"
    "turning_gate.ron" "two_layers.ron" "uniaxial.ron" "uniaxial_as_printed.ron"
    "uniaxial_rigid.ron" "uniaxial_rigid_small.ron" "uniaxial_small.ron" "unload_reload.ron"
    "specimens/biaxial_400.csv" "specimens/biaxial_6160.csv" "specimens/branch_200.npz"
    "specimens/slope_ground.npz" "specimens/uniaxial_400.csv" "specimens/uniaxial_7380.csv"
};

/// Names of the shipped scenes.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().filter_map(|(name, _)| name.strip_suffix(".ron"))
}

/// Path under which a shipped scene can be [loaded](super::load()).
pub fn path(name: &str) -> Option<PathBuf> {
    names().any(|known| known == name).then(|| Path::new(DIRECTORY).join(format!("{name}.ron")))
}

/// Content of a shipped file.
pub(super) fn content(path: &Path) -> Option<&'static [u8]> {
    let inside = path.strip_prefix(DIRECTORY).ok()?;
    FILES.iter().find(|(name, _)| inside == Path::new(name)).map(|(_, content)| *content)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn every_file_of_scenes_is_shipped() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let mut found = Vec::new();
        for folder in [root.clone(), root.join("specimens")] {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_file() {
                    let name = path.strip_prefix(&root).unwrap().to_string_lossy().into_owned();
                    found.push((name, fs::read(path).unwrap()));
                }
            }
        }
        found.sort();
        let mut shipped: Vec<_> =
            FILES.iter().map(|(name, text)| ((*name).to_owned(), text.to_vec())).collect();
        shipped.sort();
        let names =
            |list: &[(String, Vec<u8>)]| list.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
        assert_eq!(names(&shipped), names(&found));
        assert!(shipped == found, "build again: a file has changed");
    }
}
