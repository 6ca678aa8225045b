//! Names of the files of a run directory.

/// Facts about the run.
pub const RUN: &str = "run.json";
/// The scene as run.
pub const SCENE: &str = "scene.ron";
/// One row per increment.
pub const HISTORY: &str = "history.csv";
/// One row per rupture.
pub const EVENTS: &str = "events.csv";
/// One row per avalanche.
pub const AVALANCHES: &str = "avalanches.csv";
/// Wall-clock times.
pub const TIMINGS: &str = "timings.csv";
/// The prepared specimen.
pub const SPECIMEN: &str = "specimen.csv";
/// All particles at the end.
pub const FINAL_PARTICLES: &str = "final_particles.csv";
/// The state at the end.
pub const FINAL_STATE: &str = "final_state.npz";
/// The mechanism of the first collapse.
pub const MECHANISM: &str = "mechanism.csv";
/// The state between two increments, from which the run can continue.
pub const CHECKPOINT: &str = "checkpoint.bin";
/// The state of a run that has ended, from which more stages or increments continue.
pub const FINAL_CHECKPOINT: &str = "final_checkpoint.bin";
/// The run as a page for a browser.
pub const REPORT: &str = "report.html";
/// Directory of the frames.
pub const FRAMES: &str = "frames";
/// Frame before the first increment of the reference stage.
pub const FRAME_START: &str = "start.npz";
/// Frame at the peak.
pub const FRAME_PEAK: &str = "peak.npz";
/// Frame at the end.
pub const FRAME_END: &str = "end.npz";
