//! Definitions of strain and stress, and further measures.

use std::f64::consts::FRAC_1_SQRT_2;

use clastic_components::observation::StressComponent;
use glam::DVec2;

use crate::output::history::has_column;
use crate::run::disks::Disks;
use crate::scene::format::{
    Amount, Area, CellStrain, Length, Measure, Quantity, ROLES, Stage, Strain, StrainComponent,
    Stress,
};
use crate::scene::limits::MAX_NUMBER;

use super::Context;
use super::findings::At;
use super::parts::{are_apart, bounds, index_exists, one_piece, towards_each_other};
use super::places::{inward, length};
use super::select::select;

pub(super) fn check(at: &mut At) {
    let context = at.context;
    if let Some(stage) = &context.scene.reference_stage {
        at.reference("reference_stage", stage, ("stage", "stages"), &context.stages);
    }
    let list = &context.scene.measures;
    at.names("measures", "name of a measure", &context.measures);
    for (i, Measure { name, of }) in list.iter().enumerate() {
        let at = &mut at.item("measures", i);
        let role = ROLES.iter().position(|role| role == name);
        if role.is_some() && at.is_sure("of") {
            names_a_role(at, name, of);
        }
        let message = format!("the history has a column of this name (`{name}`)");
        let help = "give another name";
        at.refuse(role.is_none() && has_column(name), "name", message, help);
        quantity(&mut at.field("of"), of);
    }
    if at.are_sound(&["walls", "measures"]) {
        axes(at);
    }
}

/// Checks that axial strain and stress have one axis, and lateral ones the other: a stress along one over a strain
/// along the other is no modulus.
fn axes(at: &mut At) {
    let scene = at.context.scene;
    let found = ROLES.map(|role| axis(at.context, scene.measure(role)?));
    let Some((axial, axis)) = [0, 2].into_iter().find_map(|k| Some((ROLES[k], found[k]?))) else {
        return;
    };
    for (i, Measure { name, .. }) in scene.measures.iter().enumerate() {
        let role = ROLES.iter().position(|role| role == name);
        let Some((role, own)) = role.and_then(|role| Some((role, found[role]?))) else { continue };
        let (is_lateral, is_along) = (role % 2 == 1, own.dot(axis).abs() >= FRAC_1_SQRT_2);
        let across = if is_lateral { "along" } else { "across" };
        let message = format!("`{name}` {across} the axis of `{axial}`");
        let help = "axial strain and stress have one axis, lateral ones are across it: name other walls, or \
                    another component";
        at.refuse(is_lateral == is_along, format_args!("measures[{i}].of"), message, help);
    }
}

/// Direction along which a normal strain or stress acts; `None` where the scene does not say.
fn axis(context: &Context, of: &Quantity) -> Option<DVec2> {
    match of {
        Quantity::Strain(Strain::Walls(name, _)) => normal(context, name),
        Quantity::Stress(Stress::Walls { walls, .. }) => normal(context, walls.first()?),
        Quantity::Strain(
            Strain::Cell(CellStrain::Width) | Strain::Region { component: StrainComponent::Xx, .. },
        )
        | Quantity::Stress(
            Stress::Average { component: StressComponent::Xx, .. }
            | Stress::Region { component: StressComponent::Xx, .. },
        ) => Some(DVec2::X),
        Quantity::Strain(
            Strain::Cell(CellStrain::Height)
            | Strain::Region { component: StrainComponent::Yy, .. },
        )
        | Quantity::Stress(
            Stress::Average { component: StressComponent::Yy, .. }
            | Stress::Region { component: StressComponent::Yy, .. },
        ) => Some(DVec2::Y),
        _ => None,
    }
}

fn normal(context: &Context, wall: &str) -> Option<DVec2> {
    context.wall(wall).filter(|wall| wall.shape.is_straight() && length(wall) > 0.0).map(inward)
}

/// Checks that a measure under the name of one of [`ROLES`] is a normal strain or a stress.
fn names_a_role(at: &mut At, name: &str, of: &Quantity) {
    use StrainComponent::{Rotation, Volumetric, Xy};
    let other = match of {
        Quantity::Strain(
            Strain::Cell(CellStrain::Shear) | Strain::Region { component: Xy, .. },
        ) => Some("shear_strain"),
        Quantity::Strain(Strain::Region { component: Rotation, .. }) => Some("rotation_rad"),
        Quantity::Strain(Strain::Region { component: Volumetric, .. }) => Some("volume"),
        _ => None,
    };
    let (kind, fits) = if name.ends_with("strain") {
        ("Strain", matches!(of, Quantity::Strain(_)))
    } else {
        ("Stress", matches!(of, Quantity::Stress(_)))
    };
    let what = if other.is_some() { "normal strain" } else { &kind.to_lowercase() };
    let message = format!("`{name}` is the name of a {what}");
    let help = match other {
        Some(other) => format!("give another name, such as `{other}`"),
        None => format!("write `of: {kind}(...)`, or give another name"),
    };
    at.refuse(!fits || other.is_some(), "of", message, help);
}

