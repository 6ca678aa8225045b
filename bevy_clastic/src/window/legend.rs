//! What colours and widths mean.

use bevy::prelude::*;

use super::panel::LegendArea;
use super::{INK, PALE_INK, text};
use crate::draw::{Legend, Legends, colour};

/// Made anew when it differs.
pub(super) fn show(
    legends: Res<Legends>,
    area: Single<Entity, With<LegendArea>>,
    mut commands: Commands,
) {
    if !legends.is_changed() {
        return;
    }
    commands.entity(*area).despawn_children().with_children(|area| {
        for legend in &legends.0 {
            add(area, legend);
        }
    });
}

fn add(area: &mut ChildSpawnerCommands, legend: &Legend) {
    let row = |gap: i32| Node { column_gap: px(gap), align_items: AlignItems::Center, ..default() };
    let words = |what: &str, colour: Color| {
        let (_, font, colour) = text(12.0, colour);
        (Text::new(what.replace('µ', "u")), font, colour)
    };
    if !legend.name.is_empty() {
        area.spawn(words(&legend.name, INK));
    }
    if !legend.scale.is_empty() {
        area.spawn(Node { width: percent(100), height: px(14), ..default() }).with_children(
            |bar| {
                for hex in &legend.scale {
                    bar.spawn((
                        Node { flex_grow: 1.0, height: percent(100), ..default() },
                        BackgroundColor(colour(hex).into()),
                    ));
                }
            },
        );
    }
    if let Some(numbers) = &legend.numbers {
        let node = Node { justify_content: JustifyContent::SpaceBetween, ..row(4) };
        area.spawn(node).with_children(|row| {
            for number in numbers {
                row.spawn(words(number, PALE_INK));
            }
        });
    }
    // Several short meanings stand in a row.
    let node = Node { flex_wrap: FlexWrap::Wrap, row_gap: px(4), ..row(12) };
    area.spawn(node).with_children(|list| {
        for sample in &legend.samples {
            list.spawn(row(6)).with_children(|entry| {
                entry.spawn((
                    Node { width: px(14), height: px(14), border: UiRect::all(px(1)), ..default() },
                    BackgroundColor(colour(sample.colour).into()),
                    BorderColor::all(PALE_INK),
                ));
                entry.spawn(words(&sample.text, INK));
            });
        }
    });
}
