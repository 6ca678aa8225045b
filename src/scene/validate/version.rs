//! Parts of a scene that exist in one version of the format only.

use std::fmt::Arguments;

use crate::scene::format::{Measures, Stage, Stop, Strain, Stress};

use crate::scene::spans::join;

use super::Context;
use super::findings::Findings;

/// The remedy for a part of version 2 in a scene of version 1.
const WRITE_2: &str = "write `version: 2`; `clastic check SCENE --upgrade` shows what else changes";

pub(super) fn check(context: &Context, findings: &mut Findings) {
    let scene = context.scene;
    if !findings.is_sure_of("version") {
        return;
    }
    match scene.version {
        1 => of_two(context, findings),
        2 => {
            let Measures { reference_stage, axial_strain, lateral_strain, .. } = &scene.measures;
            let Measures { axial_stress, lateral_stress, list, .. } = &scene.measures;
            let strains = [axial_strain, lateral_strain].iter().any(|of| of.is_some());
            let stresses = [axial_stress, lateral_stress].iter().any(|of| of.is_some());
            if list.is_none() && (strains || stresses || reference_stage.is_some()) {
                let help = "write a list, as in `[(name: \"axial_strain\", of: Strain(...))]`; \
                            `clastic check SCENE --upgrade` does it for a scene of version 1";
                findings.add(format_args!("measures"), "fields are of version 1", help);
            }
            for_stops(context, findings, |path, stop, findings| {
                if let Stop::AxialStrain(strain) = stop {
                    let word = if *strain < 0.0 { "Below" } else { "Above" };
                    let help = format!("write `{word}(\"axial_strain\", {strain:?})`");
                    findings.add(path, "`AxialStrain` is of version 1", &help);
                }
            });
        }
        _ => {}
    }
}

fn of_two(context: &Context, findings: &mut Findings) {
    let scene = context.scene;
    let mut add = |path: &str, what: &str| {
        findings.add(format_args!("{path}"), format!("{what} of version 2"), WRITE_2);
    };
    if !scene.values.is_empty() {
        add("let", "values with names are");
    }
    if scene.cell.is_some() {
        add("cell", "a periodic cell is");
    }
    if scene.reference_stage.is_some() {
        add("reference_stage", "this place is");
    }
    if !scene.minerals.is_empty() {
        add("minerals", "layers and minerals are");
    }
    if scene.keep.is_some() {
        add("keep", "cuts are");
    }
    if scene.measures.list.is_some() {
        add("measures", "a list of measures is");
    }
    let stresses = [
        ("measures.axial_stress", &scene.measures.axial_stress),
        ("measures.lateral_stress", &scene.measures.lateral_stress),
    ];
    for (path, stress) in stresses {
        if let (Some(Stress::Region { .. }), None) = (stress, &scene.measures.list) {
            add(path, "`Region` is");
        }
    }
    let strains = [
        ("measures.axial_strain", &scene.measures.axial_strain),
        ("measures.lateral_strain", &scene.measures.lateral_strain),
    ];
    for (path, strain) in strains {
        if let (Some(Strain::Region { .. }), None) = (strain, &scene.measures.list) {
            add(path, "`Region` is");
        }
    }
    for (i, stage) in scene.stages.iter().enumerate() {
        if let Stage::Pour(_) = stage {
            findings.add(format_args!("stages[{i}]"), "`Pour` is of version 2", WRITE_2);
        }
        for (name, control) in stage.load().into_iter().flat_map(|load| &load.rigid) {
            if !control.walls.is_empty() {
                let path = format!("{}.walls", join(&format!("stages[{i}].rigid"), name));
                findings.add(format_args!("{path}"), "walls in a group are of version 2", WRITE_2);
            }
        }
    }
    for_stops(context, findings, |path, stop, findings| {
        let name = match stop {
            Stop::Below(..) => "Below",
            Stop::Above(..) => "Above",
            Stop::Until(..) => "Until",
            Stop::Full(..) => "Full",
            _ => return,
        };
        findings.add(path, format!("`{name}` is of version 2"), WRITE_2);
    });
}

fn for_stops(
    context: &Context,
    findings: &mut Findings,
    mut see: impl FnMut(Arguments, &Stop, &mut Findings),
) {
    for (i, stage) in context.scene.stages.iter().enumerate() {
        let Some(stage) = stage.load() else { continue };
        for (k, stop) in stage.stop.iter().enumerate() {
            see(format_args!("stages[{i}].stop[{k}]"), stop, findings);
        }
    }
}
