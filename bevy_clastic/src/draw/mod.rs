//! Draws a picture of the engine: disks in one mesh, lines in another, both made anew when there is
//! another picture.

mod colours;
mod disks;
mod fields;
mod lines;
pub(crate) mod scale;
mod shape;
mod strokes;
mod watch;

pub use colours::{Legend, Sample, colour};
pub(crate) use fields::contacts;
pub use fields::{Field, colouring};
pub use shape::Shape;
pub use watch::WatchPlugin;

use std::time::{Duration, Instant};

use bevy::app::{App, Plugin, PostUpdate, Startup};
use bevy::camera::visibility::NoFrustumCulling;
use bevy::prelude::*;
use bevy::sprite_render::{Material2dPlugin, MeshMaterial2d};

use crate::picture::Picture;

/// The picture that is drawn, and the one from which displacements, rotations and strains count.
#[derive(Resource, Clone, Debug, Default)]
pub struct Shown {
    /// The last picture.
    pub now: Picture,
    /// Fields are the changes since this one.
    pub since: Picture,
}

impl Shown {
    /// Replaces the picture. Fields count from the first one with bodies, and again from the last
    /// one before the stage from whose start the scene counts its strains.
    pub fn show(&mut self, picture: Picture) {
        let starts = self.since.frame.bodies.id.is_empty();
        let goes_back = picture.frame.increment < self.since.frame.increment;
        if starts || goes_back {
            self.since = picture.clone();
        } else if picture.is_test && !self.now.is_test {
            self.since = std::mem::take(&mut self.now);
        }
        self.now = picture;
    }
}

/// What is drawn, and in which colours.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Colours of the disks.
    pub field: Field,
    /// Disks.
    pub disks: bool,
    /// Intact bonds.
    pub bonds: bool,
    /// Normal forces as widths of lines.
    pub forces: bool,
    /// Broken bonds by mode.
    pub cracks: bool,
    /// Walls, membranes and the periodic cell.
    pub walls: bool,
    /// Disk that is marked, by its identity.
    pub marked: Option<u32>,
    /// Pair that is marked, by the identities of its bodies.
    pub marked_pair: Option<[u32; 2]>,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            field: Field::default(),
            disks: true,
            bonds: false,
            forces: false,
            cracks: true,
            walls: true,
            marked: None,
            marked_pair: None,
        }
    }
}

/// Time that the last drawing took on the processor, and how often it was drawn.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct DrawingTime {
    /// Time of the last one.
    pub last: Duration,
    /// Time of all.
    pub total: Duration,
    /// Number of drawings.
    pub number: u32,
}

/// What is drawn of the fields and lines that are shown.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Legends(pub Vec<Legend>);

/// Draws [`Shown`] as [`Look`] says, in an app with `DefaultPlugins` and a 2D camera.
#[derive(Clone, Copy, Debug)]
pub struct DrawPlugin {
    /// Units of Bevy's space, which are pixels unless a camera scales them, in a metre.
    pub scale: f32,
}

/// Units of Bevy's space in a metre.
#[derive(Resource, Clone, Copy, Debug)]
pub struct UnitsPerMetre(pub f32);

/// The meshes.
#[derive(Resource)]
struct Meshes {
    disks: Handle<Mesh>,
    lines: Handle<Mesh>,
}

/// The set of the systems that draw, in `PostUpdate`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Drawing;

impl Plugin for DrawPlugin {
    fn build(&self, app: &mut App) {
        shape::add_shader(app);
        app.add_plugins(Material2dPlugin::<Shape>::default())
            .insert_resource(UnitsPerMetre(self.scale))
            .init_resource::<Shown>()
            .init_resource::<Look>()
            .init_resource::<Legends>()
            .init_resource::<DrawingTime>()
            .add_systems(Startup, spawn)
            .add_systems(PostUpdate, draw.in_set(Drawing));
    }
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut shapes: ResMut<Assets<Shape>>,
    scale: Res<UnitsPerMetre>,
) {
    let handles = Meshes {
        disks: meshes.add(strokes::Quads::default().mesh()),
        lines: meshes.add(strokes::Quads::default().mesh()),
    };
    let layers = [(&handles.disks, Shape::DISKS, 0.0), (&handles.lines, Shape::LINES, 1.0)];
    for (mesh, shape, z) in layers {
        commands.spawn((
            Mesh2d(mesh.clone()),
            MeshMaterial2d(shapes.add(shape)),
            Transform::from_xyz(0.0, 0.0, z).with_scale(Vec3::new(scale.0, scale.0, 1.0)),
            NoFrustumCulling,
        ));
    }
    commands.insert_resource(handles);
}

/// Makes the meshes anew, if what they show has changed, or the size of a pixel.
fn draw(
    shown: Res<Shown>,
    look: Res<Look>,
    scale: Res<UnitsPerMetre>,
    cameras: Query<&Projection, With<Camera2d>>,
    handles: Res<Meshes>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut legends: ResMut<Legends>,
    mut time: ResMut<DrawingTime>,
    mut last_pixel: Local<f32>,
) {
    let zoom = cameras.iter().find_map(|projection| match projection {
        Projection::Orthographic(projection) => Some(projection.scale),
        _ => None,
    });
    // Size of a pixel, m.
    let pixel = zoom.unwrap_or(1.0) / scale.0;
    if !shown.is_changed() && !look.is_changed() && pixel == *last_pixel {
        return;
    }
    *last_pixel = pixel;
    let start = Instant::now();
    let mut list = Vec::new();
    let mut disks = strokes::Quads::default();
    if look.disks {
        let (colours, legend) = colouring(&shown, look.field);
        disks::draw(&mut disks, &shown.now.frame, &colours, look.forces);
        list.push(legend);
    }
    let mut quads = strokes::Quads::default();
    lines::draw(&mut quads, &shown.now, &look, pixel, &mut list);
    for (handle, quads) in [(&handles.disks, disks), (&handles.lines, quads)] {
        if let Some(mut mesh) = meshes.get_mut(handle) {
            *mesh = quads.mesh();
        }
    }
    legends.set_if_neq(Legends(list));
    let last = start.elapsed();
    *time = DrawingTime { last, total: time.total + last, number: time.number + 1 };
}
