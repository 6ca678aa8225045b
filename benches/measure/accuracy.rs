//! Distance of a solution from a reference, in quantities that are unique.
//!
//! | error | measure | unique where |
//! |---|---|---|
//! | objective | difference over the sum of the magnitudes of its terms | always |
//! | forces | energy norm `sqrt(sum C_N dp^2 + C_T dq^2)` over that of the reference | forces have compliances |
//! | walls | maximum difference of the reactions to imposed motion over the maximum reaction | elastic; at a limit load |
//! | displacements | with inertia the kinetic norm `sqrt(sum m du^2)`; else the root mean square of the bodies that carry load on three interactions or more | bodies are held |
//!
//! Rolling moments have no compliance, and forces of rigid contacts are not unique: no measure
//! contains them. Other quantities are not assumed to be unique in a given program either: two
//! references from two solvers must agree on them.

use clastic::cone::program::{ConeProgram, ConeSolution, Dof};

/// Errors by measure; `None` where the program does not define it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Of the objective.
    pub objective: Option<f64>,
    /// Of the forces.
    pub forces: Option<f64>,
    /// Of the reactions.
    pub walls: Option<f64>,
    /// Of the displacements.
    pub displacements: Option<f64>,
}

impl Errors {
    /// The four errors.
    #[must_use]
    pub fn all(&self) -> [Option<f64>; 4] {
        [self.objective, self.forces, self.walls, self.displacements]
    }

    /// The errors without those on which the references differ by more than `maximum`, because
    /// these quantities are not unique.
    #[must_use]
    pub fn unique(&self, floor: &Self, maximum: f64) -> Self {
        let keep = |error: Option<f64>, floor: Option<f64>| {
            error.filter(|_| floor.is_some_and(|floor| floor <= maximum))
        };
        Self {
            objective: keep(self.objective, floor.objective),
            forces: keep(self.forces, floor.forces),
            walls: keep(self.walls, floor.walls),
            displacements: keep(self.displacements, floor.displacements),
        }
    }

    /// The maximum of the errors in forces, reactions and displacements that are defined.
    #[must_use]
    pub fn worst(&self) -> Option<f64> {
        [self.forces, self.walls, self.displacements].into_iter().flatten().reduce(f64::max)
    }
}

/// Errors of a solution of `program`; both must have a force for every interaction and a
/// displacement for every body.
#[must_use]
pub fn errors(program: &ConeProgram, solution: &ConeSolution, reference: &ConeSolution) -> Errors {
    let complete = |s: &ConeSolution| {
        s.forces.len() == program.interactions.len()
            && s.displacements.len() == program.bodies.len()
    };
    if !complete(solution) || !complete(reference) {
        return Errors::default();
    }
    Errors {
        objective: objective(program, solution, reference),
        forces: forces(program, solution, reference),
        walls: walls(program, solution, reference),
        displacements: displacements(program, solution, reference),
    }
}

/// `a / b`; `None` without a reference value.
fn ratio(a: f64, b: f64) -> Option<f64> {
    (b > 0.0 && a.is_finite()).then(|| a / b)
}

/// Terms of the objective: its sum and the sum of its magnitudes.
fn terms(program: &ConeProgram, solution: &ConeSolution) -> (f64, f64) {
    let fixed: Vec<[f64; 3]> = program
        .bodies
        .iter()
        .map(|b| b.dofs.map(|d| if let Dof::Fixed(u) = d { u } else { 0.0 }))
        .collect();
    let (mut sum, mut size) = (0.0, 0.0);
    let mut add = |term: f64| {
        sum += term;
        size += term.abs();
    };
    for (body, u) in program.bodies.iter().zip(&solution.displacements) {
        for (dof, u) in body.dofs.iter().zip(u) {
            if let Dof::Free(f) = dof {
                add(0.5 * f.inertia * u * u);
            }
        }
    }
    for (c, s) in program.interactions.iter().zip(&solution.forces) {
        let e = program.kinematics(c, &fixed);
        let slip = s[1] - c.previous_shear;
        add(c.offset * s[0]);
        add(0.5 * c.normal_compliance * s[0] * s[0]);
        add(0.5 * c.tangential_compliance * slip * slip);
        for (e, s) in e.iter().zip(s) {
            add(-e * s);
        }
    }
    (sum, size)
}

fn objective(program: &ConeProgram, s: &ConeSolution, reference: &ConeSolution) -> Option<f64> {
    let (value, _) = terms(program, s);
    let (expected, size) = terms(program, reference);
    ratio((value - expected).abs(), size)
}

fn forces(program: &ConeProgram, s: &ConeSolution, reference: &ConeSolution) -> Option<f64> {
    let (mut difference, mut whole) = (0.0, 0.0);
    for ((c, s), r) in program.interactions.iter().zip(&s.forces).zip(&reference.forces) {
        for (k, compliance) in [c.normal_compliance, c.tangential_compliance].iter().enumerate() {
            difference += compliance * (s[k] - r[k]).powi(2);
            whole += compliance * r[k] * r[k];
        }
    }
    ratio(difference.sqrt(), whole.sqrt())
}

