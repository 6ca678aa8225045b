//! Definitions of strain and stress, and further measures.

use std::fmt::Arguments;

use crate::scene::format::{
    Amount, Area, CellStrain, Length, Measure, Quantity, ROLES, Strain, StrainComponent, Stress,
};

use super::ASKEW;
use super::crossing::inward;
use super::findings::Findings;
use super::places::length;
use super::references::index_exists;
use super::select::select;
use super::thin_walls::one_piece;
use crate::history_columns;

pub(super) fn check(findings: &mut Findings) {
    let context = findings.context;
    if let Some(stage) = &context.scene.reference_stage {
        let path = format_args!("reference_stage");
        findings.reference(path, stage, ("stage", "stages"), &context.stages);
    }
    let list = &context.scene.measures;
    if findings.is_sure_of("measures") {
        let names = list.iter().enumerate();
        let names = names.map(|(i, measure)| (format!("measures[{i}].name"), &*measure.name));
        findings.unique("name of a measure", names);
    }
    for (i, Measure { name, of }) in list.iter().enumerate() {
        let path = format_args!("measures[{i}].of");
        let role = ROLES.iter().position(|role| role == name);
        let fits = match role {
            Some(0 | 1) => matches!(of, Quantity::Strain(_)),
            Some(_) => matches!(of, Quantity::Stress(_)),
            None => true,
        };
        let other = role.and(no_normal_strain(of));
        if let Some((what, such_as)) = other.filter(|_| findings.is_sure_of_part(path)) {
            let help = format!("measure it under another name, such as `{such_as}`");
            findings.add(path, format!("a {what} as `{name}`"), &help);
        }
        if !fits && findings.is_sure_of_part(path) {
            let kind = if name.ends_with("strain") { "Strain" } else { "Stress" };
            let message = format!("`{name}` is the name of a {}", kind.to_lowercase());
            let help = format!("write `of: {kind}(...)`, or give another name");
            findings.add(path, message, &help);
        }
        if role.is_none() && history_columns::has(name) {
            let path = format_args!("measures[{i}].name");
            let message = format!("the history has a column of this name (`{name}`)");
            findings.add(path, message, "give another name");
        }
        match of {
            Quantity::Strain(of) => strain(path, of, findings),
            Quantity::Stress(of) => stress(path, of, findings),
            Quantity::Porosity(of) => area(path, of, findings),
            Quantity::WallForce { wall: name, .. } => {
                wall(format_args!("{path}.wall"), name, findings);
            }
            Quantity::VolumetricStrain => needs_strains(path, findings),
            Quantity::DilationAngle { over } => {
                let allowed = |over| (0.0..1.0).contains(&over);
                let what = "an axial strain as a fraction, 0.002 is 0.2 %";
                findings.number(format_args!("{path}.over"), *over, allowed, what);
                needs_strains(path, findings);
            }
            Quantity::GroupForce { select: of, .. } => {
                select(format_args!("{path}.select"), of, findings);
            }
            Quantity::Membrane { membrane: name, .. } => {
                membrane(format_args!("{path}.membrane"), name, findings);
            }
            Quantity::Poured(Amount::Share) => {
                let help = "write `Number` or `Mass`";
                findings.add(format_args!("{path}[0]"), "a share of what is still to come", help);
            }
            Quantity::Grains { min, max, moved, .. } => {
                let far = f64::MAX;
                for (field, corner) in [("min", min), ("max", max)] {
                    if let Some(corner) = corner {
                        let path = format_args!("{path}.{field}");
                        findings.vector(path, *corner, "a place in m");
                    }
                }
                let corners = (min.unwrap_or((-far, -far)), max.unwrap_or((far, far)));
                if corners.0.0 >= corners.1.0 || corners.0.1 >= corners.1.1 {
                    let help = "give a rectangle with an area";
                    findings.add(
                        format_args!("{path}.max"),
                        "not above and to the right of min",
                        help,
                    );
                }
                findings.not_negative(format_args!("{path}.moved"), *moved, "a displacement in m");
            }
            Quantity::Ring { centre, radii, .. } => {
                findings.vector(format_args!("{path}.centre"), *centre, "a place in m");
                findings.range(format_args!("{path}.radii"), *radii, "radii in m");
            }
            Quantity::Custom(name) if name.trim().is_empty() => {
                let help = "name a measure that a plugin of the program provides";
                findings.add(format_args!("{path}[0]"), "no name", help);
            }
            Quantity::Coordination { .. }
            | Quantity::Fabric { .. }
            | Quantity::Fragments(_)
            | Quantity::Cracks { .. }
            | Quantity::Broken(_)
            | Quantity::BrokenShare(_)
            | Quantity::KineticEnergy
            | Quantity::ElasticEnergy
            | Quantity::KineticOverElastic
            | Quantity::Poured(_)
            | Quantity::Gravity
            | Quantity::StrengthFactor
            | Quantity::Time
            | Quantity::Custom(_) => {}
        }
    }
}

/// What a measure is that is a strain, but no normal strain, and a name for it.
fn no_normal_strain(of: &Quantity) -> Option<(&'static str, &'static str)> {
    match of {
        Quantity::Strain(Strain::Cell(CellStrain::Shear))
        | Quantity::Strain(Strain::Region { component: StrainComponent::Xy, .. }) => {
            Some(("shear strain", "shear_strain"))
        }
        Quantity::Strain(Strain::Region { component: StrainComponent::Rotation, .. }) => {
            Some(("rotation", "rotation_rad"))
        }
        Quantity::Strain(Strain::Region { component: StrainComponent::Volumetric, .. }) => {
            Some(("volumetric strain", "volume"))
        }
        _ => None,
    }
}

