//! Coulomb's law beside an independent solution of small programs: every combination of open,
//! sticking and sliding contacts is one linear system, and the combinations whose solution
//! satisfies all inequalities are all solutions of the program.

use clastic::cone::condensed::Condensed;
use clastic::cone::coulomb::{Coulomb, Goal};
use clastic::cone::program::{
    ConeProgram, ConeSolution, Dof, FreeDof, Interaction, Limits, ProgramBody, Scales, SolveStatus,
};
use clastic::cone::residuals::residuals;
use clastic::cone::solver::ConeSolver;
use glam::DVec2;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// State of a contact in a combination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum State {
    Open,
    Sticks,
    /// Slides in the direction of positive slip.
    Ahead,
    /// Slides in the direction of negative slip.
    Back,
}

const STATES: [State; 4] = [State::Open, State::Sticks, State::Ahead, State::Back];

/// Forces (p, q) by interaction and displacements by body in global axes, all in units of the
/// program's scales.
#[derive(Clone, Debug)]
pub struct Solution {
    pub states: Vec<State>,
    pub forces: Vec<[f64; 2]>,
    pub displacements: Vec<[f64; 3]>,
}

/// Accepted violation of an inequality, over the scales of the program.
const SIGN: f64 = 1e-9;

/// All solutions of a program under Coulomb's law. Interactions with strength are taken to hold.
/// `None` if a combination has a family of solutions, which no comparison could use.
pub fn solutions(program: &ConeProgram) -> Option<Vec<Solution>> {
    let contacts: Vec<usize> = (0..program.interactions.len())
        .filter(|k| !program.interactions[*k].limits.has_strength())
        .collect();
    let mut found: Vec<Solution> = Vec::new();
    for code in 0..4_usize.pow(contacts.len() as u32) {
        let mut states = vec![State::Sticks; program.interactions.len()];
        let mut rest = code;
        for k in &contacts {
            states[*k] = STATES[rest % 4];
            rest /= 4;
        }
        let System { mut matrix, mut right, free } = system(program, &states);
        let Some(x) = solve(&mut matrix, &mut right) else {
            // A singular combination matters only if it has solutions.
            if is_consistent(&matrix, &right) {
                return None;
            }
            continue;
        };
        let mut displacements = vec![[0.0; 3]; program.bodies.len()];
        for (place, (body, k)) in free.iter().enumerate() {
            displacements[*body][*k] = x[place];
        }
        let forces: Vec<[f64; 2]> =
            (0..states.len()).map(|c| [x[free.len() + 2 * c], x[free.len() + 2 * c + 1]]).collect();
        let solution = Solution { states, forces, displacements };
        if contacts.iter().all(|k| is_admissible(program, *k, &solution))
            && !found.iter().any(|other| is_near(other, &solution))
        {
            found.push(solution);
        }
    }
    Some(found)
}

/// Closing and slip of an interaction.
fn kinematics(c: &Interaction, u: &[[f64; 3]]) -> [f64; 2] {
    let (a, b) = (u[c.a as usize], u[c.b as usize]);
    let along = |d: DVec2| d.x * (a[0] - b[0]) + d.y * (a[1] - b[1]);
    let tangent = DVec2::new(-c.normal.y, c.normal.x);
    [along(c.normal), along(tangent) + c.arm_a * a[2] + c.arm_b * b[2]]
}

fn is_admissible(program: &ConeProgram, k: usize, solution: &Solution) -> bool {
    let c = &program.interactions[k];
    let ([p, q], [closing, slip]) = (solution.forces[k], kinematics(c, &solution.displacements));
    let sliding = slip - c.tangential_compliance * (q - c.previous_shear);
    match solution.states[k] {
        State::Open => c.offset - closing >= -SIGN,
        State::Sticks => p >= -SIGN && q.abs() <= c.limits.friction * p + SIGN,
        State::Ahead => p >= -SIGN && sliding >= -SIGN,
        State::Back => p >= -SIGN && sliding <= SIGN,
    }
}

