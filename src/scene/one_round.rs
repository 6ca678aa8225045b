//! Where bonds do not break from event to event although the scene says so.

use super::format::{Analysis, Bond, Contact, RollingLimit, RuptureOrder, Scene, Stage};
use crate::text::shown::label;

/// Why `rupture.order: Events` does not hold, in words; `None` if it holds in all stages that load
/// bonds, or if the scene has another order or no bonds. Bonds then break as with `OneRound`.
pub fn one_round(scene: &Scene) -> Option<String> {
    if scene.rupture.order != RuptureOrder::Events {
        return None;
    }
    let cemented = scene.stages.iter().any(|stage| matches!(stage, Stage::Cement(_)));
    if !cemented && scene.bonds.is_empty() {
        return None;
    }
    let bonds = scene.laws().find_map(|(kind, name, contact, bond)| {
        let of_materials = || scene.materials.values().map(|material| material.contact).collect();
        let contacts = contact.map_or_else(of_materials, |contact| vec![contact]);
        let reason = obstacle(&bond?, &contacts, scene.rupture.rolling)?;
        Some(format!("bonds of {kind} {} {reason}", label(name)))
    });
    bonds.or_else(|| {
        let is_unbonded =
            |stage: &&Stage| scene.bonds.is_empty() && !matches!(stage, Stage::Cement(_));
        let bonded = scene.stages.iter().skip_while(is_unbonded);
        bonded.into_iter().find_map(|stage| dynamic(stage, scene.analysis))
    })
}

/// Properties of the law of a bond that exclude `Events`. A stiffness that it does not name is that of its
/// contacts.
fn obstacle(bond: &Bond, contacts: &[Contact], rolling: RollingLimit) -> Option<&'static str> {
    let is_rigid = contacts.iter().any(|of| {
        bond.normal_stiffness.or(of.normal_stiffness).is_none()
            || bond.tangential_stiffness.or(of.tangential_stiffness).is_none()
    });
    let has_strength = bond.cohesion > 0.0 && bond.tensile_strength > 0.0;
    if is_rigid {
        Some("are rigid (`normal_stiffness` or `tangential_stiffness` is missing)")
    } else if !has_strength {
        Some("have no strength (`cohesion` or `tensile_strength` is 0)")
    } else if rolling == RollingLimit::Breaks && bond.rolling_friction > 0.0 {
        Some("break in rolling (`rolling_friction` is above 0 and `rupture.rolling` is `Breaks`)")
    } else {
        None
    }
}

fn dynamic(stage: &Stage, of_scene: Analysis) -> Option<String> {
    let has_time = match stage {
        Stage::Custom(custom) => custom.increments > 0,
        _ => stage.load().is_some(),
    };
    let is_dynamic = has_time && stage.analysis().unwrap_or(of_scene) != Analysis::Static;
    is_dynamic.then(|| format!("stage {} is dynamic", label(stage.name())))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::scene::load::from_str;

    use super::one_round;

    /// Reason for bonds of this law on rigid contacts.
    fn reason(rupture: &str, bond: &str, analysis: &str) -> Option<String> {
        reason_on("", rupture, bond, analysis)
    }

    fn reason_on(contact: &str, rupture: &str, bond: &str, analysis: &str) -> Option<String> {
        let text = format!(
            "(version: 1, title: \"t\", rupture: ({rupture}),
              materials: {{ \"m\": (contact: ({contact}),
                bond: ({bond} cohesion: 1.0, tensile_strength: 1.0)) }},
              specimen: Particles([(position: (0.0, 0.0), radius: 1.0), (position: (2.0, 0.0), radius: 1.0)]),
              bonds: [(a: 0, b: 1)],
              stages: [Load(name: \"s\", increments: 1, analysis: {analysis})])"
        );
        one_round(&from_str(&text, Path::new("t.ron"), Path::new(""), &[]).unwrap().scene)
    }

    const ELASTIC: &str = "normal_stiffness: 1.0, tangential_stiffness: 1.0,";

    #[test]
    fn the_obstacle_is_named() {
        assert_eq!(reason("", ELASTIC, "Static"), None);
        assert_eq!(reason("order: OneRound", "", "Static"), None);
        let rigid = reason("", "normal_stiffness: 1.0,", "Static").unwrap();
        assert!(rigid.starts_with("bonds of material m are rigid"), "{rigid}");
        assert_eq!(reason_on(ELASTIC, "", "", "Static"), None, "as stiff as their contacts");
        let normal = "normal_stiffness: 1.0,";
        assert_eq!(reason_on("tangential_stiffness: 1.0,", "", normal, "Static"), None);
        let rolling = format!("{ELASTIC} rolling_friction: 0.1,");
        let breaks = reason("", &rolling, "Static").unwrap();
        assert!(breaks.starts_with("bonds of material m break in rolling"), "{breaks}");
        assert_eq!(reason("rolling: Yields", &rolling, "Static"), None);
        let dynamic = reason("", ELASTIC, "Dynamic(dt: 1.0, theta: 1.0)").unwrap();
        assert_eq!(dynamic, "stage s is dynamic");
    }
}