fn strain(path: Arguments, strain: &Strain, findings: &mut Findings) {
    match strain {
        Strain::Walls(a, b) => {
            two_walls(path, (a, b), findings);
            towards_each_other(path, (a, b), findings);
        }
        Strain::Particles(a, b) => {
            index_exists(format_args!("{path}[0]"), *a, findings);
            index_exists(format_args!("{path}[1]"), *b, findings);
            findings.pair(path, (a, b), "particle");
        }
        Strain::Membrane(name) => membrane(format_args!("{path}[0]"), name, findings),
        Strain::Region { min, max, .. } => {
            findings.rectangle(path, *min, *max);
        }
        Strain::Cell(_) => has_cell(path, findings),
    }
}

/// Checks that a strain is not that between two walls of which one is drawn from its end to its start:
/// a wall that comes at the outermost particles would come from the other side.
fn towards_each_other(path: Arguments, (a, b): (&str, &str), findings: &mut Findings) {
    let find = |name: &str| {
        let wall = findings.context.wall(name);
        wall.filter(|wall| wall.shape.is_straight() && length(wall) > 0.0)
    };
    let (Some(first), Some(second)) = (find(a), find(b)) else { return };
    if a == b || !findings.are_sound(&["walls", "specimen"]) {
        return;
    }
    let (n, m) = (inward(first), inward(second));
    let way = (second.start.0 - first.start.0) * n.0 + (second.start.1 - first.start.1) * n.1;
    let both_come = !first.is_placed() && !second.is_placed();
    if n.0 * m.0 + n.1 * m.1 > 1.0 - ASKEW {
        let what = format!("walls `{a}` and `{b}` have their insides on the same side");
        findings.add(path, what, "exchange start and end of one of them");
    } else if both_come && way < 0.0 && n.0 * m.0 + n.1 * m.1 < ASKEW - 1.0 {
        let what = format!("walls `{a}` and `{b}` have their outsides towards each other");
        findings.add(path, what, "exchange start and end of both");
    }
}

/// For measures that follow from axial and lateral strain.
fn needs_strains(path: Arguments, findings: &mut Findings) {
    needs(path, &ROLES[..2], findings);
}

/// For measures that follow from those of [`ROLES`].
fn needs(path: Arguments, names: &[&str], findings: &mut Findings) {
    for name in names {
        if findings.context.scene.measure(name).is_none() && findings.is_sure_of("measures") {
            let help = format!("add a measure `{name}`");
            findings.add(path, format!("it follows from `{name}`, which is not measured"), &help);
        }
    }
}

fn stress(path: Arguments, stress: &Stress, findings: &mut Findings) {
    match stress {
        Stress::Walls { walls, length } => {
            if walls.is_empty() {
                findings.add(format_args!("{path}.walls"), "no walls", "name one or more");
            }
            for (i, name) in walls.iter().enumerate() {
                wall(format_args!("{path}.walls[{i}]"), name, findings);
            }
            let path = format_args!("{path}.length");
            match length {
                Length::Fixed(length) => {
                    findings.positive(format_args!("{path}[0]"), *length, "a length in m");
                }
                Length::Between(a, b) => two_walls(path, (a, b), findings),
                Length::Membrane(name) => {
                    membrane(format_args!("{path}[0]"), name, findings);
                }
            }
        }
        Stress::Average { area: over, .. } => {
            area(format_args!("{path}.area"), over, findings);
        }
        Stress::Region { min, max, .. } => {
            findings.rectangle(path, *min, *max);
        }
        Stress::Membrane(name) => membrane(format_args!("{path}[0]"), name, findings),
    }
}

fn area(path: Arguments, area: &Area, findings: &mut Findings) {
    match area {
        Area::Fixed(area) => {
            findings.positive(format_args!("{path}[0]"), *area, "an area in m^2");
        }
        Area::Cell => has_cell(path, findings),
        Area::Box(a, b) => {
            two_walls(format_args!("{path}[0]"), (&a.0, &a.1), findings);
            two_walls(format_args!("{path}[1]"), (&b.0, &b.1), findings);
        }
        Area::Membrane(name) => membrane(format_args!("{path}[0]"), name, findings),
    }
}

fn has_cell(path: Arguments, findings: &mut Findings) {
    if findings.context.scene.cell.is_none() && findings.is_sure_of("cell") {
        let help = "add `cell: (size: (WIDTH, HEIGHT))` to the scene";
        findings.add(path, "no periodic cell", help);
    }
}

fn two_walls(path: Arguments, (a, b): (&str, &str), findings: &mut Findings) {
    wall(format_args!("{path}[0]"), a, findings);
    wall(format_args!("{path}[1]"), b, findings);
    findings.pair(path, (a, b), "wall");
}

fn wall(path: Arguments, name: &str, findings: &mut Findings) {
    findings.reference(path, name, ("wall", "walls"), &findings.context.walls);
    let help = "name a wall of one piece; `probe` records the force on a polyline";
    one_piece(path, name, ("place and normal", help), findings);
}

fn membrane(path: Arguments, name: &str, findings: &mut Findings) {
    findings.reference(path, name, ("membrane", "stages"), &findings.context.membranes);
}
