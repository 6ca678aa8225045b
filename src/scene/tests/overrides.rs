//! `--set path=value`.

use super::read;
use super::samples::{FULL, SMALL};
use crate::scene::LoadError;
use crate::scene::format::{Specimen, Stage, WallControl};
use crate::scene::overrides::apply;

#[track_caller]
fn set(text: &str, sets: &[&str]) -> String {
    apply(text, sets).unwrap_or_else(|error| panic!("{error}")).text
}

#[track_caller]
fn refused(setting: &str, message: &str) {
    match read(SMALL, &[setting]) {
        Err(error @ LoadError::Set(_)) => {
            assert_eq!(error.to_string(), format!("--set {setting}: {message}"));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_value_is_replaced_and_comments_stay() {
    let text = set(FULL, &["materials.grain.contact.friction=0.7", "stages.shear.increments = 20"]);
    let expected = FULL.replace("friction: 0.5)", "friction: 0.7)").replacen(
        "\"shear\",\n            increments: 10",
        "\"shear\",\n            increments: 20",
        1,
    );
    assert_eq!(text, expected);
}

/// A setting in place of the only use of a name was refused: "no number uses it".
#[test]
fn a_setting_may_take_the_only_use_of_a_name() {
    let named =
        SMALL.replace("version: 1,", "version: 1, let: { \"depth\": 2.0 }, thickness: depth,");
    assert!(named != SMALL);
    assert_eq!(read(&named, &["thickness=3.0"]).unwrap().scene.thickness, 3.0);
    let idle = named.replace("thickness: depth,", "");
    assert!(read(&idle, &["thickness=3.0"]).is_err());
}

#[test]
fn later_settings_see_earlier_ones() {
    let sets = ["analysis=Dynamic(dt: 1.0)", "analysis.dt=1e-3", "analysis.theta=0.5"];
    let text = set(SMALL, &sets);
    assert!(text.contains("analysis: Dynamic(dt: 1e-3, theta: 0.5)"), "{text}");
}

#[test]
fn an_absent_field_is_inserted_with_what_is_around_it() {
    let loaded = read(SMALL, &["acceptance.turn=0.1", "walls.top.contact.friction=0.3"]).unwrap();
    assert_eq!(loaded.scene.acceptance.turn, 0.1);
    assert_eq!(loaded.scene.walls[1].contact.friction, 0.3);
}

#[test]
fn a_map_entry_is_inserted() {
    let loaded = read(SMALL, &["stages.load.walls.bottom=Fixed"]).unwrap();
    let Stage::Load(load) = &loaded.scene.stages[0] else { panic!() };
    assert_eq!(load.walls["bottom"], WallControl::Fixed);
}

#[test]
fn the_place_after_the_last_item_takes_a_new_one() {
    let more = ["stages[1]=Load(name: \"more\", increments: 3)", "stages.more.increments=4"];
    let stages = read(SMALL, &more).unwrap().scene.stages;
    assert_eq!(stages.len(), 2);
    assert!(matches!(&stages[1], Stage::Load(load) if load.increments == 4));
    let gap = ["stages[2]=Load(name: \"more\", increments: 3)"];
    assert!(matches!(read(SMALL, &gap), Err(LoadError::Set(_))));
}

#[test]
fn a_bare_word_is_a_text_where_only_a_text_fits() {
    let loaded = read(SMALL, &["title=A title, (unbalanced", "specimen[0].group=low"]).unwrap();
    assert_eq!(loaded.scene.title, "A title, (unbalanced");
    let Specimen::Particles(list) = &loaded.scene.specimen else { panic!() };
    assert_eq!(list[0].group.as_deref(), Some("low"));
}

#[test]
fn a_setting_that_does_not_fit_is_refused() {
    refused(
        "thickness",
        "not a setting; write path=value, as in `materials.grain.contact.friction=0.3`",
    );
    refused(
        "stages.laod.increments=3",
        "no such field; did you mean `stages.load`? there is `stages.load`",
    );
    refused(
        "walls.tpo.contact.friction=3",
        "no such field; did you mean `walls.top`? there is `walls.bottom`, `walls.top`",
    );
    refused("specimen[2].radius=1.0", "no such field; there is `specimen[0]`, `specimen[1]`");
    refused("materials.sand.density=1.0", "no such field; there is `materials.grain`");
    refused("title.x=1", "no such field; `title` is `\"Small\"`, which has no fields");
    refused(
        "materials.grain.contact.frictoin=0.3",
        "unknown field `frictoin`; did you mean `friction`? the fields here are \
         `normal_stiffness`, `tangential_stiffness`, `rolling_stiffness`, `friction`, `rolling_friction`, `restitution`",
    );
    refused(
        "stages.load.increments=many",
        "expected a whole number from 0 to 4294967295, found `many`",
    );
    refused("thickness=1.0, version: 1", "`1.0, version: 1` is not a value in RON");
    refused("thickness=1.0 // thin", "`1.0 // thin` is not a value in RON");
    refused("thickness=", "`` is not a value in RON");
    refused(
        "analysis=Dynamic",
        "expected `Dynamic(...)`, found `Dynamic`; its fields are `dt`, `theta`",
    );
    refused(
        "solver.tolerance=1e-9",
        "expected one of `Condensed`, `Clarabel`, found `(tolerance: 1e-9)`",
    );
}

#[test]
fn a_wrong_value_is_known_to_come_from_a_setting() {
    let error = read(SMALL, &["walls.top.contact.friction=-0.3"]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "--set walls.top.contact.friction=-0.3: walls[1].contact.friction: negative (-0.3); \
         give a coefficient of 0 or more"
    );
    assert!(matches!(error, LoadError::Scene(_)));
}

#[test]
fn a_broken_scene_is_reported_as_such() {
    let error = read(&SMALL.replace("Force(1.0)", "Force(1.0"), &["version=1"]).unwrap_err();
    assert!(matches!(error, LoadError::Scene(_)));
}

#[test]
fn a_wall_that_is_not_there_is_a_wrong_setting() {
    refused(
        "stages.load.walls.tpo=Fixed",
        "stages[0].walls.tpo: unknown wall (`tpo`); did you mean `top`? \
         there are the walls `bottom`, `top`",
    );
}

#[test]
fn places_are_those_of_the_file_and_not_of_the_edited_text() {
    let wrong = SMALL.replace("increments: 4", "increments: 0");
    let sets = ["specimen[0].group=a,\n\n\nb", "materials.grain.density=1000.0"];
    let error = read(&wrong, &sets).unwrap_err();
    assert_eq!(
        error.to_string(),
        "s.ron:21:25: stages[0].increments: zero (0); give a number of 1 or more"
    );
    // A mistake elsewhere that a setting causes is reported at its place in the file.
    let error = read(SMALL, &["walls.top.name=lid"]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "s.ron:22:21: stages[0].walls.top: unknown wall (`top`); there are the walls `bottom`, `lid`"
    );
}
