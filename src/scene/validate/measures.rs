//! Definitions of strain and stress.

use std::fmt::Arguments;

use crate::scene::format::{Area, Length, Strain, Stress};

use super::Context;
use super::findings::Findings;
use super::specimen::index_exists;
use super::thin_walls::one_piece;

pub(super) fn check(context: &Context, findings: &mut Findings) {
    let measures = &context.scene.measures;
    if let Some(stage) = &measures.reference_stage {
        let path = format_args!("measures.reference_stage");
        findings.reference(path, stage, ("stage", "stages"), &context.stages);
    }
    for (field, of) in
        [("axial_strain", &measures.axial_strain), ("lateral_strain", &measures.lateral_strain)]
    {
        let path = format_args!("measures.{field}");
        match of {
            None => {}
            Some(Strain::Walls(a, b)) => two_walls(context, path, (a, b), findings),
            Some(Strain::Particles(a, b)) => {
                index_exists(context, format_args!("{path}[0]"), *a, findings);
                index_exists(context, format_args!("{path}[1]"), *b, findings);
                findings.pair(path, (a, b), "particle");
            }
        }
    }
    for (field, of) in
        [("axial_stress", &measures.axial_stress), ("lateral_stress", &measures.lateral_stress)]
    {
        if let Some(of) = of {
            stress(context, format_args!("measures.{field}"), of, findings);
        }
    }
}

fn stress(context: &Context, path: Arguments, stress: &Stress, findings: &mut Findings) {
    match stress {
        Stress::Walls { walls, length } => {
            if walls.is_empty() {
                findings.add(format_args!("{path}.walls"), "no walls", "name one or more");
            }
            for (i, name) in walls.iter().enumerate() {
                wall(context, format_args!("{path}.walls[{i}]"), name, findings);
            }
            let path = format_args!("{path}.length");
            match length {
                Length::Fixed(length) => {
                    findings.positive(format_args!("{path}[0]"), *length, "a length in m");
                }
                Length::Between(a, b) => two_walls(context, path, (a, b), findings),
            }
        }
        Stress::Average { area, .. } => match area {
            Area::Fixed(area) => {
                findings.positive(format_args!("{path}.area[0]"), *area, "an area in m^2");
            }
            Area::Box(a, b) => {
                two_walls(context, format_args!("{path}.area[0]"), (&a.0, &a.1), findings);
                two_walls(context, format_args!("{path}.area[1]"), (&b.0, &b.1), findings);
            }
        },
    }
}

fn two_walls(context: &Context, path: Arguments, (a, b): (&str, &str), findings: &mut Findings) {
    wall(context, format_args!("{path}[0]"), a, findings);
    wall(context, format_args!("{path}[1]"), b, findings);
    findings.pair(path, (a, b), "wall");
}

fn wall(context: &Context, path: Arguments, name: &str, findings: &mut Findings) {
    findings.reference(path, name, ("wall", "walls"), &context.walls);
    one_piece(context, path, name, "place and normal", findings);
}