fn quantity(at: &mut At, of: &Quantity) {
    match of {
        Quantity::Strain(of) => strain(at, of),
        Quantity::Stress(of) => stress(at, of),
        Quantity::Porosity(of) => {
            area(at, of);
            holds(at, of);
        }
        Quantity::WallForce { wall: name, .. } => wall(at, "wall", name),
        Quantity::VolumetricStrain => needs_strains(at),
        Quantity::DilationAngle { over } => {
            let allowed = |over| (0.0..1.0).contains(&over);
            at.number("over", *over, allowed, "an axial strain as a fraction, 0.002 is 0.2 %");
            needs_strains(at);
        }
        Quantity::GroupForce { select: of, .. } => select(&mut at.field("select"), of),
        Quantity::Membrane { membrane: name, .. } => membrane(at, "membrane", name),
        Quantity::Poured(Amount::Share) => {
            at.add("[0]", "a share of what is still to come", "write `Number` or `Mass`");
        }
        Quantity::Grains { min, max, moved, .. } => {
            let far = MAX_NUMBER;
            at.rectangle(min.unwrap_or((-far, -far)), max.unwrap_or((far, far)));
            at.not_negative("moved", *moved, "a displacement in m");
        }
        Quantity::Front { share, .. } => {
            let allowed = |share| share > 0.0 && share <= 1.0;
            at.number("share", *share, allowed, "a share of the mass above 0, at most 1");
        }
        Quantity::Ring { centre, radii, .. } => {
            at.place("centre", *centre);
            at.range("radii", *radii, "radii in m");
        }
        Quantity::Custom(name) if name.trim().is_empty() => {
            at.add("[0]", "no name", "name a measure that a plugin of the program provides");
        }
        _ => {}
    }
}

fn strain(at: &mut At, strain: &Strain) {
    match strain {
        Strain::Walls(a, b) => {
            two_walls(at, (a, b));
            towards_each_other(at, (a, b));
        }
        Strain::Particles(a, b) => {
            index_exists(at, "[0]", *a);
            index_exists(at, "[1]", *b);
            at.pair("", (a, b), "particle");
        }
        Strain::Membrane(name) => membrane(at, "[0]", name),
        Strain::Region { min, max, .. } => {
            at.rectangle(*min, *max);
        }
        Strain::Cell(_) => has_cell(at),
    }
}

/// For measures that follow from axial and lateral strain.
fn needs_strains(at: &mut At) {
    for name in &ROLES[..2] {
        let is_absent = at.context.scene.measure(name).is_none() && at.is_sure_of("measures");
        let message = format!("it follows from `{name}`, which is not measured");
        at.refuse(is_absent, "", message, format!("add a measure `{name}`"));
    }
}

fn stress(at: &mut At, stress: &Stress) {
    match stress {
        Stress::Walls { walls, length } => {
            at.refuse(walls.is_empty(), "walls", "no walls", "name one or more");
            for (i, name) in walls.iter().enumerate() {
                wall(&mut at.item("walls", i), "", name);
                are_apart(&mut at.item("walls", i), "", (&walls[0], name));
            }
            let at = &mut at.field("length");
            match length {
                Length::Fixed(length) => {
                    at.positive("[0]", *length, "a length in m");
                }
                Length::Between(a, b) => {
                    two_walls(at, (a, b));
                    walls.iter().take(1).for_each(|wall| bounds(at, "", (a, wall)));
                }
                Length::Membrane(name) => membrane(at, "[0]", name),
            }
        }
        Stress::Average { area: over, .. } => area(&mut at.field("area"), over),
        Stress::Region { min, max, .. } => {
            at.rectangle(*min, *max);
        }
        Stress::Membrane(name) => membrane(at, "[0]", name),
    }
}

fn area(at: &mut At, area: &Area) {
    match area {
        Area::Fixed(area) => {
            at.positive("[0]", *area, "an area in m^2");
        }
        Area::Cell => has_cell(at),
        Area::Box(a, b) => {
            two_walls(&mut at.item("", 0), (&a.0, &a.1));
            two_walls(&mut at.item("", 1), (&b.0, &b.1));
            bounds(&mut at.item("", 1), "", (&b.0, &a.0));
        }
        Area::Membrane(name) => membrane(at, "[0]", name),
    }
}

/// Checks that the area of a porosity is that of the grains at least, of which no stage takes any away.
fn holds(at: &mut At, of: &Area) {
    let context = at.context;
    let Area::Fixed(area) = *of else { return };
    let taken = context.scene.stages.iter().any(|stage| matches!(stage, Stage::Remove(_)));
    if taken || !context.is_read() || context.is_resumed() || !at.are_sound(&["specimen"]) {
        return;
    }
    let grains = Disks::of(context.at_start().iter().map(|grain| grain.radius)).area;
    let message = format!("an area of {area:?} m^2, and the grains have {grains:.3e} m^2");
    at.refuse(
        area < grains,
        "[0]",
        message,
        "give the area of the specimen, or `Box` of its walls",
    );
}

fn has_cell(at: &mut At) {
    if at.context.scene.cell.is_none() && at.is_sure_of("cell") {
        at.add("", "no periodic cell", "add `cell: (size: (WIDTH, HEIGHT))` to the scene");
    }
}

fn two_walls(at: &mut At, (a, b): (&str, &str)) {
    wall(at, "[0]", a);
    wall(at, "[1]", b);
    at.pair("", (a, b), "wall");
    are_apart(at, "", (a, b));
}

fn wall(at: &mut At, field: &str, name: &str) {
    at.wall(field, name);
    let help = "name a wall of one piece; `probe` records the force on a polyline";
    one_piece(at, field, name, ("place and normal", help));
}

fn membrane(at: &mut At, field: &str, name: &str) {
    let names = &at.context.membranes;
    at.reference(field, name, ("membrane", "stages"), names);
}
