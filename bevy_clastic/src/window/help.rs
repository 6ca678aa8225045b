//! The list of the keys.

use bevy::prelude::*;

use super::{INK, PALE_INK, text};

/// The keys, as the help and the documentation list them.
const KEYS: &str = "\
Space     start, pause
N         one increment (Shift: ten)
[ ]       slower, faster
K         keep the present state
R         back to the kept state
Home      back to the start
C         colours of another field (Shift: back)
Z         fields count from here
1 2 3     disks, bonds, forces
4 5       broken bonds, walls
L         another load (Shift: back)
left      less of the load
right     more of it
V X       another curve: y, x (Shift: back)
F         whole specimen
P         screenshot
Esc       nothing is marked
mouse     drag, wheel; click a grain,
          or the contact of two
H         this list";

/// Marks the list.
#[derive(Component)]
pub(super) struct Help;

pub(super) fn spawn(mut commands: Commands) {
    let (_, font, colour) = text(13.0, INK);
    commands.spawn((
        Help,
        Visibility::Hidden,
        Node {
            position_type: PositionType::Absolute,
            left: px(16),
            top: px(16),
            padding: UiRect::all(px(12)),
            border: UiRect::all(px(1)),
            ..default()
        },
        BackgroundColor(Color::srgba(1.0, 1.0, 1.0, 0.95)),
        BorderColor::all(PALE_INK),
        children![(Text::new(KEYS), font, colour)],
    ));
}
