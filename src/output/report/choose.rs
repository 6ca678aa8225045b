//! Selects the frames of a page: all of them, or the most informative ones of a longer run.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::frames::{self, Frame};
use crate::output::{OutputError, directory};

use super::run::Run;

/// Number of the largest ruptures whose frames are always chosen.
const EVENTS: usize = 10;

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// Increment after which it was taken.
    pub increment: u64,
    /// Whether it is that of the start, the peak or the end.
    pub is_always: bool,
    pub is_start: bool,
    pub path: PathBuf,
}

/// Frames of a run in the order of increments, one for each.
pub fn files(directory: &Path) -> Result<Vec<File>, OutputError> {
    let mut files: Vec<File> = Vec::new();
    for path in frames::list(directory)? {
        let name = path.file_stem().and_then(|name| name.to_str()).unwrap_or_default();
        let number = name.strip_prefix("frame_").and_then(|number| number.parse().ok());
        let increment = match number {
            Some(number) => number,
            None => Frame::read(&path)?.increment,
        };
        let is_always = directory::OF_MOMENTS.iter().any(|name| path.ends_with(name));
        let is_start = path.ends_with(directory::FRAME_START);
        files.push(File { increment, is_always, is_start, path });
    }
    files.sort_by_key(|file| file.increment);
    // Of two files of one increment the first stays.
    files.dedup_by(|next, first| {
        let is_same = next.increment == first.increment;
        first.is_always |= is_same && next.is_always;
        first.is_start |= is_same && next.is_start;
        is_same
    });
    Ok(files)
}

/// At most `most` frames: the first and the last, those of start, peak and end, those after the
/// increments in which most bonds broke, and others spread evenly over the axial strain, or over
/// the increments where the scene defines no strain.
pub fn choose(files: &[File], run: &Run, most: usize) -> Vec<File> {
    if files.len() <= most {
        return files.to_vec();
    }
    let is_always = |k: &usize| files[*k].is_always || *k == 0 || k + 1 == files.len();
    let mut chosen: BTreeSet<usize> = (0..files.len()).filter(is_always).collect();
    let mut largest: Vec<_> = run.ruptures.iter().map(|(n, bonds)| (*bonds, *n)).collect();
    largest.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    for (_, increment) in largest.into_iter().take(EVENTS) {
        let after = files.partition_point(|file| file.increment < increment);
        chosen.extend(Some(after).filter(|k| *k < files.len()));
    }
    // The next one is always that in the middle of the widest gap of the run's progress.
    let progress = progress(files, run);
    while chosen.len() < most {
        let at: Vec<usize> = chosen.iter().copied().collect();
        let widest = at.windows(2).filter(|ends| ends[1] > ends[0] + 1).max_by(|x, y| {
            let width = |ends: &[usize]| progress[ends[1]] - progress[ends[0]];
            width(x).total_cmp(&width(y)).then(y[0].cmp(&x[0]))
        });
        let Some(&[from, to]) = widest else { break };
        let middle = 0.5 * (progress[from] + progress[to]);
        let nearest = (from + 1..to)
            .min_by(|x, y| (progress[*x] - middle).abs().total_cmp(&(progress[*y] - middle).abs()));
        chosen.extend(nearest);
    }
    chosen.into_iter().map(|k| files[k].clone()).collect()
}

/// How far the run is at every frame: path of the axial strain over that of the whole run, plus as
/// much again over all increments before there is a strain.
fn progress(files: &[File], run: &Run) -> Vec<f64> {
    let mut path = BTreeMap::new();
    let (mut sum, mut last) = (0.0, None::<f64>);
    for (increment, strain) in &run.strains {
        if let (Some(before), Some(now)) = (last, *strain) {
            sum += (now - before).abs();
        }
        last = strain.or(last);
        path.insert(*increment, sum);
    }
    let whole = files.last().map_or(1.0, |file| file.increment.max(1) as f64);
    let part = |file: &File| {
        let strain = path.range(..=file.increment).next_back().map_or(0.0, |(_, s)| *s);
        let along = file.increment as f64 / whole;
        if sum > 0.0 { strain / sum + 0.05 * along } else { along }
    };
    files.iter().map(part).collect()
}
