//! Numbers with a unit, which scenes do not accept: all numbers are in SI units.

use std::f64::consts::PI;

/// Units that appear in scenes, the SI unit of equal dimension, and the value in it.
const WRITTEN: [(&str, &str, f64); 53] = [
    ("Pa", "Pa", 1.0),
    ("hPa", "Pa", 1e2),
    ("kPa", "Pa", 1e3),
    ("MPa", "Pa", 1e6),
    ("GPa", "Pa", 1e9),
    ("N/m^2", "Pa", 1.0),
    ("N/mm^2", "Pa", 1e6),
    ("kN/m^2", "Pa", 1e3),
    ("bar", "Pa", 1e5),
    ("m", "m", 1.0),
    ("cm", "m", 1e-2),
    ("mm", "m", 1e-3),
    ("um", "m", 1e-6),
    ("µm", "m", 1e-6),
    ("km", "m", 1e3),
    ("m^2", "m^2", 1.0),
    ("cm^2", "m^2", 1e-4),
    ("mm^2", "m^2", 1e-6),
    ("s", "s", 1.0),
    ("ms", "s", 1e-3),
    ("us", "s", 1e-6),
    ("µs", "s", 1e-6),
    ("min", "s", 60.0),
    ("h", "s", 3600.0),
    ("m/s", "m/s", 1.0),
    ("cm/s", "m/s", 1e-2),
    ("mm/s", "m/s", 1e-3),
    ("m/s^2", "m/s^2", 1.0),
    ("g", "m/s^2", 9.81),
    ("rad", "rad", 1.0),
    ("deg", "rad", PI / 180.0),
    ("°", "rad", PI / 180.0),
    ("rad/s", "rad/s", 1.0),
    ("deg/s", "rad/s", PI / 180.0),
    ("rpm", "rad/s", PI / 30.0),
    ("N", "N", 1.0),
    ("kN", "N", 1e3),
    ("MN", "N", 1e6),
    ("mN", "N", 1e-3),
    ("Nm", "N m", 1.0),
    ("N m", "N m", 1.0),
    ("kNm", "N m", 1e3),
    ("kN m", "N m", 1e3),
    ("N/m", "N/m", 1.0),
    ("kN/m", "N/m", 1e3),
    ("MN/m", "N/m", 1e6),
    ("GN/m", "N/m", 1e9),
    ("N/mm", "N/m", 1e3),
    ("kg/m^3", "kg/m^3", 1.0),
    ("g/cm^3", "kg/m^3", 1e3),
    ("t/m^3", "kg/m^3", 1e3),
    ("Mg/m^3", "kg/m^3", 1e3),
    ("%", "", 1e-2),
];

/// SI unit of a number in a field or variant with this name, inside a value with the unit `around`.
/// The empty text means a number without dimension. `None` means that the name is unknown or not
/// that of a number.
pub(in crate::scene) fn unit_of(name: &str, around: Option<&'static str>) -> Option<&'static str> {
    Some(match name {
        "position" | "size" | "tilt" | "radius" | "limits" | "spacing" | "origin" | "start"
        | "end" | "min" | "max" | "about" | "length" | "step" | "thickness" | "ball" | "Height" => {
            "m"
        }
        "x" | "y" => "m",
        "rotation" | "angle" => "rad",
        "Displacement" => around.unwrap_or("m"),
        "Velocity" if around == Some("rad") => "rad/s",
        "Velocity" | "velocity" | "Rest" => "m/s",
        "angular_velocity" => "rad/s",
        "gravity" => "m/s^2",
        "density" => "kg/m^3",
        "area" => "m^2",
        "dt" | "Time" => "s",
        "cohesion" | "tensile_strength" | "stress" | "pressure" => "Pa",
        "normal_stiffness" | "tangential_stiffness" => "N/m",
        "force" | "Force" => "N",
        "moment" => "N m",
        "theta" | "friction" | "rolling_friction" | "restitution" | "tolerance" | "residual"
        | "throw" | "deviation" | "agitation" | "affine" | "Porosity" | "AxialStrain"
        | "StressDrop" => "",
        // Lengths and areas share this name of a variant.
        "Fixed" => return around,
        _ => return None,
    })
}

/// Splits a number and the unit after it: `1.5 MPa`.
pub(in crate::scene) fn split(literal: &str) -> Option<(f64, &str)> {
    let plain = |text: &str| text.replace('_', "").parse::<f64>().ok();
    if plain(literal).is_some() {
        return None;
    }
    let ends = literal.char_indices().map(|(at, _)| at).rev();
    let (number, unit) = ends
        .filter(|at| *at > 0)
        .find_map(|at| Some((plain(literal[..at].trim_end())?, literal[at..].trim())))?;
    Some((number, unit)).filter(|(_, unit)| !unit.is_empty())
}

/// The remedy for a number with a unit, if `wanted` is the unit of the field.
pub(in crate::scene) fn help(number: f64, unit: &str, wanted: Option<&str>) -> String {
    let unit = unit.replace('²', "2").replace('³', "3").replace("**", "").replace('^', "");
    let alike = |(written, si, _): &&(&str, &str, f64)| {
        wanted == Some(*si) && written.replace('^', "") == unit
    };
    let what = match wanted {
        None => return "leave the unit out".to_owned(),
        Some("") => "this is a plain number without a unit".to_owned(),
        Some("Pa") => "stresses and strengths are plain numbers in Pa".to_owned(),
        Some(si) => format!("this is a plain number in {si}"),
    };
    match WRITTEN.iter().find(alike) {
        Some((.., factor)) => format!("{what}: write {}", short_number(number * factor)),
        None => what,
    }
}

/// A number with few digits, without those of round-off.
fn short_number(value: f64) -> String {
    let rounded: f64 = format!("{value:.12e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_units_come_apart() {
        assert_eq!(split("1 MPa"), Some((1.0, "MPa")));
        assert_eq!(split("1e6Pa"), Some((1e6, "Pa")));
        assert_eq!(split("-1_000.5 kN/m"), Some((-1000.5, "kN/m")));
        assert_eq!(split("12%"), Some((12.0, "%")));
        for none in ["1.0", "1e6", "x", "--1", "", "é", "0x10"] {
            assert!(split(none).is_none_or(|(_, unit)| unit == "x10"), "{none}");
        }
    }

    #[test]
    fn a_known_unit_is_converted_where_it_fits() {
        let said = help(1.0, "MPa", Some("Pa"));
        assert_eq!(said, "stresses and strengths are plain numbers in Pa: write 1000000.0");
        assert_eq!(
            help(2.65, "g/cm³", Some("kg/m^3")),
            "this is a plain number in kg/m^3: write 2650.0"
        );
        assert_eq!(
            help(9.81, "m/s2", Some("m/s^2")),
            "this is a plain number in m/s^2: write 9.81"
        );
        assert_eq!(help(12.0, "%", Some("")), "this is a plain number without a unit: write 0.12");
        assert_eq!(help(3.0, "mm", Some("Pa")), "stresses and strengths are plain numbers in Pa");
        assert_eq!(help(3.0, "furlongs", Some("m")), "this is a plain number in m");
        assert_eq!(help(5.0, "s", None), "leave the unit out");
    }
}
