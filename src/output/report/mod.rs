//! `report.html`: one or several runs as a page that needs nothing else, neither files nor network.
//!
//! Of one run the page has key results, curves, the specimen as an animation over its frames, roses
//! and a section on how far the numbers can be trusted. Of several runs it has their curves over
//! one another and a table. Numbers travel as base64 of compressed columns (`columns`); what
//! shows them is in the files `page.*` beside this one, plain JavaScript without a build step.

mod choose;
mod columns;
mod movie;
mod run;
mod scales;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::json;

use self::movie::Movie;
use self::run::Run;
use super::OutputError;
use super::atomic::write_atomic;

const PAGE: &str = include_str!("page.html");
const STYLES: [&str; 2] = [include_str!("page.css"), include_str!("page_parts.css")];
const SCRIPTS: [&str; 13] = [
    include_str!("page_data.js"),
    include_str!("page_chart.js"),
    include_str!("page_curves.js"),
    include_str!("page_roses.js"),
    include_str!("page_colours.js"),
    include_str!("page_layers.js"),
    include_str!("page_camera.js"),
    include_str!("page_view.js"),
    include_str!("page_flat.js"),
    include_str!("page_text.js"),
    include_str!("page_pick.js"),
    include_str!("page_controls.js"),
    include_str!("page_main.js"),
];

/// Maximum size of the frames in a page, bytes. With it a page stays below 30 MB.
const MAX_FRAMES_SIZE: usize = 28_000_000;

/// Maximum number of frames in a page.
const MAX_FRAMES: usize = 200;

/// Number of frames that tell the size of all.
const FEW_FRAMES: usize = 20;

/// Writes the page of one or several runs. `names` are their names in the page.
pub fn write(runs: &[(String, PathBuf)], out: &Path) -> Result<(), OutputError> {
    let read = runs.iter().map(|(name, directory)| Run::read(name, directory));
    let read: Vec<_> = read.collect::<Result<_, _>>()?;
    let movie = match (runs, read.as_slice()) {
        ([(_, directory)], [run]) => movie_of(directory, run)?,
        _ => None,
    };
    let records: Vec<_> = read.into_iter().map(|run| run.value).collect();
    let data = json!({ "runs": records, "movie": movie.as_ref().map(|movie| &movie.description) });
    write_atomic(out, page(&data, movie.as_ref()))
}

/// The animation of a run: about as many frames as fit into the page, by the size of a few.
fn movie_of(directory: &Path, run: &Run) -> Result<Option<Movie>, OutputError> {
    let files = choose::files(directory)?;
    let few = choose::choose(&files, run, FEW_FRAMES);
    let movie = Movie::read(&few)?;
    if few.len() == files.len() {
        return Ok(movie);
    }
    let size = movie.iter().flat_map(|movie| &movie.blocks).map(String::len).sum::<usize>();
    let most = (few.len() * MAX_FRAMES_SIZE / size.max(1)).clamp(2, MAX_FRAMES);
    Movie::read(&choose::choose(&files, run, most))
}

fn page(data: &serde_json::Value, movie: Option<&Movie>) -> String {
    let titles = data["runs"].as_array().into_iter().flatten();
    let titles: Vec<_> = titles.filter_map(|run| run["record"]["title"].as_str()).collect();
    let title = match titles.as_slice() {
        [one] => one.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;"),
        several => format!("{} runs", several.len()),
    };
    // Within a script no text may look like the end of it.
    let data = data.to_string().replace('<', "\\u003c");
    let mut blocks = format!("<script type=\"application/json\" id=\"data\">{data}</script>\n");
    for (k, block) in movie.iter().flat_map(|movie| &movie.blocks).enumerate() {
        let name = k.checked_sub(1).map_or("still".to_owned(), |k| format!("frame{k}"));
        blocks += &format!("<script type=\"text/plain\" id=\"{name}\">{block}</script>\n");
    }
    for script in SCRIPTS {
        blocks += &format!("<script>\n{script}</script>\n");
    }
    let (before, after) = PAGE.split_once("{{scripts}}").unwrap_or((PAGE, ""));
    let before = before.replacen("{{title}}", &title, 1).replacen("{{style}}", &STYLES.concat(), 1);
    [before, blocks, after.to_owned()].concat()
}

/// All values once, ascending.
fn distinct<T: Ord>(all: impl Iterator<Item = T>) -> Vec<T> {
    all.collect::<BTreeSet<_>>().into_iter().collect()
}

#[cfg(test)]
mod tests;
