//! Material of disks and lines: what the corners of a quad say is drawn with smooth edges.

use bevy::asset::embedded_asset;
use bevy::prelude::*;
use bevy::reflect::TypePath;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::ShaderRef;
use bevy::sprite_render::{AlphaMode2d, Material2d};

/// Material of quads. A point of a quad is drawn where its texture coordinates (u, v) lie within
/// the unit circle: a square from -1 to 1 is a disk, and a quad with u = 0 is a line.
#[derive(Asset, TypePath, AsBindGroup, Clone, Debug)]
pub struct Shape {
    /// Darkness of the rim of a disk, and of the radius at u > 0, which shows how far it has turned;
    /// 0 to 1. The other two have no meaning.
    #[uniform(0)]
    marks: Vec4,
}

impl Shape {
    /// Disks with rim and radius.
    pub const DISKS: Self = Self { marks: Vec4::new(0.6, 0.35, 0.0, 0.0) };
    /// Lines.
    pub const LINES: Self = Self { marks: Vec4::ZERO };
}

impl Material2d for Shape {
    fn fragment_shader() -> ShaderRef {
        "embedded://bevy_clastic/draw/shape.wesl".into()
    }

    fn alpha_mode(&self) -> AlphaMode2d {
        AlphaMode2d::Blend
    }
}

/// Adds the shader, which is a part of the program.
pub(super) fn add_shader(app: &mut App) {
    embedded_asset!(app, "shape.wesl");
}