fn is_near(a: &Solution, b: &Solution) -> bool {
    let far = |x: &[f64], y: &[f64]| x.iter().zip(y).any(|(x, y)| (x - y).abs() > 1e-7);
    !far(a.forces.as_flattened(), b.forces.as_flattened())
        && !far(a.displacements.as_flattened(), b.displacements.as_flattened())
}

/// The linear system of a combination: the balance of every free degree of freedom, then two
/// conditions for every interaction. Unknowns are the displacements, then (p, q).
struct System {
    matrix: Vec<Vec<f64>>,
    right: Vec<f64>,
    free: Vec<(usize, usize)>,
}

fn system(program: &ConeProgram, states: &[State]) -> System {
    let free: Vec<(usize, usize)> = (0..program.bodies.len())
        .flat_map(|i| (0..3).map(move |k| (i, k)))
        .filter(|(i, k)| matches!(program.bodies[*i].dofs[*k], Dof::Free(_)))
        .collect();
    let size = free.len() + 2 * states.len();
    let mut matrix = vec![vec![0.0; size]; size];
    let mut right = vec![0.0; size];
    for (row, (body, k)) in free.iter().enumerate() {
        let Dof::Free(dof) = program.bodies[*body].dofs[*k] else { unreachable!() };
        matrix[row][row] = dof.inertia;
        right[row] = dof.load;
    }
    for (c, interaction) in program.interactions.iter().enumerate() {
        let (first, second) = (free.len() + 2 * c, free.len() + 2 * c + 1);
        // Derivatives of closing and slip by every free displacement; also the force on it.
        let mut unit = vec![[0.0; 3]; program.bodies.len()];
        let mut derivatives = Vec::new();
        for (place, (body, k)) in free.iter().enumerate() {
            unit[*body][*k] = 1.0;
            let d = kinematics(interaction, &unit);
            unit[*body][*k] = 0.0;
            matrix[place][first] += d[0];
            matrix[place][second] += d[1];
            derivatives.push(d);
        }
        let closed = states[c] != State::Open;
        let sticks = states[c] == State::Sticks;
        if closed {
            // offset - closing + C_N p = 0
            derivatives.iter().enumerate().for_each(|(i, d)| matrix[first][i] = -d[0]);
            matrix[first][first] = interaction.normal_compliance;
            right[first] = -interaction.offset;
        } else {
            matrix[first][first] = 1.0;
        }
        if sticks {
            // slip - C_T (q - q_0) = 0
            derivatives.iter().enumerate().for_each(|(i, d)| matrix[second][i] = d[1]);
            matrix[second][second] = -interaction.tangential_compliance;
            right[second] = -interaction.tangential_compliance * interaction.previous_shear;
        } else {
            let friction = interaction.limits.friction;
            matrix[second][second] = 1.0;
            matrix[second][first] = match states[c] {
                State::Ahead => -friction,
                State::Back => friction,
                _ => 0.0,
            };
        }
    }
    System { matrix, right, free }
}

