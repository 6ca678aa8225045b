//! End of an increment: its status, and whether its stage and the run continue.

use bevy_ecs::prelude::*;

use clastic_components::prelude::*;
use clastic_systems::mechanism::proof;
use clastic_systems::rupture::dense::is_unsettled;
use clastic_systems::stepping::{EndOfRun, StoppedBy};

use super::advice::with_advice;
use super::measures::{error_of, reading};
use super::script::{Collapse, CollapsedBy, EndedBy, Outcome, Script};
use super::{compact, load, until};
use crate::scene::format::{Stage, Stop};

impl Collapse {
    /// The collapse that the last increment found.
    fn found(world: &World, stage: &Stage) -> Self {
        let Attempt { complaint, moved, .. } = world.resource();
        let (by, mut reason) = if let Some(proof) = proof(world) {
            (CollapsedBy::Proof, proof)
        } else {
            let reason = format!(
                "{complaint}; nor does it in steps half as long; no mechanism proves the collapse"
            );
            (CollapsedBy::Motion, reason)
        };
        // A mechanism may be that of one loose grain, and the motion that of a slide.
        if let Some(share) = moved {
            reason += &format!("; the motion moved {share} by more than a radius");
        }
        let increment = world.resource::<ClasticProgress>().increment;
        Self { stage: stage.name().to_owned(), increment, by, reason }
    }
}

/// Evaluates the status of the increment and the stop conditions of the stage. Exclusive, because a
/// collapse or a stop affects all walls and particles.
pub fn end_increment(world: &mut World) {
    let index = world.resource::<ClasticProgress>().stage;
    let Some(stage) = world.resource::<Script>().stage(index).cloned() else { return };
    let stage = &stage;
    if until::repeats(world, stage) || compact::jams(world, stage) {
        return;
    }
    let status = world.resource::<Attempt>().status;
    let (mut held, mut passed) = (None, None);
    let ended_by = match status {
        IncrementStatus::Solved | IncrementStatus::Capped => {
            let relaxes = world.resource::<ClasticProgress>().relaxing;
            let waits = relaxes || world.resource::<Observation>().in_avalanche;
            if !world.resource::<Observation>().in_avalanche {
                let landed = until::reached(world, stage);
                let found = stopped(world, stage).map(|stop| (stop, None)).or(landed);
                // A stage ends only after its last avalanche.
                if let Some((stop, beyond)) = found.filter(|_| !relaxes) {
                    (held, passed) = (Some(stop), beyond);
                }
            }
            let ends = held.is_some() || (world.resource::<Script>().stop && !waits);
            if ends && is_unsettled(world.resource(), world.resource(), world.resource()) {
                // The conditions are read again in the equilibrium at constant load.
                world.resource_mut::<ClasticProgress>().relaxing = true;
                held = None;
                None
            } else {
                ends.then_some(EndedBy::Stop)
            }
        }
        IncrementStatus::Collapsed => {
            let collapse = Collapse::found(world, stage);
            world.resource_mut::<Script>().collapse.get_or_insert(collapse);
            Some(EndedBy::Collapse)
        }
        IncrementStatus::Undecided => {
            let increment = world.resource::<ClasticProgress>().increment;
            let complaint = world.resource::<Attempt>().complaint.clone();
            let message = with_advice(world, stage, complaint);
            world.resource_mut::<Script>().outcome =
                Some(Outcome::Undecided { increment, message });
            Some(EndedBy::Undecided)
        }
    };
    let done = world.resource::<ClasticProgress>().done;
    let is_unbalanced = status.is_committed() && world.resource::<Corrections>().capped;
    let came = super::pour::came(world, stage);
    let set_aside = world.query_filtered::<(), With<SetAside>>().iter(world).count() as u64;
    if let Some(end) = world.resource_mut::<Script>().ends.last_mut() {
        end.rows += 1;
        end.increments = done.ceil() as u64;
        (end.set_aside, end.came) = (set_aside, came);
        end.capped += u64::from(status == IncrementStatus::Capped);
        end.unbalanced += u64::from(is_unbalanced);
        (end.ended_by, end.stop, end.passed) = (ended_by, held, passed);
    }
    if matches!(ended_by, Some(EndedBy::Stop | EndedBy::Collapse)) {
        load::end_stage(world);
    }
}

/// The first stop condition of the stage that is met.
fn stopped(world: &mut World, stage: &Stage) -> Option<Stop> {
    let stress = world.resource::<Observation>().axial_stress;
    let time = world.resource::<ClasticProgress>().time;
    let mut velocities = world.query::<&BodyVelocity>();
    let maximum = velocities.iter(world).map(|v| v.0.length()).fold(0.0, f64::max);
    let mut script = world.resource_mut::<Script>();
    let last = script.speed.replace(maximum);
    if let Some(stress) = stress.filter(|s| s.abs() > script.peak.abs()) {
        script.peak = stress;
    }
    // The peak is negative in a tension test.
    let (peak, sign) = (script.peak.abs(), script.peak.signum());
    let held = stage.stop().iter().find(|stop| match **stop {
        // A drop below the error of the stress may be caused by this error.
        Stop::StressDrop(fraction) => {
            stress.is_some_and(|s| peak > 0.0 && sign * s < fraction * peak)
                && (1.0 - fraction) * peak > error_of(world, "axial_stress")
        }
        // A body that starts to fall is slow as well. At rest the speed does not increase.
        Stop::Rest(speed) => maximum < speed && last.is_some_and(|last| maximum <= last),
        Stop::Full(patience) => world
            .get_resource::<Poured>()
            .and_then(|poured| poured.waits_since)
            .is_some_and(|since| time - since >= patience * (1.0 - 1e-12)),
        // See `until`.
        Stop::Until(..) => false,
        // An error must not cause one more increment.
        Stop::Below(ref name, limit) => reading(world, name)
            .is_some_and(|value| value <= limit || value <= limit + error_of(world, name)),
        Stop::Above(ref name, limit) => reading(world, name)
            .is_some_and(|value| value >= limit || value >= limit - error_of(world, name)),
    });
    held.cloned()
}

/// Tells the engine that the run has ended, so that the app stops.
pub(super) fn end_run(script: Res<Script>, mut end: ResMut<EndOfRun>) {
    let Some(outcome) = &script.outcome else { return };
    end.0 = Some(match outcome {
        Outcome::Completed => (StoppedBy::Completed, "all stages of the scene have ended".into()),
        Outcome::Collapsed(collapse) => (
            StoppedBy::Collapsed,
            format!("all stages have ended; `{}` collapsed: {}", collapse.stage, collapse.reason),
        ),
        Outcome::Undecided { message, .. } => (StoppedBy::Undecided, message.clone()),
        Outcome::Halted(message) => (StoppedBy::Halted, message.clone()),
        Outcome::Refused { message, .. } => (StoppedBy::Refused, message.clone()),
    });
}
