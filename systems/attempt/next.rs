//! Next action after a verdict: a pure function of mode, verdict and remaining options.

use clastic_components::attempt::{Effort, IncrementStatus, Mode, Verdict};
use clastic_components::motion::Motion;

/// Options that an increment still has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Whether another motion may begin, which requires static analysis.
    pub motion: bool,
    /// Whether another step of a motion is allowed.
    pub step: bool,
    /// Whether the increment may be halved once more.
    pub half: bool,
    /// Whether the increment searches for the next event.
    pub searches: bool,
    /// Whether bonds may break at a part of the increment: one by one, or together.
    pub breaks: bool,
    /// Whether halving may cure a far turn: the last one has reduced it, or none was tried.
    pub shrinks: bool,
    /// Whether a proved mechanism has been followed.
    pub is_proved: bool,
}

/// The next action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Solve the program again with the additions of the judges.
    Solve,
    /// Try again with this effort.
    Try(Effort),
    /// Solve at the fraction where the next event is expected.
    Approach,
    /// Follow the motion from the current positions.
    Follow,
    /// Accept the step of the motion and make another one.
    Move,
    /// Repeat the step of the motion with a larger weight.
    Shorten,
    /// Accept the step of the motion and seek the equilibrium from there.
    Rest,
    /// Restore the tables and follow the motion in steps of half the length.
    Repeat,
    /// Restore the tables and halve the increment.
    Halve,
    /// Restore the tables and let the bonds of this increment break in one round at its end.
    OneRound,
    /// Restore the tables and solve for a mechanism that proves the collapse.
    Prove,
    /// End the increment.
    End(IncrementStatus),
}

/// The next action after a verdict.
pub fn next(mode: &Mode, verdict: &Verdict, budget: Budget) -> Next {
    match mode {
        Mode::Equilibrium(effort) => after_equilibrium(*effort, verdict, budget),
        Mode::Motion(motion) => after_motion(motion, verdict, budget),
        Mode::Proof => match verdict {
            Verdict::Again => Next::Solve,
            // The motion has failed twice to come to rest, which shows a collapse even without a
            // mechanism.
            _ => Next::End(IncrementStatus::Collapsed),
        },
    }
}

fn after_equilibrium(effort: Effort, verdict: &Verdict, budget: Budget) -> Next {
    let can_follow = budget.motion && budget.step;
    let lost = || if can_follow { Next::Follow } else { smaller(budget) };
    match verdict {
        Verdict::Sound => Next::End(IncrementStatus::Solved),
        Verdict::Overloaded => Next::Approach,
        Verdict::Loose if can_follow => Next::Follow,
        // Bonds may break at a load below the one that has no equilibrium.
        Verdict::Impossible | Verdict::Loose if budget.breaks && budget.half => Next::Halve,
        // The motion may end where the specimen finds new support.
        Verdict::Impossible if can_follow && !budget.is_proved => Next::Follow,
        Verdict::Impossible | Verdict::Loose => Next::End(IncrementStatus::Collapsed),
        Verdict::Again => Next::Solve,
        Verdict::Unconverged(_) => match effort {
            Effort::Usual => Next::Try(Effort::Regularised),
            Effort::Regularised => lost(),
        },
        Verdict::TooFar(_) if budget.shrinks && budget.half => Next::Halve,
        Verdict::TooFar(_) | Verdict::Released => lost(),
        // `Locked` is not tried again: regularisation does not make rigid bodies movable.
        _ => smaller(budget),
    }
}

fn after_motion(motion: &Motion, verdict: &Verdict, budget: Budget) -> Next {
    match verdict {
        Verdict::Again => Next::Solve,
        Verdict::AtRest => Next::Rest,
        Verdict::GivesWay(_) if budget.is_proved => Next::End(IncrementStatus::Collapsed),
        Verdict::GivesWay(_) if motion.repeated => Next::Prove,
        Verdict::GivesWay(_) => Next::Repeat,
        Verdict::Moving if budget.step => Next::Move,
        Verdict::TooFar(_) | Verdict::Unconverged(_) | Verdict::Impossible | Verdict::Locked
            if budget.step =>
        {
            Next::Shorten
        }
        _ if budget.is_proved => Next::End(IncrementStatus::Collapsed),
        _ => smaller(budget),
    }
}

