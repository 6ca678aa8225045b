//! The settings of a scene as resources.

use bevy_ecs::prelude::*;

use clastic_components::increment as inc;
use clastic_components::material::{Material, Materials};
use clastic_cone::condensed::{Condensed, CondensedSettings};
use clastic_reference::Clarabel;
use clastic_systems::solve_program::Solver;

use super::laws::{bond_law, contact_law};
use super::walls::WallCatalogue;
use crate::scene::format as scene;

/// Inserts the settings of a scene: all resources that no increment changes, and the analysis of
/// stages that name none.
pub fn insert_settings(world: &mut World, scene: &scene::Scene, particles: u32) {
    world.insert_resource(WallCatalogue {
        first: particles,
        walls: scene.walls.clone(),
        ..WallCatalogue::default()
    });
    world.insert_resource(analysis(scene, scene.analysis, scene.gravity));
    world.insert_resource(scene.friction_law.by_analysis());
    world.insert_resource(scene.rupture);
    world.insert_resource(scene.acceptance);
    world.insert_resource(Solver(match scene.solver {
        scene::Solver::Condensed => {
            // A residual below the default needs a solver that aims lower; a larger one is stated
            // by the program where it may be used.
            let mut settings = CondensedSettings::default();
            let wanted = settings.safety * scene.acceptance.residual;
            settings.tolerance = settings.tolerance.min(wanted);
            Box::new(Condensed::new(settings))
        }
        scene::Solver::Clarabel {} => Box::new(Clarabel::default()),
    }));
    world.insert_resource(Materials(
        scene
            .materials
            .iter()
            .map(|(name, m)| Material {
                name: name.clone(),
                density: m.density,
                contact: contact_law(&m.contact),
                bond: m.bond.as_ref().map(bond_law),
            })
            .collect(),
    ));
}

/// Analysis of a stage.
pub fn analysis(
    scene: &scene::Scene,
    kind: scene::Analysis,
    gravity: (f64, f64),
) -> inc::ClasticAnalysis {
    let (kind, path_theta) = match kind {
        scene::Analysis::Static => (inc::AnalysisKind::Static, None),
        // With theta below 1 rigid contacts have a rebound of their own.
        scene::Analysis::Dynamic { dt, theta } if scene.has_restitution() => {
            (inc::AnalysisKind::Dynamic { dt, theta: 1.0 }, Some(theta))
        }
        scene::Analysis::Dynamic { dt, theta } => (inc::AnalysisKind::Dynamic { dt, theta }, None),
    };
    inc::ClasticAnalysis {
        kind,
        gravity: gravity.into(),
        strength: 1.0,
        thickness: scene.thickness,
        path_theta,
    }
}
