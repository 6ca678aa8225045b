//! Numbers with a unit, which scenes do not accept: all numbers are in SI units.

use std::f64::consts::PI;

/// Units that scenes may have: name, value in SI units, and powers of m, kg, s and rad.
const BASE: [(&str, f64, [i32; 4]); 14] = [
    ("m", 1.0, [1, 0, 0, 0]),
    ("g", 1e-3, [0, 1, 0, 0]),
    ("t", 1e3, [0, 1, 0, 0]),
    ("s", 1.0, [0, 0, 1, 0]),
    ("min", 60.0, [0, 0, 1, 0]),
    ("h", 3600.0, [0, 0, 1, 0]),
    ("N", 1.0, [1, 1, -2, 0]),
    ("Pa", 1.0, [-1, 1, -2, 0]),
    ("bar", 1e5, [-1, 1, -2, 0]),
    ("rad", 1.0, [0, 0, 0, 1]),
    ("deg", PI / 180.0, [0, 0, 0, 1]),
    ("°", PI / 180.0, [0, 0, 0, 1]),
    ("rpm", PI / 30.0, [0, 0, -1, 1]),
    ("%", 1e-2, [0; 4]),
];

/// Prefixes, and none.
const PREFIXES: [(&str, f64); 9] = [
    ("", 1.0),
    ("G", 1e9),
    ("M", 1e6),
    ("k", 1e3),
    ("h", 1e2),
    ("c", 1e-2),
    ("m", 1e-3),
    ("u", 1e-6),
    ("µ", 1e-6),
];

/// Value in SI units and powers of m, kg, s and rad of a unit such as `kN/m2` or `N m`. Of the
/// readings of a name the longest counts: `mm` is no square metre.
pub(super) fn parse(unit: &str) -> Option<(f64, [i32; 4])> {
    let (mut value, mut powers) = (1.0, [0; 4]);
    for (k, mut left) in unit.split('/').enumerate() {
        let sign = if k == 0 { 1 } else { -1 };
        while !left.is_empty() {
            let readings = PREFIXES.into_iter().flat_map(|(prefix, factor)| {
                BASE.into_iter().filter_map(move |(name, of_base, dimension)| {
                    let rest = left.strip_prefix(prefix)?.strip_prefix(name)?;
                    Some((rest, factor * of_base, dimension))
                })
            });
            let (rest, factor, dimension) = readings.min_by_key(|(rest, ..)| rest.len())?;
            let digits = rest.find(|c: char| c != '-' && !c.is_ascii_digit()).unwrap_or(rest.len());
            let (power, rest) = rest.split_at(digits);
            let power =
                sign * if power.is_empty() { 1 } else { i32::from(power.parse::<i8>().ok()?) };
            value *= factor.powi(power);
            for (sum, of_base) in powers.iter_mut().zip(dimension) {
                *sum += power * of_base;
            }
            left = rest.trim_start();
        }
    }
    Some((value, powers))
}

/// SI unit of a number in a field or variant with this name, inside a value with the unit `around`.
/// The empty text means a number without dimension. `None` means that the name is unknown or not
/// that of a number.
pub(crate) fn unit_of(name: &str, around: Option<&'static str>) -> Option<&'static str> {
    Some(match name {
        "position" | "size" | "radius" | "radii" | "limits" | "spacing" | "origin" | "start"
        | "moved" | "end" | "min" | "max" | "about" | "centre" | "length" | "step"
        | "thickness" | "ball" | "Height" | "x" | "y" => "m",
        "rotation" | "angle" => "rad",
        "Displacement" => around.unwrap_or("m"),
        "Velocity" if around == Some("rad") => "rad/s",
        "Velocity" | "velocity" | "Rest" => "m/s",
        "angular_velocity" => "rad/s",
        "gravity" => "m/s^2",
        "density" => "kg/m^3",
        "area" => "m^2",
        "dt" => "s",
        "cohesion" | "tensile_strength" | "stress" | "pressure" => "Pa",
        "normal_stiffness" | "tangential_stiffness" => "N/m",
        "rolling_stiffness" => "N m/rad",
        "force" | "Force" => "N",
        "moment" => "N m",
        "theta" | "friction" | "rolling_friction" | "restitution" | "residual" | "turn"
        | "deviation" | "remains" | "share" | "agitation" | "affine" | "Porosity"
        | "StressDrop" => "",
        // Lengths and areas share this name of a variant.
        "Fixed" => return around,
        _ => return None,
    })
}

/// Splits a number and the unit after it: `1.5 MPa`.
pub(crate) fn split(literal: &str) -> Option<(f64, &str)> {
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

/// Whether a text is a unit.
pub(crate) fn is_unit(text: &str) -> bool {
    parse(text).is_some_and(|(_, powers)| powers != [0; 4])
}

/// The remedy for a number with a unit, if `wanted` is the unit of the field.
pub(crate) fn help(number: f64, unit: &str, wanted: Option<&str>) -> String {
    let unit = unit.replace('²', "2").replace('³', "3").replace("**", "").replace('^', "");
    let Some(wanted) = wanted else {
        // To leave another unit out would change the value. What a per cent or a g is of depends on
        // the field.
        return match parse(&unit) {
            Some((value, powers)) if powers != [0; 4] && value != 1.0 && unit != "g" => {
                format!("numbers are in SI units: write {}", short_number(number * value))
            }
            _ if unit == "%" => {
                let part = short_number(number / 100.0);
                format!("leave the unit out; as a part of 1 it is {part}")
            }
            _ => "leave the unit out".to_owned(),
        };
    };
    let what = match wanted {
        "" => "this is a plain number without a unit".to_owned(),
        "Pa" => "stresses and strengths are plain numbers in Pa".to_owned(),
        si => format!("this is a plain number in {si}"),
    };
    let factor = match (parse(&unit), parse(&wanted.replace('^', ""))) {
        _ if unit == "g" && wanted == "m/s^2" => 9.81,
        (Some((value, written)), Some((_, meant))) if written == meant => value,
        _ => return what,
    };
    format!("{what}: write {}", short_number(number * factor))
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
        for (unit, si, value) in [
            ("mm", "m", 1e-3),
            ("mm^2", "m^2", 1e-6),
            ("N/mm²", "Pa", 1e6),
            ("kN m", "N m", 1e3),
            ("kNm", "N m", 1e3),
            ("MN/m", "N/m", 1e6),
            ("Mg/m^3", "kg/m^3", 1e3),
            ("m s^-2", "m/s^2", 1.0),
            ("g", "m/s^2", 9.81),
            ("min", "s", 60.0),
            ("hPa", "Pa", 100.0),
            ("deg/s", "rad/s", PI / 180.0),
        ] {
            let said = help(1.0, unit, Some(si));
            assert!(said.ends_with(&format!(": write {}", short_number(value))), "{unit}: {said}");
        }
        assert_eq!(help(3.0, "mm", Some("Pa")), "stresses and strengths are plain numbers in Pa");
        assert_eq!(help(3.0, "furlongs", Some("m")), "this is a plain number in m");
        assert_eq!(help(5.0, "s", None), "leave the unit out");
        // The diameter of a sieve was 2 m without its unit.
        assert_eq!(help(2.0, "mm", None), "numbers are in SI units: write 0.002");
        assert_eq!(help(40.0, "%", None), "leave the unit out; as a part of 1 it is 0.4");
        assert_eq!(help(1.0, "g", None), "leave the unit out");
    }
}
