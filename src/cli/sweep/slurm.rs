//! A job array for Slurm, one task per run.

use std::fmt::Write as _;
use std::path::Path;

use super::Sweep;

/// The script for `sbatch`. Each task makes one run, as `clastic sweep STUDY --only N` does.
pub(crate) fn job_array(study: &Path, sweep: &Sweep, out: Option<&Path>) -> String {
    let out = out.map_or(String::new(), |out| format!(" --out {}", quoted(out)));
    let runs = sweep.plan.runs.len();
    let mut text = format!(
        "#!/bin/sh\n\
         # Submit with `sbatch`. When all tasks have ended, `clastic sweep {study}{out} --collect` writes the table.\n\
         # A task that was killed continues from its checkpoint when it is queued again.\n\
         #SBATCH --job-name={name}\n\
         #SBATCH --array=1-{runs}\n\
         #SBATCH --ntasks=1\n\
         #SBATCH --cpus-per-task=1\n\
         #SBATCH --requeue\n\
         # Slurm sends SIGTERM a minute before the end, and the run writes its checkpoint.\n\
         #SBATCH --signal=B:TERM@60\n",
        study = quoted(study),
        name = sweep.folder.file_name().unwrap_or_default().to_string_lossy(),
    );
    for (k, run) in sweep.plan.runs.iter().enumerate() {
        let _ = writeln!(text, "# {}: {} ({})", k + 1, run.label(&sweep.plan.names), run.directory);
    }
    let _ = write!(
        text,
        "exec clastic sweep {study}{out} --only \"$SLURM_ARRAY_TASK_ID\" --jobs 1",
        study = quoted(study),
    );
    text
}

/// A path in single quotes for the shell.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', "'\\''"))
}
