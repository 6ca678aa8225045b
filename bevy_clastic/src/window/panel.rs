//! The panel on the right, and its parts.

use bevy::prelude::*;
use bevy::ui::RelativeCursorPosition;

use super::{ACCENT, INK, PALE_INK, PANEL, PAPER, plot, text};

/// Texts of the panel.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Title,
    Status,
    Ordinate,
    Abscissa,
    Load,
    Picked,
    Answer,
}

/// Colours and their meanings.
#[derive(Component)]
pub(super) struct LegendArea;

/// The image of the curve.
#[derive(Component)]
pub(super) struct Plot;

/// The bar of the slider, and the part of it that is filled.
#[derive(Component)]
pub(super) struct Bar;
#[derive(Component)]
pub(super) struct Filled;

pub(super) fn spawn(mut commands: Commands, mut images: ResMut<Assets<Image>>) {
    let image = images.add(plot::blank());
    let column =
        |gap: i32| Node { flex_direction: FlexDirection::Column, row_gap: px(gap), ..default() };
    commands.spawn((
        Node {
            position_type: PositionType::Absolute,
            right: px(0),
            top: px(0),
            width: px(PANEL),
            height: percent(100),
            padding: UiRect::all(px(16)),
            overflow: Overflow::clip(),
            ..column(14)
        },
        BackgroundColor(PAPER),
        children![
            (Part::Title, text(15.0, INK)),
            (Part::Status, text(12.5, INK)),
            (LegendArea, column(8)),
            (
                column(4),
                children![
                    (Part::Ordinate, text(12.0, INK)),
                    (
                        Plot,
                        ImageNode::new(image),
                        Node { width: px(plot::SIZE[0]), height: px(plot::SIZE[1]), ..default() },
                    ),
                    (Part::Abscissa, text(12.0, INK)),
                ],
            ),
            (
                column(6),
                children![
                    (Part::Load, text(12.0, INK)),
                    (
                        Bar,
                        RelativeCursorPosition::default(),
                        Node { width: percent(100), height: px(16), ..default() },
                        BackgroundColor(Color::srgb(0.85, 0.87, 0.89)),
                        children![(
                            Filled,
                            Node { width: percent(0), height: percent(100), ..default() },
                            BackgroundColor(ACCENT),
                        )],
                    ),
                ],
            ),
            (Part::Picked, text(12.0, INK)),
            (Part::Answer, text(12.0, PALE_INK)),
        ],
    ));
}