/// Gaussian elimination with complete pivoting; `None` if the matrix is singular, which leaves the
/// reduced system in place.
pub fn solve(matrix: &mut [Vec<f64>], right: &mut [f64]) -> Option<Vec<f64>> {
    let n = right.len();
    let mut columns: Vec<usize> = (0..n).collect();
    for k in 0..n {
        let at = |i: usize, j: usize, m: &[Vec<f64>]| m[i][j].abs();
        let (mut row, mut column) = (k, k);
        for i in k..n {
            for j in k..n {
                if at(i, j, matrix) > at(row, column, matrix) {
                    (row, column) = (i, j);
                }
            }
        }
        if at(row, column, matrix) < 1e-10 {
            return None;
        }
        matrix.swap(k, row);
        right.swap(k, row);
        columns.swap(k, column);
        matrix.iter_mut().for_each(|r| r.swap(k, column));
        for i in k + 1..n {
            let factor = matrix[i][k] / matrix[k][k];
            if factor != 0.0 {
                for j in k..n {
                    matrix[i][j] -= factor * matrix[k][j];
                }
                right[i] -= factor * right[k];
            }
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let sum: f64 = (k + 1..n).map(|j| matrix[k][j] * x[columns[j]]).sum();
        x[columns[k]] = (right[k] - sum) / matrix[k][k];
    }
    Some(x)
}

/// Whether a reduced singular system has solutions: its empty rows have no right side.
fn is_consistent(matrix: &[Vec<f64>], right: &[f64]) -> bool {
    matrix
        .iter()
        .zip(right)
        .all(|(row, right)| row.iter().any(|x| x.abs() >= 1e-10) || right.abs() < SIGN)
}

/// Residual to which the engine sweeps before the solver of Coulomb's law.
pub const SWEPT: f64 = 0.9e-8;

/// A residual from which the solver still has all the work to do.
const LOOSE: f64 = 1e-2;

/// The solver from sweeps to a residual where grains slide in a time step, else from the associated
/// solution.
pub fn coulomb(program: &ConeProgram, swept: f64) -> Option<ConeSolution> {
    let associated = || {
        let start = Condensed::default().solve(program, 0.0).ok()?;
        (start.status == SolveStatus::Solved).then_some(start)
    };
    let start = Coulomb::sweep(program, &[], swept).or_else(associated)?;
    let goal = Goal { tolerance: 0.9e-8, at_once: false };
    let found = Coulomb::default().solve(program, &start, goal, 500);
    (found.status == SolveStatus::Solved).then_some(found)
}

/// Where the first point within the tolerance suffices, fewer factorisations lead from sweeps to a
/// solution: here nine tenths of what a sharp solution takes, or fewer.
#[test]
fn the_first_point_within_the_tolerance_takes_fewer_factorisations() {
    let (mut at_once, mut sharp) = (0, 0);
    for seed in 0..60 {
        let program = random(seed, true);
        let Some(start) = Coulomb::sweep(&program, &[], LOOSE) else { continue };
        let solve = |at_once| {
            let goal = Goal { tolerance: 0.9e-8, at_once };
            Coulomb::default().solve(&program, &start, goal, 500)
        };
        let [first, last] = [true, false].map(solve);
        assert_eq!(first.status, last.status, "seed {seed}");
        if first.status == SolveStatus::Solved {
            let r = residuals(&program, &first).worst();
            assert!(r <= 1e-8, "seed {seed}: {r:e}");
            at_once += first.iterations;
            sharp += last.iterations;
        }
    }
    assert!(at_once > 0 && 10 * at_once <= 9 * sharp, "{at_once} and {sharp}");
}

/// Sweeps of Coulomb's law alone solve most time steps of few disks, and say so truly.
#[test]
fn sweeps_alone_solve_time_steps_of_few_disks() {
    let (mut solved, mut all) = (0, 0);
    for tolerance in [1e-3, 1e-8] {
        for seed in 0..60 {
            let program = random(seed, true);
            let Some(found) = Coulomb::sweep(&program, &[], tolerance) else { continue };
            all += 1;
            if found.status == SolveStatus::Solved {
                solved += 1;
                let r = residuals(&program, &found).worst();
                assert!(r <= tolerance, "seed {seed}: {r:e}");
            }
        }
    }
    println!("{solved} of {all} programs are solved by sweeps alone");
    assert!(2 * solved > all, "{solved} of {all}");
}

/// Random numbers of one program.
pub struct Random(pub ChaCha8Rng);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0.next_u32() as f64 / u32::MAX as f64
    }

    pub fn between(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * self.unit()
    }

    pub fn below(&mut self, n: usize) -> usize {
        self.0.next_u32() as usize % n
    }
}

fn body(free: bool, dofs: impl Fn(usize) -> FreeDof) -> ProgramBody {
    let dof = |k| if free { Dof::Free(dofs(k)) } else { Dof::Fixed(0.0) };
    ProgramBody { axis: DVec2::X, dofs: [0, 1, 2].map(dof) }
}

/// A program of two to four disks of radius 1 between fixed bodies, with up to six contacts in
/// random directions. Rigid contacts come with inertia, elastic ones with or without.
pub fn random(seed: u64, dynamic: bool) -> ConeProgram {
    let r = &mut Random(ChaCha8Rng::seed_from_u64(seed));
    let disks = 2 + r.below(3);
    let contacts = disks + 1 + r.below(6 - disks);
    random_of(r, disks, contacts, dynamic)
}

