//! Quads of a mesh.

use bevy::asset::RenderAssetUsages;
use bevy::color::LinearRgba;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
use glam::DVec2;

/// Quads in the order in which they are drawn.
#[derive(Default)]
pub(super) struct Quads {
    places: Vec<[f32; 3]>,
    corners: Vec<[f32; 2]>,
    colours: Vec<[f32; 4]>,
}

impl Quads {
    fn add(&mut self, places: [DVec2; 4], corners: [[f32; 2]; 4], colour: LinearRgba) {
        self.places.extend(places.map(|x| [x.x as f32, x.y as f32, 0.0]));
        self.corners.extend(corners);
        self.colours.extend([[colour.red, colour.green, colour.blue, colour.alpha]; 4]);
    }

    /// A disk that has turned by an angle, rad.
    pub(super) fn disk(&mut self, centre: DVec2, radius: f64, angle: f64, colour: LinearRgba) {
        let x = radius * DVec2::from_angle(angle);
        let y = x.perp();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let places = corners.map(|[u, v]| centre + f64::from(u) * x + f64::from(v) * y);
        self.add(places, corners, colour);
    }

    /// A line of this width.
    pub(super) fn line(&mut self, ends: [DVec2; 2], width: f64, colour: LinearRgba) {
        let [a, b] = ends;
        let half = 0.5 * width * (b - a).normalize_or(DVec2::X).perp();
        let places = [a - half, b - half, b + half, a + half];
        self.add(places, [[0.0, -1.0], [0.0, -1.0], [0.0, 1.0], [0.0, 1.0]], colour);
    }

    /// A circle of this width, as lines.
    pub(super) fn circle(&mut self, centre: DVec2, radius: f64, width: f64, colour: LinearRgba) {
        const SIDES: u32 = 48;
        let point = |k: u32| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(SIDES);
            centre + radius * DVec2::from_angle(angle)
        };
        for k in 0..SIDES {
            self.line([point(k), point(k + 1)], width, colour);
        }
    }

    /// The mesh.
    pub(super) fn mesh(self) -> Mesh {
        // A mesh without corners is refused by some drivers.
        let mut quads = self;
        if quads.places.is_empty() {
            quads.add([DVec2::ZERO; 4], [[0.0; 2]; 4], LinearRgba::NONE);
        }
        let first = (0..quads.places.len() as u32).step_by(4);
        let indices = first.flat_map(|k| [k, k + 1, k + 2, k, k + 2, k + 3]).collect();
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::RENDER_WORLD)
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, quads.places)
            .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, quads.corners)
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, quads.colours)
            .with_inserted_indices(Indices::U32(indices))
    }
}
