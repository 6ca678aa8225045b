//! The class `Simulation` of `clastic._engine`. `clastic/simulation.py` has the one for users.

use std::path::PathBuf;

use clastic::components::contact::BodyTable;
use clastic::components::increment::{ClasticAnalysis, ClasticProgress};
use clastic::frames::Frame;
use clastic::output::run_record::RunFacts;
use clastic::run::minerals::specimen;
use clastic::run::stages::Script;
use clastic::run::{Outcome, end_stage};
use clastic::saved;
use glam::DVec2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{dictionary, row, shaped};
use crate::changes::{Columns, Control, Fields};
use crate::errors::Error;
use crate::loads::LoadFunction;
use crate::model::{Model, Wanted, read, warnings};
use crate::worker::Worker;

/// Reads a scene. Returns what it has, and warnings.
#[pyfunction]
pub fn check<'py>(
    py: Python<'py>,
    scene: String,
    is_text: bool,
    sets: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let wanted = Wanted { scene, is_text, sets, ..Wanted::default() };
    let read = py.detach(|| {
        let loaded = read(&wanted)?;
        let particles = specimen(&loaded.scene, loaded.specimen.as_ref()).len();
        let warnings = warnings(&loaded);
        let stored = RunFacts::new(&loaded, &[])?.specimen_sha256;
        Ok((loaded, particles, warnings, stored))
    });
    let (loaded, particles, warnings, stored) = read.map_err(|error: Error| error.raise(py))?;
    let scene = &loaded.scene;
    let found = PyDict::new(py);
    found.set_item("title", &scene.title)?;
    found.set_item("particles", particles)?;
    found.set_item("walls", scene.walls.iter().map(|w| w.name.clone()).collect::<Vec<_>>())?;
    let stages: Vec<_> = scene.stages.iter().map(|stage| stage.name().to_owned()).collect();
    found.set_item("stages", stages)?;
    found.set_item("warnings", warnings)?;
    found.set_item("text", &loaded.text)?;
    found.set_item("specimen_sha256", stored)?;
    Ok(found)
}

/// A simulation that Python steps.
#[pyclass(frozen, module = "clastic._engine")]
pub struct Simulation {
    worker: Worker,
}

/// A column of the particles.
#[derive(Clone, Copy)]
enum Column {
    Scalars(fn(&BodyTable) -> Vec<f64>),
    Vectors(fn(&BodyTable) -> &Vec<DVec2>),
}

fn column(name: &str) -> Option<Column> {
    Some(match name {
        "positions" => Column::Vectors(|b| &b.positions),
        "velocities" => Column::Vectors(|b| &b.velocities),
        "rotations" => Column::Scalars(|b| b.rotations.clone()),
        "angular_velocities" => Column::Scalars(|b| b.angular_velocities.clone()),
        "radii" => Column::Scalars(|b| b.radii.clone()),
        "masses" => Column::Scalars(|b| b.masses.clone()),
        _ => return None,
    })
}

#[pymethods]
impl Simulation {
    #[new]
    fn new(
        py: Python,
        scene: String,
        is_text: bool,
        sets: Vec<String>,
        out: Option<PathBuf>,
        force: bool,
        checkpoint_every: u32,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let wanted = Wanted { scene, is_text, sets, out, force, checkpoint_every };
        let worker = Worker::start(py, threads, move || Model::begin(&wanted))?;
        Ok(Self { worker })
    }

    /// A simulation that goes on from a state.
    #[staticmethod]
    fn restored(py: Python, state: Vec<u8>, threads: Option<usize>) -> PyResult<Self> {
        let worker = Worker::start(py, threads, move || Model::restored(&state))?;
        Ok(Self { worker })
    }