/// The same with any number of disks and contacts.
pub fn random_of(r: &mut Random, disks: usize, contacts: usize, dynamic: bool) -> ConeProgram {
    let rigid = dynamic && r.unit() < 0.5;
    let friction = [0.2, 0.5, 0.9, 1.5][r.below(4)];
    let mut bodies: Vec<ProgramBody> = Vec::new();
    for _ in 0..disks {
        let load = if dynamic {
            [r.between(-1.0, 1.0), r.between(-1.0, 1.0), r.between(-0.2, 0.2)]
        } else {
            [r.between(-0.5, 0.5), r.between(-1.0, 0.0), r.between(-0.2, 0.2)]
        };
        let inertia = if dynamic { r.between(0.3, 3.0) } else { 0.0 };
        bodies.push(body(true, |k| FreeDof {
            load: load[k],
            momentum: if dynamic { 0.8 * load[k] } else { 0.0 },
            inertia: inertia * [1.0, 1.0, 0.5][k],
            ..FreeDof::default()
        }));
    }
    bodies.push(body(false, |_| FreeDof::default()));
    let fixed = disks as u32;
    let mut interactions = Vec::new();
    for k in 0..contacts {
        // The first contacts tie the disks into a chain that begins at the fixed body.
        let a = (k % disks) as u32;
        let b = match k {
            0 => fixed,
            k if k < disks => k as u32 - 1,
            _ if r.unit() < 0.6 => fixed,
            _ => (a + 1 + r.below(disks - 1) as u32) % fixed,
        };
        // Without inertia disks rest on what is below them.
        let angle = if dynamic {
            r.between(0.0, std::f64::consts::TAU)
        } else {
            r.between(-std::f64::consts::PI, 0.0)
        };
        let compliance = if rigid { 0.0 } else { r.between(0.5, 2.0) };
        interactions.push(Interaction {
            normal: DVec2::new(angle.cos(), angle.sin()),
            arm_a: 1.0,
            arm_b: if b == fixed { 0.0 } else { 1.0 },
            offset: if rigid { r.between(0.0, 0.1) } else { r.between(-0.3, 0.5) },
            normal_compliance: compliance,
            tangential_compliance: compliance * r.between(1.0, 3.0),
            previous_shear: if rigid { 0.0 } else { r.between(-0.1, 0.1) },
            limits: Limits::new(0.0, friction, 0.0, 0.0),
            ..Interaction::between(a, b)
        });
    }
    let scales = Scales { length: 1.0, displacement: 1.0, force: 1.0 };
    ConeProgram { bodies, interactions, scales, ..ConeProgram::default() }
}

