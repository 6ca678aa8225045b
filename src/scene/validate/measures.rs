//! Definitions of strain and stress, and further measures.

use crate::scene::format::{
    Amount, Area, CellStrain, Length, Measure, Quantity, ROLES, Strain, StrainComponent, Stress,
};

use super::findings::At;
use super::parts::{are_apart, both_straight, index_exists, one_piece};
use super::places::{are_alike, are_opposite, distance};
use super::select::select;
use crate::output::history::has_column;

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
}

/// Checks that a measure under the name of one of [`ROLES`] is a normal strain or a stress.
fn names_a_role(at: &mut At, name: &str, of: &Quantity) {
    if let Some((what, such_as)) = no_normal_strain(of) {
        let help = format!("measure it under another name, such as `{such_as}`");
        at.add("of", format!("a {what} as `{name}`"), help);
    }
    let (kind, fits) = if name.ends_with("strain") {
        ("Strain", matches!(of, Quantity::Strain(_)))
    } else {
        ("Stress", matches!(of, Quantity::Stress(_)))
    };
    let message = format!("`{name}` is the name of a {}", kind.to_lowercase());
    let help = format!("write `of: {kind}(...)`, or give another name");
    at.refuse(!fits, "of", message, help);
}

/// What a measure is that is a strain, but no normal strain, and a name for it.
fn no_normal_strain(of: &Quantity) -> Option<(&'static str, &'static str)> {
    use StrainComponent::{Rotation, Volumetric, Xy};

    let Quantity::Strain(strain) = of else { return None };
    match strain {
        Strain::Cell(CellStrain::Shear) | Strain::Region { component: Xy, .. } => {
            Some(("shear strain", "shear_strain"))
        }
        Strain::Region { component: Rotation, .. } => Some(("rotation", "rotation_rad")),
        Strain::Region { component: Volumetric, .. } => Some(("volumetric strain", "volume")),
        _ => None,
    }
}

fn quantity(at: &mut At, of: &Quantity) {
    match of {
        Quantity::Strain(of) => strain(at, of),
        Quantity::Stress(of) => stress(at, of),
        Quantity::Porosity(of) => area(at, of),
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
            at.place("min", *min);
            at.place("max", *max);
            let (low, high) =
                (min.unwrap_or((f64::MIN, f64::MIN)), max.unwrap_or((f64::MAX, f64::MAX)));
            let message = "not above and to the right of min";
            let help = "give a rectangle with an area";
            at.refuse(low.0 >= high.0 || low.1 >= high.1, "max", message, help);
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

/// Checks that a strain is not that between two walls of which one is drawn from its end to its start:
/// a wall that comes at the outermost particles would come from the other side.
fn towards_each_other(at: &mut At, (a, b): (&str, &str)) {
    let Some((first, second)) = both_straight(at, (a, b)) else { return };
    if a == b || !at.are_sound(&["walls", "specimen"]) {
        return;
    }
    let both_come = !first.is_placed() && !second.is_placed();
    if are_alike(first, second) {
        let what = format!("walls `{a}` and `{b}` have their insides on the same side");
        at.add("", what, "exchange start and end of one of them");
    } else if both_come && are_opposite(first, second) && distance(first, second) < 0.0 {
        let what = format!("walls `{a}` and `{b}` have their outsides towards each other");
        at.add("", what, "exchange start and end of both");
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
            }
            let at = &mut at.field("length");
            match length {
                Length::Fixed(length) => {
                    at.positive("[0]", *length, "a length in m");
                }
                Length::Between(a, b) => two_walls(at, (a, b)),
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
        }
        Area::Membrane(name) => membrane(at, "[0]", name),
    }
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