fn smaller(budget: Budget) -> Next {
    if budget.half {
        Next::Halve
    } else if budget.searches {
        Next::OneRound
    } else {
        Next::End(IncrementStatus::Undecided)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Budget = Budget {
        motion: true,
        step: true,
        half: true,
        searches: true,
        breaks: true,
        shrinks: false,
        is_proved: false,
    };

    fn modes() -> Vec<Mode> {
        let repeated = Motion { repeated: true, ..Motion::default() };
        vec![
            Mode::Equilibrium(Effort::Usual),
            Mode::Equilibrium(Effort::Regularised),
            Mode::Motion(Motion::default()),
            Mode::Motion(repeated.clone()),
            Mode::Motion(Motion { released: true, ..Motion::default() }),
            Mode::Motion(Motion { released: true, ..repeated }),
            Mode::Proof,
        ]
    }

    fn verdicts() -> Vec<Verdict> {
        let reason = String::new();
        vec![
            Verdict::Sound,
            Verdict::Impossible,
            Verdict::Loose,
            Verdict::Again,
            Verdict::Overloaded,
            Verdict::Released,
            Verdict::Unconverged(reason.clone()),
            Verdict::Locked,
            Verdict::TooFar(reason.clone()),
            Verdict::Moving,
            Verdict::AtRest,
            Verdict::GivesWay(reason),
        ]
    }

    fn budgets() -> impl Iterator<Item = Budget> {
        let is = |bits: u32, k: u32| bits & (1 << k) != 0;
        (0..128).map(move |bits| Budget {
            motion: is(bits, 0),
            step: is(bits, 1),
            half: is(bits, 2),
            searches: is(bits, 3),
            shrinks: is(bits, 4),
            is_proved: is(bits, 5),
            breaks: is(bits, 6),
        })
    }

    fn every(check: impl Fn(&Mode, &Verdict, Budget, Next)) {
        for mode in modes() {
            for verdict in verdicts() {
                for budget in budgets() {
                    check(&mode, &verdict, budget, next(&mode, &verdict, budget));
                }
            }
        }
    }

    /// The last column of the table in ARCHITECTURE.md, one line per mode.
    #[test]
    fn the_table_has_every_transition() {
        let word = |debug: String| debug.split('(').next().unwrap_or_default().to_owned();
        let found = std::cell::RefCell::new(std::collections::BTreeSet::new());
        every(|mode, _, _, next| {
            let action = match next {
                Next::End(status) => status.name().to_owned(),
                next => word(format!("{next:?}")),
            };
            found.borrow_mut().insert((word(format!("{mode:?}")), action));
        });
        let equilibrium = "Approach Follow Halve OneRound Solve Try collapsed solved undecided";
        let motion = "Halve Move OneRound Prove Repeat Rest Shorten Solve collapsed undecided";
        let modes =
            [("Equilibrium", equilibrium), ("Motion", motion), ("Proof", "Solve collapsed")];
        let drawn = modes.iter().flat_map(|(mode, actions)| {
            actions.split(' ').map(move |action| ((*mode).to_owned(), action.to_owned()))
        });
        assert_eq!(found.into_inner(), drawn.collect());
    }

    #[test]
    fn only_a_sound_equilibrium_is_solved() {
        every(|mode, verdict, budget, next| {
            let sound = matches!(mode, Mode::Equilibrium(_)) && *verdict == Verdict::Sound;
            let solved = next == Next::End(IncrementStatus::Solved);
            assert_eq!(solved, sound, "{mode:?} {verdict:?} {budget:?}");
        });
    }

    #[test]
    fn a_collapse_has_a_certificate_or_a_motion_without_rest_twice() {
        every(|mode, verdict, budget, next| {
            if next == Next::End(IncrementStatus::Collapsed) {
                let proved = matches!(mode, Mode::Equilibrium(_))
                    && matches!(verdict, Verdict::Impossible | Verdict::Loose);
                let followed = matches!(mode, Mode::Motion(_)) && budget.is_proved;
                let fails = proved || followed || *mode == Mode::Proof;
                assert!(fails, "{mode:?} {verdict:?} {budget:?}");
            }
            if next == Next::Prove {
                let repeated = matches!(mode, Mode::Motion(motion) if motion.repeated);
                assert!(
                    repeated && matches!(verdict, Verdict::GivesWay(_)),
                    "{mode:?} {verdict:?}"
                );
            }
        });
    }

    #[test]
    fn nothing_goes_on_beyond_the_budget() {
        every(|mode, verdict, budget, next| {
            let at = || format!("{mode:?} {verdict:?} {budget:?}");
            match next {
                Next::Follow => assert!(budget.motion && budget.step, "{}", at()),
                Next::Move | Next::Shorten => assert!(budget.step, "{}", at()),
                Next::Halve => assert!(budget.half, "{}", at()),
                Next::OneRound => assert!(budget.searches && !budget.half, "{}", at()),
                // What judges add, trials of events, and efforts have bounds of their own.
                Next::Solve => assert_eq!(*verdict, Verdict::Again, "{}", at()),
                Next::Approach => assert_eq!(*verdict, Verdict::Overloaded, "{}", at()),
                Next::Try(_) | Next::Rest | Next::Repeat | Next::Prove | Next::End(_) => {}
            }
        });
    }

    #[test]
    fn an_undecided_increment_has_tried_everything_that_it_may() {
        every(|mode, verdict, budget, next| {
            if next == Next::End(IncrementStatus::Undecided) {
                assert!(!budget.half && !budget.searches, "{mode:?} {verdict:?} {budget:?}");
                if let (Mode::Equilibrium(_), Verdict::TooFar(_) | Verdict::Released) =
                    (mode, verdict)
                {
                    assert!(!(budget.motion && budget.step), "{budget:?}");
                }
            }
        });
    }

    #[test]
    fn a_motion_at_rest_and_no_other_ends_in_an_equilibrium() {
        every(|mode, verdict, budget, next| {
            let is_there = matches!((mode, verdict), (Mode::Motion(_), Verdict::AtRest));
            assert_eq!(next == Next::Rest, is_there, "{mode:?} {verdict:?} {budget:?}");
        });
    }

    #[test]
    fn a_released_specimen_is_followed() {
        for effort in [Effort::Usual, Effort::Regularised] {
            let next = next(&Mode::Equilibrium(effort), &Verdict::Released, ALL);
            assert_eq!(next, Next::Follow);
        }
    }

    #[test]
    fn loose_grains_are_followed_and_prove_a_collapse_where_they_cannot_be() {
        let mode = Mode::Equilibrium(Effort::Usual);
        for budget in [ALL, Budget { half: false, is_proved: true, ..ALL }] {
            assert_eq!(next(&mode, &Verdict::Loose, budget), Next::Follow);
        }
        let spent = Budget { motion: false, ..ALL };
        assert_eq!(next(&mode, &Verdict::Loose, spent), Next::Halve);
        let spent = Budget { motion: false, breaks: false, ..ALL };
        assert_eq!(next(&mode, &Verdict::Loose, spent), Next::End(IncrementStatus::Collapsed));
    }

    /// A hanging bridge of unbreakable bonds was "collapsed by proof" before it could sag.
    #[test]
    fn a_proved_mechanism_is_followed_once() {
        let mode = Mode::Equilibrium(Effort::Usual);
        let whole = Budget { half: false, searches: false, ..ALL };
        assert_eq!(next(&mode, &Verdict::Impossible, whole), Next::Follow);
        let followed = Budget { is_proved: true, ..whole };
        let collapsed = Next::End(IncrementStatus::Collapsed);
        assert_eq!(next(&mode, &Verdict::Impossible, followed), collapsed);
        let motion = Mode::Motion(Motion::default());
        assert_eq!(next(&motion, &Verdict::GivesWay(String::new()), followed), collapsed);
    }

    /// Sand turned by 0.185 rad at every fraction from 1 to 1/32.
    #[test]
    fn a_turn_that_shrinks_with_the_increment_is_halved_and_a_jump_is_followed() {
        let mode = Mode::Equilibrium(Effort::Usual);
        let far = Verdict::TooFar(String::new());
        assert_eq!(next(&mode, &far, Budget { shrinks: true, ..ALL }), Next::Halve);
        assert_eq!(next(&mode, &far, ALL), Next::Follow);
    }

    #[test]
    fn efforts_grow_and_end() {
        let all = Budget { motion: false, step: false, half: false, ..ALL };
        let mut effort = Effort::Usual;
        let mut seen = vec![effort];
        let verdict = Verdict::Unconverged(String::new());
        while let Next::Try(harder) = next(&Mode::Equilibrium(effort), &verdict, all) {
            assert!(harder > effort);
            effort = harder;
            seen.push(effort);
        }
        assert_eq!(seen, [Effort::Usual, Effort::Regularised]);
    }
}
