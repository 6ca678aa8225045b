//! Scene files and stored specimens.

use std::fs;
use std::path::Path;

use super::samples::SMALL;
use crate::scene::specimen_file::{StoredParticle, read, write};
use crate::scene::{LoadError, load};

const STORED: &str = r#"specimen: File(path: "stored.csv")"#;

fn stored_scene() -> String {
    let (head, rest) = SMALL.split_once("specimen: Particles").unwrap();
    let (_, tail) = rest.split_once("]),").unwrap();
    format!("{head}{STORED},{tail}")
}

/// Messages about a scene with this stored specimen.
fn complaint(csv: impl AsRef<[u8]>) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.ron"), stored_scene()).unwrap();
    fs::write(folder.path().join("stored.csv"), csv).unwrap();
    let error = load(&folder.path().join("scene.ron"), &[]).unwrap_err();
    assert!(matches!(error, LoadError::Scene(_)));
    let folder = format!("{}/", folder.path().display());
    error.to_string().replace(&folder, "")
}

#[test]
fn numbers_read_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.csv");
    let row = |x, y, r, material: Option<&str>| StoredParticle {
        x,
        y,
        r,
        material: material.map(str::to_owned),
    };
    for named in [None, Some("fine sand")] {
        let rows = vec![
            row(0.1 + 0.2, -1.0 / 3.0, 1e-30, named),
            row(f64::MIN_POSITIVE, 1e30, 5e-24, None),
        ];
        write(&path, &rows).unwrap();
        assert_eq!(read(&path).unwrap().rows, rows);
    }
    assert!(write(&path, &[row(0.0, 0.0, 1.0, Some("a,b"))]).is_err());
}

#[test]
fn a_stored_specimen_is_found_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.ron");
    fs::write(&scene, stored_scene()).unwrap();
    fs::write(folder.path().join("stored.csv"), "# two\nx_m,y_m,radius_m\n0,1,1\n\n2,1,1\n")
        .unwrap();
    let loaded = load(&scene, &[]).unwrap();
    assert_eq!(loaded.specimen.unwrap().rows.len(), 2);
}

#[test]
fn a_group_of_a_stored_specimen_can_be_cut_away() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.ron");
    let cut = format!("{STORED}, keep: Except(All, Group(\"rim\"))");
    fs::write(&scene, stored_scene().replace(STORED, &cut)).unwrap();
    let rows = "x_m,y_m,radius_m,group\n0,1,1,\n2,1,1,rim\n";
    fs::write(folder.path().join("stored.csv"), rows).unwrap();
    load(&scene, &[]).unwrap();
    fs::write(&scene, stored_scene().replace(STORED, &cut.replace("rim", "core"))).unwrap();
    let error = load(&scene, &[]).unwrap_err().to_string();
    assert!(error.contains("the specimen has no group `core`"), "{error}");
}

#[test]
fn each_bad_row_is_named() {
    assert_eq!(
        complaint("x_m,y_m,radius_m\n0,NaN,1\n# note\n2, 2,-1\n4,1\n6,x,1\n"),
        "stored.csv:2:3: y_m: not finite (NaN); give a number in m\n\
         stored.csv:4:6: radius_m: not greater than 0 (-1.0); give a radius in m\n\
         stored.csv:5:1: 2 values (`4,1`); this file has 3 columns\n\
         stored.csv:6:3: y_m: not a number (`x`); give a number in m"
    );
    assert_eq!(
        complaint("x_m,y_m,radius_m\n0,1,1\n2,1,1\n0,1,1\n"),
        "stored.csv:4:1: x_m: the same place as the particle of line 2; leave one of them out"
    );
    assert_eq!(
        complaint("x,y,r\n"),
        "stored.csv:1:1: unknown columns `x,y,r`; \
         the first line is `x_m,y_m,radius_m`, and optionally `material` and `group` after it"
    );
    assert_eq!(complaint(""), "stored.csv:1:1: no header; the first line is `x_m,y_m,radius_m`");
    assert_eq!(
        complaint(b"x_m,y_m,radius_m\n0,\xff,1\n"),
        "stored.csv:2:3: not UTF-8 text (byte 0xff); save it as UTF-8"
    );
}

#[test]
fn a_specimen_of_only_a_header_is_an_error() {
    for csv in
        ["x_m,y_m,radius_m\n", "# note\nx_m,y_m,radius_m,material", "x_m,y_m,radius_m\n# one\n\n"]
    {
        let said = complaint(csv);
        assert!(said.starts_with("stored.csv:") && !said.contains('\n'), "{said}");
        assert!(said.contains("no particles: only a header; give every particle a line"), "{said}");
    }
    assert!(complaint("x_m,y_m,radius_m\n").starts_with("stored.csv:2:1: "));
}

#[test]
fn the_engines_own_final_particles_are_a_specimen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("final_particles.csv");
    let columns = crate::output::frames::COLUMNS.join(",");
    fs::write(
        &path,
        format!("{columns}\n0,0.5,1.0,1.0,0.1,2e-3,-3e-3\n1,2.5,1.0,1.0,0.0,0.0,0.0\n"),
    )
    .unwrap();
    let disks: Vec<_> = read(&path).unwrap().rows.into_iter().map(|d| (d.x, d.y, d.r)).collect();
    assert_eq!(disks, [(0.5, 1.0, 1.0), (2.5, 1.0, 1.0)]);
    // Places of mistakes are those in the file, whatever its columns.
    assert_eq!(
        complaint(format!("{columns}\n0,1,1,1,1,1,1\n0,7,1,-1,1,1,1\n")),
        "stored.csv:3:7: radius_m: not greater than 0 (-1.0); give a radius in m"
    );
    assert_eq!(
        complaint("x_m,y_m,radius_m,mass\n0,1,1,1\n"),
        "stored.csv:1:1: unknown columns `x_m,y_m,radius_m,mass`; \
         the first line is `x_m,y_m,radius_m`, and optionally `material` and `group` after it"
    );
    assert!(complaint("x_m,y_m,id\n0,1,1\n").contains("`radius_m` is missing"));
    assert!(complaint("x_m,x_m,y_m,radius_m\n").contains("given twice"));
}

#[test]
fn rows_are_checked_against_the_scene() {
    assert_eq!(
        complaint("x_m,y_m,radius_m,material\n0,1,1,\n2,-1,1,grain\n3,1,1,sand\n"),
        "scene.ron:10:26: specimen.path: unknown material (`sand`); there is only `grain`\n\
         scene.ron:10:26: specimen.path: particle 1 of the file is behind wall `bottom` \
         (2.0, -1.0); move it inside; a wall has its inside on the left of start to end"
    );
}

#[test]
fn a_missing_specimen_is_placed_in_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.ron");
    fs::write(&scene, stored_scene()).unwrap();
    let message = load(&scene, &[]).unwrap_err().to_string();
    assert!(message.contains("scene.ron:10:26: specimen.path: cannot read"), "{message}");
    fs::create_dir(folder.path().join("stored.csv")).unwrap();
    let message = load(&scene, &[]).unwrap_err().to_string();
    assert!(message.contains("it is a directory"), "{message}");
}

#[test]
fn a_scene_file_that_cannot_be_read() {
    let error = load(Path::new("no/such/scene.ron"), &[]).unwrap_err();
    assert!(matches!(error, LoadError::Read { .. }));
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.ron");
    fs::write(&scene, b"(\n  title: \"\xe9\")").unwrap();
    let error = load(&scene, &[]).unwrap_err();
    assert!(matches!(error, LoadError::Scene(_)));
    assert!(error.to_string().contains("scene.ron:2:11: not UTF-8 text"), "{error}");
}
