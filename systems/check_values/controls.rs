//! Controls of walls, which have no effect where what they refer to is missing.

use clastic_components::prelude::*;

use super::bad::{Bad, finite};

/// The control of a wall, with the components that it needs.
pub(super) fn control(
    wall: &WallRow,
    table: Option<&WallTable>,
    slide: Option<&WallSlide>,
    kind: AnalysisKind,
) -> Option<Bad> {
    let has_time = matches!(kind, AnalysisKind::Dynamic { .. });
    match wall.control {
        WallControl::Custom => return None,
        WallControl::Velocity(_) | WallControl::Spin { .. } if !has_time => {
            return Some(Bad::new(
                "WallControl",
                wall.control,
                "`Displacement` or `Rotation` in every increment, or a dynamic `ClasticAnalysis`: without \
                 one there is no time",
            ));
        }
        WallControl::Table(_) => {
            if let Some(bad) = points(table) {
                return Some(bad);
            }
        }
        _ => {}
    }
    let slide = slide?;
    if !matches!(wall.drive, WallDrive::Sliding { .. }) {
        let wanted = "a control by `Force` or `Stress`, under which alone a wall slides";
        return Some(Bad::new("WallSlide", slide, wanted));
    }
    let wanted = "`Displacement` in every increment, or a dynamic `ClasticAnalysis`: without one there is \
                  no time";
    matches!(slide, WallSlide::Velocity(_) if !has_time)
        .then(|| Bad::new("WallSlide", slide, wanted))
}

/// The points of a table, which must be there and in order.
fn points(table: Option<&WallTable>) -> Option<Bad> {
    let Some(WallTable(points)) = table.filter(|table| !table.0.is_empty()) else {
        return Some(Bad::new("WallTable", "missing", "the points of its control by `Table`"));
    };
    let ordered = points.is_sorted_by(|a, b| a[0] < b[0]);
    let mut values = points.iter().flatten().copied();
    values.find_map(|value| finite("WallTable", value, "finite points")).or_else(|| {
        (!ordered).then(|| Bad::new("WallTable", points, "points in ascending order of s"))
    })
}