    /// Makes an increment and returns its row; `None` once the run has ended.
    fn step<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let (line, columns) =
            self.worker.attempt(py, |model| Ok((model.step()?, model.columns.clone())))?;
        line.map(|line| row(py, &columns, &line)).transpose()
    }

    /// How the run ended, once it has: status, stage, increment, message.
    fn outcome<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(outcome) = self.worker.call(py, |model| model.outcome.clone())? else {
            return Ok(None);
        };
        let (status, stage, increment, message) = match outcome {
            Outcome::Completed => ("completed", None, None, None),
            Outcome::Collapsed(c) => {
                ("collapsed", Some(c.stage), Some(c.increment), Some(c.reason))
            }
            Outcome::Undecided { increment, message } => {
                ("undecided", None, Some(increment), Some(message))
            }
            Outcome::Halted(message) => ("halted", None, None, Some(message)),
            Outcome::Refused { stage, message } => ("refused", Some(stage), None, Some(message)),
        };
        let found = PyDict::new(py);
        found.set_item("status", status)?;
        found.set_item("stage", stage)?;
        found.set_item("increment", increment)?;
        found.set_item("message", message)?;
        Ok(Some(found))
    }

    /// Ends the output of a run. Returns warnings.
    fn finish(&self, py: Python) -> PyResult<Vec<String>> {
        self.worker.attempt(py, Model::finish)
    }

    /// Warnings of the scene before it runs.
    fn warnings(&self, py: Python) -> PyResult<Vec<String>> {
        self.worker.call(py, |model| warnings(&model.loaded))
    }

    /// Text of the scene with its settings and added stages.
    fn text(&self, py: Python) -> PyResult<String> {
        self.worker.call(py, |model| model.loaded.text.clone())
    }

    /// Names of the stages.
    fn stages(&self, py: Python) -> PyResult<Vec<String>> {
        self.worker.call(py, |model| {
            let stages = &model.loaded.scene.stages;
            stages.iter().map(|stage| stage.name().to_owned()).collect()
        })
    }

    /// Stage, its increments that are done, and all of them.
    fn progress(&self, py: Python) -> PyResult<(String, f64, f64)> {
        self.worker.call(py, |model| {
            let progress = model.simulation.world().resource::<ClasticProgress>();
            (progress.stage_name.clone(), progress.done, progress.total)
        })
    }

    /// Time, s.
    fn time(&self, py: Python) -> PyResult<f64> {
        self.worker.call(py, |model| model.simulation.world().resource::<ClasticProgress>().time)
    }

    /// Identities of the particles, an array (n).
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ids: Vec<u32> = self.worker.call(py, |model| {
            let bodies = model.bodies();
            bodies.ids[..bodies.particles].iter().map(|id| id.0).collect()
        })?;
        let n = ids.len();
        shaped(py, ids, &[n])
    }

    /// A column of the particles, an array (n) or (n, 2).
    fn particles<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let Some(wanted) = column(name) else {
            return Err(Error::Value(format!("no column `{name}`")).raise(py));
        };
        let (values, width) = self.worker.call(py, move |model| {
            let bodies = model.bodies();
            let n = bodies.particles;
            match wanted {
                Column::Scalars(of) => (of(bodies)[..n].to_vec(), 1),
                Column::Vectors(of) => {
                    (of(bodies)[..n].iter().flat_map(|x| x.to_array()).collect(), 2)
                }
            }
        })?;
        let n = values.len() / width;
        if width == 1 { shaped(py, values, &[n]) } else { shaped(py, values, &[n, 2]) }
    }

    /// All arrays of a saved state whose names begin so.
    fn arrays<'py>(&self, py: Python<'py>, prefix: String) -> PyResult<Bound<'py, PyDict>> {
        let tables = self.worker.attempt(py, move |model| {
            let all = saved::save(model.world())?;
            let mut some = clastic::tables::Tables::default();
            for (name, array) in all.iter().filter(|(name, _)| name.starts_with(&prefix)) {
                some.put(name, array.clone());
            }
            Ok(some)
        })?;
        dictionary(py, tables)
    }

    /// A frame, as the files of a run have them.
    fn frame<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let tables = self.worker.call(py, |model| {
            model.bodies();
            Frame::take(model.world()).tables()
        })?;
        dictionary(py, tables)
    }

    /// Writes a saved state, from which a scene can start.
    fn write(&self, py: Python, path: PathBuf) -> PyResult<()> {
        self.worker.attempt(py, move |model| {
            let bytes = saved::save(model.world())?.encode();
            let bytes = bytes.map_err(|error| Error::Engine(error.to_string()))?;
            let failed = |error| Error::Files(format!("{}: {error}", path.display()));
            std::fs::write(&path, bytes).map_err(failed)
        })
    }

    fn save(&self, py: Python) -> PyResult<Vec<u8>> {
        self.worker.attempt(py, Model::save)
    }

    fn restore(&self, py: Python, state: Vec<u8>) -> PyResult<()> {
        self.worker.attempt(py, move |model| model.restore(&state))
    }

    fn stage(&self, py: Python, stage: String) -> PyResult<()> {
        self.worker.attempt(py, move |model| model.add_stage(&stage))
    }

    /// Ends the stage that is under way after the last increment.
    fn end_stage(&self, py: Python) -> PyResult<()> {
        self.worker.call(py, |model| {
            let world = model.world();
            if world.resource::<Script>().begun {
                end_stage(world);
            }
        })
    }

    /// Gravity, m/s^2, and the factor on all strengths.
    fn analysis(&self, py: Python) -> PyResult<((f64, f64), f64)> {
        self.worker.call(py, |model| {
            let analysis = model.simulation.world().resource::<ClasticAnalysis>();
            (analysis.gravity.into(), analysis.strength)
        })
    }

    fn set_gravity(&self, py: Python, gravity: (f64, f64)) -> PyResult<()> {
        self.worker.call(py, move |model| {
            model.world().resource_mut::<ClasticAnalysis>().gravity = gravity.into();
        })
    }

    fn set_strength(&self, py: Python, factor: f64) -> PyResult<()> {
        self.worker.call(py, move |model| {
            model.world().resource_mut::<ClasticAnalysis>().strength = factor;
        })
    }

    fn set_contact(&self, py: Python, of: String, fields: Fields) -> PyResult<()> {
        self.worker.attempt(py, move |model| model.change_contact(&of, &fields))
    }

    fn set_bonds(&self, py: Python, ids: Option<Vec<u32>>, columns: Columns) -> PyResult<()> {
        self.worker.attempt(py, move |model| model.change_bonds(ids.as_deref(), &columns))
    }

    fn set_wall(
        &self,
        py: Python,
        name: String,
        kind: String,
        values: Vec<f64>,
        between: Option<(String, String)>,
    ) -> PyResult<()> {
        let control = match (kind.as_str(), values.as_slice()) {
            ("fixed", []) => Control::Fixed,
            ("displacement", [x, y]) => Control::Displacement(DVec2::new(*x, *y)),
            ("velocity", [x, y]) => Control::Velocity(DVec2::new(*x, *y)),
            ("rotation", [x, y, angle]) => Control::Rotation(DVec2::new(*x, *y), *angle),
            ("force", [force]) => Control::Force(*force),
            ("stress", [stress]) => Control::Stress(*stress, between),
            _ => {
                let what = format!("a wall has no control `{kind}` of {} numbers", values.len());
                return Err(Error::Value(what).raise(py));
            }
        };
        self.worker.attempt(py, move |model| model.control_wall(&name, &control))
    }

    fn load(&self, py: Python, ids: Vec<u32>, loads: Vec<[f64; 3]>) -> PyResult<()> {
        self.worker.attempt(py, move |model| model.load(&ids, &loads))
    }

    fn drive(&self, py: Python, ids: Vec<u32>, motions: Vec<[f64; 3]>) -> PyResult<()> {
        self.worker.attempt(py, move |model| model.drive(&ids, &motions))
    }

    fn remove(&self, py: Python, ids: Vec<u32>) -> PyResult<()> {
        self.worker.attempt(py, move |model| model.remove(&ids))
    }

    fn add(&self, py: Python, disks: Vec<[f64; 5]>, material: String) -> PyResult<Vec<u32>> {
        self.worker.attempt(py, move |model| model.add(&disks, &material))
    }

    fn cement(&self, py: Python, pairs: Vec<(u32, u32)>) -> PyResult<Vec<u32>> {
        self.worker.attempt(py, move |model| model.cement(&pairs))
    }

    fn remove_bonds(&self, py: Python, ids: Vec<u32>) -> PyResult<()> {
        self.worker.attempt(py, move |model| model.remove_bonds(&ids))
    }

    /// The function of loads; `None` takes it away.
    fn set_load_function(&self, py: Python, function: Option<Py<PyAny>>) -> PyResult<()> {
        self.worker.call(py, move |model| match function {
            Some(function) => model.world().insert_resource(LoadFunction(function)),
            None => {
                model.world().remove_resource::<LoadFunction>();
            }
        })
    }
}