/// Reactions along imposed motion; if nothing moves, of all held degrees of freedom.
fn walls(program: &ConeProgram, s: &ConeSolution, reference: &ConeSolution) -> Option<f64> {
    let reactions = |s: &ConeSolution| {
        let mut rows = vec![[0.0; 3]; program.bodies.len()];
        program.add_forces(&s.forces, &mut rows);
        rows
    };
    let (found, expected) = (reactions(s), reactions(reference));
    let moved = |d: &Dof| matches!(d, Dof::Fixed(u) if *u != 0.0);
    let any = program.bodies.iter().any(|b| b.dofs[..2].iter().any(moved));
    let (mut difference, mut whole) = (0.0_f64, 0.0_f64);
    for (i, body) in program.bodies.iter().enumerate() {
        for (k, dof) in body.dofs[..2].iter().enumerate() {
            if moved(dof) || (!any && matches!(dof, Dof::Fixed(_))) {
                difference = difference.max((found[i][k] - expected[i][k]).abs());
                whole = whole.max(expected[i][k].abs());
            }
        }
    }
    ratio(difference, whole)
}

fn displacements(program: &ConeProgram, s: &ConeSolution, reference: &ConeSolution) -> Option<f64> {
    let force = reference.forces.iter().map(|f| f[0].abs()).fold(0.0, f64::max);
    let mut holds = vec![0_u32; program.bodies.len()];
    for (c, f) in program.interactions.iter().zip(&reference.forces) {
        if f[0].abs() >= 1e-2 * force {
            holds[c.a as usize] += 1;
            holds[c.b as usize] += 1;
        }
    }
    let inertia = |d: &Dof| if let Dof::Free(f) = d { f.inertia } else { 0.0 };
    let dynamic = program.bodies.iter().flat_map(|b| &b.dofs).any(|d| inertia(d) > 0.0);
    let (mut difference, mut whole) = (0.0, 0.0);
    for (i, body) in program.bodies.iter().enumerate() {
        for (k, dof) in body.dofs.iter().enumerate() {
            let free = matches!(dof, Dof::Free(_));
            let weight = if dynamic {
                inertia(dof)
            } else {
                f64::from(u8::from(free && k < 2 && holds[i] >= 3))
            };
            let (found, expected) = (s.displacements[i][k], reference.displacements[i][k]);
            // Zero is not multiplied by a value that may not be finite.
            if weight > 0.0 {
                difference += weight * (found - expected).powi(2);
                whole += weight * expected * expected;
            }
        }
    }
    ratio(difference.sqrt(), whole.sqrt())
}

#[cfg(test)]
mod tests {
    use clastic::cone::program::{FreeDof, Interaction, ProgramBody};
    use glam::DVec2;

    use super::*;

    /// A disk on an elastic floor that is pushed up by 1 mm: p = 3 N.
    fn pushed() -> (ConeProgram, ConeSolution) {
        let body = |y| ProgramBody { axis: DVec2::X, dofs: [Dof::Fixed(0.0), y, Dof::Fixed(0.0)] };
        let load = FreeDof { load: -3.0, inertia: 2.0, ..Default::default() };
        let c = Interaction {
            normal: DVec2::NEG_Y,
            arm_a: 1.0,
            normal_compliance: 0.1,
            ..Interaction::between(0, 1)
        };
        let program = ConeProgram {
            bodies: vec![body(Dof::Free(load)), body(Dof::Fixed(1e-3))],
            interactions: vec![c],
            ..Default::default()
        };
        let solution = ConeSolution {
            forces: vec![[3.0, 0.0, 0.0]],
            displacements: vec![[0.0, 0.5, 0.0], [0.0, 1e-3, 0.0]],
            ..Default::default()
        };
        (program, solution)
    }

    #[test]
    fn errors_are_relative() {
        let (program, reference) = pushed();
        assert_eq!(errors(&program, &reference, &reference).worst(), Some(0.0));
        let mut other = reference.clone();
        other.forces[0][0] = 3.3;
        other.displacements[0][1] = 0.55;
        let e = errors(&program, &other, &reference);
        for error in [e.forces, e.walls, e.displacements] {
            assert!((error.unwrap_or_default() - 0.1).abs() < 1e-12, "{e:?}");
        }
        // 1/2 m u^2 = 0.25, 1/2 C p^2 = 0.45, -e p = -0.003; 0.3025, 0.5445, -0.0033.
        let change = (0.3025 + 0.5445 - 0.0033) - (0.25 + 0.45 - 0.003);
        let expected = change / (0.25 + 0.45 + 0.003);
        assert!((e.objective.unwrap_or_default() - expected).abs() < 1e-12, "{e:?}");
        let floor = Errors { forces: Some(1e-3), walls: Some(1e-9), ..Default::default() };
        let unique = e.unique(&floor, 1e-4);
        assert_eq!((unique.forces, unique.walls, unique.displacements), (None, e.walls, None));
    }
}
