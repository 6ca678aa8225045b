//! Charts of probes, for rigs that define no stress: force against displacement if the outside
//! world does work on the probes, and motion against time otherwise.

use super::chart::{Chart, Line};
use super::history::History;
use crate::output::drive::Drive;

/// Columns of displacements.
const MOTIONS: [(&str, &str); 2] = [(".x_m", "x"), (".y_m", "y")];

/// The chart of the probes; `None` if no probe moved or carried force.
pub fn probes(title: &str, history: &History) -> Option<Chart> {
    let mut chart = worked(title, history).or_else(|| moved(title, history))?;
    // A single line has no legend.
    if let [line] = chart.lines.as_slice() {
        chart.caption = format!("{}: {}", line.name, chart.caption);
    }
    Some(chart)
}

/// Force against displacement along the axis with the maximum work in the test, both positive in the
/// direction of the drive.
fn worked(title: &str, history: &History) -> Option<Chart> {
    let drives = Drive::all(history);
    let first = drives.first()?;
    let turning = first.turns();
    let one = drives.iter().all(|drive| drive.direction == first.direction);
    let points = || drives.iter().flat_map(|drive| &drive.points);
    let (unit, metres) = match points().map(|p| p.motion.abs()).fold(0.0, f64::max) {
        _ if turning => ("rad", 1.0),
        u if u >= 0.1 => ("m", 1.0),
        u if u >= 1e-4 => ("mm", 1e-3),
        _ => ("µm", 1e-6),
    };
    let line = |drive: &Drive| Line {
        name: match one {
            true => drive.probe.clone(),
            false => format!("{}, {}", drive.probe, drive.direction),
        },
        points: drive.points.iter().map(|p| (p.motion / metres, p.force)).collect(),
    };
    let (x, y) = match (turning, one) {
        (true, true) => {
            (format!("{} rotation, rad", first.direction), "moment in this direction, N m")
        }
        (true, false) => {
            ("rotation in its direction, rad".to_owned(), "moment in this direction, N m")
        }
        (false, true) => (
            format!("displacement along {}, {unit}", first.direction),
            "force in this direction, N",
        ),
        (false, false) => {
            (format!("displacement of the probe, {unit}"), "force in this direction, N")
        }
    };
    Some(Chart {
        title: title.to_owned(),
        caption: "force of the outside world on the probe; positive in the direction of the drive"
            .to_owned(),
        x,
        y: y.to_owned(),
        lines: drives.iter().map(line).collect(),
        second: None,
        equal: false,
    })
}

/// Displacements against time, or against the number of the increment if time does not pass.
fn moved(title: &str, history: &History) -> Option<Chart> {
    let mut lines = Vec::new();
    let timeless = history.column("time_s").iter().all(|t| *t == Some(0.0));
    let (along, x) = if timeless { ("increment", "increment") } else { ("time_s", "time, s") };
    for probe in history.probes() {
        for (motion, axis) in MOTIONS {
            let points = history.points(along, &format!("{probe}{motion}"));
            let moves =
                points.iter().any(|p| p.1 != 0.0) && points.windows(2).any(|w| w[0].0 < w[1].0);
            if moves {
                lines.push(Line { name: format!("{probe} {axis}"), points });
            }
        }
    }
    (!lines.is_empty()).then(|| Chart {
        title: title.to_owned(),
        caption: "displacement since the start, axes of the scene".to_owned(),
        x: x.to_owned(),
        y: "displacement, m".to_owned(),
        lines,
        second: None,
        equal: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_that_stands_before_the_last_stage_is_not_the_curve() -> Result<(), std::io::Error> {
        let file = tempfile::NamedTempFile::new()?;
        let text = "stage,p.x_m,p.y_m,p.rotation_rad,p.force_x_n,p.force_y_n,p.moment_nm\n\
                    press,0,-1,0,0,-5,0\n\
                    turn,0,-1,1e-6,0,-5,0.1\n\
                    turn,0,-1,2e-6,0,-5,0.1\n";
        std::fs::write(file.path(), text)?;
        let history = History::read(file.path()).map_err(std::io::Error::other)?;
        let chart = probes("", &history).unwrap_or_default();
        assert_eq!(chart.lines[0].points, [(0.0, 0.0), (1e-6, 0.1), (2e-6, 0.1)]);
        Ok(())
    }

    #[test]
    fn displacements_count_from_the_start_of_the_test() -> Result<(), std::io::Error> {
        let file = tempfile::NamedTempFile::new()?;
        let text = "increment,stage,p.x_m,p.y_m,p.force_x_n,p.force_y_n\n\
                    8,compact,0,-3,0,-1e9\n9,load,0,-3.5,0,-10\n10,load,0,-4,0,-20\n\
                    11,unload,0,-3.5,0,-10\n";
        std::fs::write(file.path(), text)?;
        let history = History::read(file.path()).map_err(std::io::Error::other)?;
        let points =
            |history: &History| probes("", history).unwrap_or_default().lines[0].points.clone();
        let loaded = history.clone().after(11).from_stage("load");
        assert_eq!(points(&loaded), [(0.0, 1e9), (0.5, 10.0), (1.0, 20.0), (0.5, 10.0)]);
        // A run that goes on from a saved state does not know the state before it.
        let branch = history.after(4).from_stage("compact");
        assert_eq!(points(&branch)[0], (3.0, 1e9));
        Ok(())
    }
}
