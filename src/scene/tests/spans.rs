//! Paths and places.

use super::samples::FULL;
use crate::text::scan::scan;
use crate::text::spans::{Step, nearest, parse_path, span_of, write_path};

#[track_caller]
fn says(path: &str, value: &str) {
    let span = span_of(FULL, path).unwrap_or_else(|| panic!("no {path}"));
    assert_eq!(&FULL[span], value, "{path}");
}

#[test]
fn paths_lead_to_values() {
    says("title", r##"r#"Everything "at once" (and more)"#"##);
    says("gravity[1]", "-9.81");
    says("analysis.dt", "1e-4");
    says("friction_law", "Coulomb()");
    says("rupture.density", "5.0");
    says("materials.grain.density", "2_650.0");
    says("materials.grain.contact.friction", "0.5");
    says("materials[\"fine sand\"].contact.rolling_friction", "0.1");
    says("specimen[1].velocity", "(0.0, 1.0)");
    says("specimen[2].material", "Some(\"fine sand\")");
    says("bonds[0].b", "1");
    says("walls[3].start[0]", "1.0");
    says("walls.bottom.contact.friction", "0.2");
    says("stages[0].target[0]", "0.2");
    says("stages.glue.length", "0.01");
    says("stages.shear.walls.top.between[1]", "\"right\"");
    says("stages.shear.walls.left[0]", "1e-3");
    says("stages.shear.walls.right", "Force(2.0)");
    says("stages.shear.walls.right[0]", "2.0");
    says("stages.shear.particles[1].select[1]", "2");
    says("stages.shear.particles[2].affine[1][1]", "-0.1");
    says("stages.shear.particles[4].select.max", "(1.0, 1.0)");
    says("stages[\"let go\"].stop[0][0]", "1e-6");
    says("measures.axial_stress.of.length[0]", "\"left\"");
    says("measures.lateral_stress.of.area[1][0]", "\"top\"");
    says("output.plots", "false");
}

#[test]
fn keys_have_places() {
    let root = scan(FULL).0.unwrap();
    for (path, key) in [("stages.shear.walls.lid", "\"lid\": "), ("output.plots", "plots: ")] {
        assert!(FULL[nearest(&root, path, true)..].starts_with(key), "{path}");
    }
}

#[test]
fn an_absent_field_is_placed_where_it_would_be() {
    let (start, root) = (|path| span_of(FULL, path).unwrap().start, scan(FULL).0.unwrap());
    assert_eq!(span_of(FULL, "walls.top.probe"), None);
    assert_eq!(nearest(&root, "walls.top.probe", false), start("walls.top"));
    assert_eq!(nearest(&root, "nothing", true), start(""));
}

#[test]
fn malformed_paths_are_refused() {
    for path in [".a", "a..b", "a.", "a[", "a[x]", "a[0]b", "[\"a", "a]["] {
        let steps = parse_path(path);
        assert!(steps.is_none() || path == "a][", "{path}: {steps:?}");
    }
    let path = "materials[\"fine sand\"].x[3][1].y";
    assert_eq!(write_path(&parse_path(path).unwrap()), path);
    assert_eq!(parse_path("[2]"), Some(vec![Step::Index(2)]));
}

#[test]
fn slips_do_not_hide_the_rest() {
    let text = "(a: 1 b: 2, c = 3, d: , e: [1,, 2])";
    assert_eq!(span_of(text, "b"), Some(9..10));
    assert_eq!(span_of(text, "c"), Some(16..17));
    assert_eq!(span_of(text, "e[2]"), Some(32..33));
}
