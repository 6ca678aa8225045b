//! The rigs of the benchmark: scenes of `scenes/`, with settings.

use std::path::{Path, PathBuf};

use clastic::scene::format::{Scene, Stage};
use clastic::scene::{LoadError, LoadedScene, load};

use crate::BenchError;
use crate::specimens::Boxed;

/// Where the scenes lie.
#[derive(Clone, Debug)]
pub struct Scenes {
    directory: PathBuf,
}

/// The elastic rock of `uniaxial.ron` for the scenes of rigid rock, which read stored packings.
const ROCK: [&str; 5] = [
    "materials.rock.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
    "materials.rock.bond=(normal_stiffness: 7.9e10, tangential_stiffness: 7.9e10, friction: 0.8, \
     cohesion: 195.0e6, tensile_strength: 144.0e6)",
    "walls.bottom.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
    "walls.top.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
    "acceptance=(turn: 1.0)",
];

impl Scenes {
    /// The scenes of a directory.
    #[must_use]
    pub fn new(directory: &Path) -> Self {
        Self { directory: directory.to_owned() }
    }

    /// A scene by name, with settings.
    ///
    /// # Errors
    /// If it is missing or has errors.
    pub fn load(&self, name: &str, sets: &[&str]) -> Result<LoadedScene, LoadError> {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        load(&self.directory.join(format!("{name}.ron")), &sets)
    }

    /// Uniaxial compression of rock from a stored packing, 400 or 7380 disks, 0.005 % an
    /// increment, until the stress is below 40 % of its peak.
    ///
    /// # Errors
    /// See [`load`](Self::load).
    pub fn uniaxial(&self, full: bool, increments: u32) -> Result<LoadedScene, LoadError> {
        let count = format!("stages.load.increments={increments}");
        let mut sets = ROCK.to_vec();
        sets.extend([&count, "stages.load.stop=[StressDrop(0.4)]"]);
        self.load(if full { "uniaxial_rigid" } else { "uniaxial_rigid_small" }, &sets)
    }

    /// The specimen of [`uniaxial`](Self::uniaxial) in its box.
    ///
    /// # Errors
    /// See [`load`](Self::load).
    pub fn rock(&self, full: bool) -> Result<Boxed, LoadError> {
        let loaded = self.uniaxial(full, 1)?;
        let (width, height) = (loaded.scene.walls[0].end.0, loaded.scene.walls[1].start.1);
        Ok(Boxed { specimen: loaded.specimen.unwrap_or_default(), width, height })
    }

    /// Uniaxial compression of a specimen in a box, elastic, 0.005 % an increment.
    ///
    /// # Errors
    /// See [`load`](Self::load).
    pub fn compression_of(&self, boxed: Boxed, increments: u32) -> Result<LoadedScene, LoadError> {
        let mut loaded = self.uniaxial(false, increments)?;
        let (w, h) = (boxed.width, boxed.height);
        let places = [
            [(0.0, 0.0), (w, 0.0)],
            [(w, h), (0.0, h)],
            [(0.0, h), (0.0, 0.0)],
            [(w, 0.0), (w, h)],
        ];
        for (wall, [start, end]) in loaded.scene.walls.iter_mut().zip(places) {
            (wall.start, wall.end) = (start, end);
        }
        set_motion(&mut loaded.scene, "top", -5e-5 * h);
        loaded.specimen = Some(boxed.specimen);
        Ok(loaded)
    }

    /// Biaxial compression of cemented sand with rolling resistance, 400 or 6160 disks.
    ///
    /// # Errors
    /// See [`load`](Self::load).
    pub fn biaxial(&self, full: bool, sets: &[&str]) -> Result<LoadedScene, LoadError> {
        self.load(if full { "biaxial_50kPa" } else { "biaxial_small" }, sets)
    }

    /// Collapse of a column under the associated law, 300 or 2000 disks.
    ///
    /// # Errors
    /// See [`load`](Self::load).
    pub fn collapse(&self, full: bool) -> Result<LoadedScene, LoadError> {
        let name = if full { "column_collapse" } else { "column_collapse_small" };
        self.load(name, &["friction_law=Associated", "acceptance.residual=1e-8"])
    }
}

/// Sets the motion of a wall along y in every increment, m, in the stages that move it.
pub(crate) fn set_motion(scene: &mut Scene, wall: &str, motion: f64) {
    use clastic::scene::format::WallControl::Displacement;
    for stage in &mut scene.stages {
        if let Stage::Load(load) = stage
            && let Some(Displacement(_, y)) = load.walls.get_mut(wall)
        {
            *y = motion;
        }
    }
}

/// Number of increments of the last stage and the factor on its wall motions: the same path in
/// increments `factor` times as large.
pub(crate) fn scale_increments(scene: &mut Scene, factor: f64) -> Result<(), BenchError> {
    use clastic::scene::format::WallControl::Displacement;
    let Some(Stage::Load(load)) = scene.stages.last_mut() else {
        return Err(BenchError::Run("the last stage of the rig loads nothing".to_owned()));
    };
    load.increments = (f64::from(load.increments) / factor).ceil() as u32;
    for control in load.walls.values_mut() {
        if let Displacement(x, y) = control {
            *x *= factor;
            *y *= factor;
        }
    }
    Ok(())
}