/// Distance of a solution of the solver from the nearest one of the enumeration.
fn distance(found: &ConeSolution, all: &[Solution]) -> f64 {
    let of = |s: &Solution| {
        let forces = s.forces.iter().zip(&found.forces);
        let forces = forces.flat_map(|(x, y)| [x[0] - y[0], x[1] - y[1]]);
        let u = s.displacements.as_flattened().iter();
        let u = u.zip(found.displacements.as_flattened()).map(|(x, y)| x - y);
        forces.chain(u).map(f64::abs).fold(0.0, f64::max)
    };
    all.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// Programs by their number of solutions, and how the solver ended.
#[derive(Default, Debug)]
struct Count {
    /// Programs without a solution, with one, with several.
    programs: [usize; 3],
    /// Of these, programs that the solver solved.
    solved: [usize; 3],
    /// Maximum distance of a solution of the solver from the nearest one of the enumeration.
    far: f64,
}

fn count(seeds: std::ops::Range<u64>, dynamic: bool, swept: f64) -> Count {
    let mut count = Count::default();
    for seed in seeds {
        let program = random(seed, dynamic);
        let Some(all) = solutions(&program) else { continue };
        let kind = all.len().min(2);
        count.programs[kind] += 1;
        match coulomb(&program, swept) {
            Some(found) => {
                count.solved[kind] += 1;
                let distance = distance(&found, &all);
                assert!(distance < 1e-6, "seed {seed}: {distance:e} off, {} solutions", all.len());
                count.far = count.far.max(distance);
            }
            None if kind > 0 => println!("seed {seed}: not found, {} solutions", all.len()),
            None => {}
        }
    }
    println!("{count:?}");
    count
}

/// Time steps: a solution always exists, and with several the solver finds one of them.
#[test]
fn time_steps_of_few_disks_have_the_enumerated_solution() {
    for swept in [SWEPT, LOOSE] {
        let count = count(0..400, true, swept);
        assert_eq!(count.programs[0], 0);
        let all: usize = count.programs.iter().sum();
        assert!(all >= 390, "{all} programs compared");
        let solved: usize = count.solved.iter().sum();
        assert!(solved >= all - 1, "{solved} of {all} solved");
    }
}

/// Static programs: no solution is found where the enumeration finds none.
#[test]
fn equilibria_of_few_disks_have_the_enumerated_solution() {
    let count = count(0..400, false, SWEPT);
    assert_eq!(count.solved[0], 0);
    assert!(count.programs[1] >= 40, "{count:?}");
    assert_eq!(count.solved[1..], count.programs[1..]);
}

/// A particle that is held by an inclined elastic bond and pressed against a wall. With normal and
/// tangential stiffness of the bond k_n and k_t and angle a of its normal to the wall's normal, the
/// stiffness has the coupling `K_nt = (k_n - k_t) sin a cos a` and the tangential part
/// `K_tt = k_n sin^2 a + k_t cos^2 a`. Sliding under `F_t = mu F_n - d` has the displacement
/// `d/(mu K_nt - K_tt)` (Klarbring 1990): with `mu > K_tt/K_nt` sticking, sliding and separation are
/// equilibria of the same load; below it the solution is unique.
fn klarbring(friction: f64, load: [f64; 2]) -> ConeProgram {
    let (sin, cos) = (0.5_f64.sqrt(), 0.5_f64.sqrt());
    let dof = |load| Dof::Free(FreeDof { load, ..FreeDof::default() });
    let particle =
        ProgramBody { axis: DVec2::X, dofs: [dof(load[0]), dof(load[1]), Dof::Fixed(0.0)] };
    let fixed = ProgramBody { axis: DVec2::X, dofs: [Dof::Fixed(0.0); 3] };
    // The wall is at the right: its normal is x, and the tangent y.
    let wall =
        Interaction { limits: Limits::new(0.0, friction, 0.0, 0.0), ..Interaction::between(0, 1) };
    let bond = Interaction {
        normal: DVec2::new(cos, sin),
        normal_compliance: 1.0 / 3.0,
        tangential_compliance: 1.0,
        limits: Limits::new(1e3, 0.0, 1e3, 0.0),
        ..Interaction::between(0, 2)
    };
    ConeProgram {
        bodies: vec![particle, fixed, fixed],
        interactions: vec![wall, bond],
        ..ConeProgram::default()
    }
}

/// k_n = 3, k_t = 1 and a = 45 degrees: K_tt = K_nn = 2, K_nt = 1, so that the limit is mu = 2.
#[test]
fn the_solutions_of_an_elastically_held_particle_are_those_of_klarbring() {
    for (friction, expected) in [(1.5, 1), (3.0, 3)] {
        let program = klarbring(friction, [1.0, friction - 0.5]);
        let all = solutions(&program).unwrap();
        let states: Vec<State> = all.iter().map(|s| s.states[0]).collect();
        assert_eq!(all.len(), expected, "mu = {friction}: {states:?}");
        let sticks = all.iter().find(|s| s.states[0] == State::Sticks).unwrap();
        assert!((sticks.forces[0][0] - 1.0).abs() < 1e-12);
        let slid = all.iter().find(|s| matches!(s.states[0], State::Ahead | State::Back));
        if let Some(slid) = slid {
            let slip = 0.5 / (friction * 1.0 - 2.0);
            assert!((slid.displacements[0][1].abs() - slip.abs()).abs() < 1e-12, "{slid:?}");
        }
        let found = coulomb(&program, SWEPT).unwrap();
        assert!(distance(&found, &all) < 1e-8, "mu = {friction}");
        // The start is fixed: runs repeat.
        let again = coulomb(&program, SWEPT).unwrap();
        assert_eq!(found.forces, again.forces);
    }
}
