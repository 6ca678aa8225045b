//! Several figures of the specimen on one page.

use std::fmt::Write as _;

use glam::DVec2;

use super::maps::{self, View};
use super::run::{At, Run};
use super::{FigureError, Request};
use crate::output::plots::page::{self, Style};

/// Cracks at the peak and at the moment asked for, layers, and the rotation since the peak, side by
/// side.
pub fn localisation(run: &Run, title: &str, request: &Request) -> Result<String, FigureError> {
    let start = run.at(&request.since)?;
    let (peak, end) = (run.at(&At::Peak)?, run.at(&request.at)?);
    let style = request.style;
    let gap = 0.8 * style.font;
    let width = 0.25 * (style.narrowest - 3.0 * gap);
    let mut panel = Style::print(1.0, style.font);
    panel.narrowest = width;
    panel.margin = 0.3 * style.font;
    panel.fit = DVec2::new(width - 2.0 * panel.margin, 2.5 * width);
    // All panels show the same place, at one scale.
    let bounds = [&peak, &end].map(|moment| moment.snapshot().bounds());
    let both = bounds.into_iter().flatten();
    let both = both.reduce(|(low, high), (l, h)| (low.min(l), high.max(h)));
    let window = request.window.or(both.map(|(low, high)| [low.to_array(), high.to_array()]));
    let view = |now, from| View { now, from, style: panel, title: "", window, cracks: false };
    let drawn = [
        maps::specimen(&view(&peak, &start)),
        maps::specimen(&view(&end, &start)),
        maps::layers(&view(&end, &start)),
        maps::rotation(&view(&end, &peak)),
    ];
    let names = ["(a) peak", "(b) end", "(c) layers", "(d) rotation since the peak"];
    let (mut svg, mut top) = (String::new(), 0.0);
    for line in page::wrapped(title, 1.2 * style.font, style.narrowest) {
        top += 1.6 * style.font;
        page::text(&mut svg, DVec2::new(0.0, top), 1.2 * style.font, "start", "#222", &line);
    }
    if top > 0.0 {
        top += 0.5 * style.font;
    }
    let heads = names.map(|name| page::wrapped(name, style.font, width));
    let rows = heads.iter().map(Vec::len).max().unwrap_or(1);
    let begin = top + 1.35 * style.font * rows as f64 + 0.3 * style.font;
    let mut bottom: f64 = begin;
    for (k, (drawn, head)) in drawn.into_iter().zip(heads).enumerate() {
        let drawn = drawn.ok_or_else(|| FigureError::Absent("the specimen has no disks".into()))?;
        let x = k as f64 * (width + gap);
        for (row, line) in head.iter().enumerate() {
            let at = DVec2::new(x, top + 1.35 * style.font * (row + 1) as f64);
            page::text(&mut svg, at, style.font, "start", "#222", line);
        }
        let (size, body) = inner(&drawn);
        // Names of clips are those of the whole page.
        let clip = |text: &str| text.replace("\"c\"", &format!("\"c{k}\""));
        let body = clip(body).replace("url(#c)", &format!("url(#c{k})"));
        let _ = writeln!(
            svg,
            "<svg x=\"{}\" y=\"{}\" width=\"{3}\" height=\"{4}\" viewBox=\"0 0 {3} {4}\">{2}</svg>",
            page::short(x),
            page::short(begin),
            body,
            page::short(size.x),
            page::short(size.y),
        );
        bottom = bottom.max(begin + size.y);
    }
    Ok(format!("{}{svg}</svg>\n", style.root(DVec2::new(style.narrowest, bottom))))
}

/// Size and content of a picture without its root.
fn inner(svg: &str) -> (DVec2, &str) {
    let box_of = svg.split_once("viewBox=\"0 0 ").and_then(|(_, rest)| rest.split_once('"'));
    let size = box_of.map_or("", |(size, _)| size);
    let mut numbers = size.split(' ').map(|number| number.parse().unwrap_or(0.0));
    let size = DVec2::new(numbers.next().unwrap_or(0.0), numbers.next().unwrap_or(0.0));
    let body = svg.split_once('>').map_or("", |(_, body)| body);
    (size, body.trim_end().trim_end_matches("</svg>"))
}
