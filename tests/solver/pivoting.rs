//! Coulomb's law beside a pivoting method: a program is a linear complementarity problem, which
//! Lemke's method solves on a path of bases, without barrier, starting point or tolerance.
//!
//! With inertia the problem is that of Stewart and Trinkle (1996), in the variables p, beta_+,
//! beta_- (parts of the shear force) and lambda (the speed of sliding):
//!
//! ```text
//! p      >= 0   gap                      >= 0
//! beta_+ >= 0   lambda - s_t             >= 0        q = beta_+ - beta_-
//! beta_- >= 0   lambda + s_t             >= 0
//! lambda >= 0   mu p - beta_+ - beta_-   >= 0
//! ```
//!
//! Its matrix is copositive, so that Lemke's method ends at a solution (Anitescu and Potra 1997).
//! Without inertia, with springs, it is that of Klarbring (1986): gaps and the two directions of
//! slip are the variables, and the forces follow from the springs.

use clastic::cone::program::{ConeProgram, Dof, Interaction, SlidingLaw};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::common::programs::{Kind, increments};
use crate::enumeration::{Random, SWEPT, coulomb, random, random_of, solutions, solve};
use crate::lemke;

/// A linear complementarity problem before elimination: equations, and the columns of their
/// variables. Lengths, displacements and forces are over the scales of the program.
#[derive(Default)]
struct Problem {
    rows: Vec<Vec<f64>>,
    right: Vec<f64>,
    /// Columns of the free variables.
    free: Vec<usize>,
    /// Columns of w and of z.
    pairs: Vec<[usize; 2]>,
    columns: usize,
    /// Columns of p, and with their signs those whose sum is q, by contact.
    forces: Vec<(usize, Vec<(usize, f64)>)>,
    /// Body and degree of freedom by free displacement.
    dofs: Vec<(usize, usize)>,
}

impl Problem {
    fn column(&mut self) -> usize {
        self.columns += 1;
        self.columns - 1
    }

    fn equation(&mut self, terms: Vec<(usize, f64)>, right: f64) {
        let mut row = vec![0.0; 512];
        for (column, factor) in terms {
            row[column] += factor;
        }
        self.rows.push(row);
        self.right.push(right);
    }
}

/// Derivatives of closing and slip by the displacements of a body, over the scales.
fn derivatives(program: &ConeProgram, c: &Interaction, body: usize) -> [[f64; 3]; 2] {
    let sign = if body == c.a as usize { 1.0 } else { -1.0 };
    let arm = if body == c.a as usize { c.arm_a } else { c.arm_b };
    let axis = program.bodies[body].axis;
    let (n, t) = (c.normal, glam::DVec2::new(-c.normal.y, c.normal.x));
    let across = glam::DVec2::new(-axis.y, axis.x);
    let of = |v: glam::DVec2| [sign * v.dot(axis), sign * v.dot(across)];
    let ([nx, ny], [tx, ty]) = (of(n), of(t));
    [[nx, ny, 0.0], [tx, ty, arm / program.scales.length]]
}

/// Closing and slip by displacements over the scales.
fn kinematics(program: &ConeProgram, c: &Interaction, u: &[[f64; 3]]) -> [f64; 2] {
    [0, 1].map(|row| {
        let of = |body: u32| {
            let d = derivatives(program, c, body as usize)[row];
            (0..3).map(|k| d[k] * u[body as usize][k]).sum::<f64>()
        };
        of(c.a) + of(c.b)
    })
}

/// Imposed displacements over the scales.
fn imposed(program: &ConeProgram) -> Vec<[f64; 3]> {
    let s = &program.scales;
    let of = |dof: &Dof, k: usize| match dof {
        Dof::Fixed(u) => u / s.displacement * if k == 2 { s.length } else { 1.0 },
        Dof::Free(_) => 0.0,
    };
    let bodies = program.bodies.iter();
    bodies.map(|b| [of(&b.dofs[0], 0), of(&b.dofs[1], 1), of(&b.dofs[2], 2)]).collect()
}

/// The problem of a program of contacts. `None` for a law that it does not have: strength, rolling
/// resistance, or a periodic cell.
fn problem(program: &ConeProgram) -> Option<Problem> {
    let plain = |c: &Interaction| {
        let l = &c.limits;
        !(l.has_strength() || l.has_rolling() || c.is_across())
            && c.normal_arm_a == 0.0
            && c.normal_arm_b == 0.0
    };
    if program.cell.is_some() || !program.interactions.iter().all(plain) {
        return None;
    }
    let s = program.scales;
    let (unit, fixed) = (s.displacement / s.force, imposed(program));
    let mut out = Problem::default();
    let mut place = vec![[None; 3]; program.bodies.len()];
    let mut balance = Vec::new();
    let mut with_inertia = true;
    for (i, body) in program.bodies.iter().enumerate() {
        for k in 0..3 {
            if let Dof::Free(dof) = body.dofs[k] {
                let column = out.column();
                place[i][k] = Some(column);
                out.dofs.push((i, k));
                out.free.push(column);
                let (moment, turn) = if k == 2 { (s.length, s.length) } else { (1.0, 1.0) };
                let inertia = (dof.inertia + dof.proximal) * unit / (moment * turn);
                let load = (dof.load + dof.proximal * dof.reference) / (s.force * moment);
                balance.push((vec![(column, inertia)], load));
                with_inertia &= dof.inertia > 0.0;
            }
        }
    }
    for c in &program.interactions {
        let along = |row: usize, sign: f64| -> Vec<(usize, f64)> {
            let of = |body: u32| {
                let d = derivatives(program, c, body as usize)[row];
                let columns = place[body as usize];
                (0..3).filter_map(move |k| columns[k].map(|column| (column, sign * d[k])))
            };
            of(c.a).chain(of(c.b)).collect()
        };
        let [closed, slipped] = kinematics(program, c, &fixed);
        let [c_n, c_t] = [c.normal_compliance / unit, c.tangential_compliance / unit];
        let (gap, q_0) = (c.offset / s.displacement - closed, c.previous_shear / s.force);
        let mu = c.limits.friction;
        let (p, gap_left) = (out.column(), out.column());
        let shear = if with_inertia {
            let [plus, minus, speed] = [0; 3].map(|_| out.column());
            let [slow_plus, slow_minus, left] = [0; 3].map(|_| out.column());
            out.pairs.extend([[gap_left, p], [slow_plus, plus]]);
            out.pairs.extend([[slow_minus, minus], [left, speed]]);
            for (slow, sign) in [(slow_plus, 1.0), (slow_minus, -1.0)] {
                // lambda - sign s_t = slow,   s_t = d_t - C_T (q - q_0)
                let mut terms = along(1, sign);
                terms.extend([(slow, 1.0), (speed, -1.0)]);
                terms.extend([(plus, -sign * c_t), (minus, sign * c_t)]);
                out.equation(terms, -sign * (slipped + c_t * q_0));
            }
            out.equation(vec![(left, 1.0), (p, -mu), (plus, 1.0), (minus, 1.0)], 0.0);
            vec![(plus, 1.0), (minus, -1.0)]
        } else {
            let q = out.column();
            out.free.push(q);
            let [slip_plus, slip_minus] = [0; 2].map(|_| out.column());
            let [left_plus, left_minus] = [0; 2].map(|_| out.column());
            out.pairs.extend([[p, gap_left], [left_plus, slip_plus], [left_minus, slip_minus]]);
            let mut terms = along(1, 1.0);
            terms.extend([(q, -c_t), (slip_plus, -1.0), (slip_minus, 1.0)]);
            out.equation(terms, -slipped - c_t * q_0);
            out.equation(vec![(left_plus, 1.0), (q, 1.0), (p, -mu)], 0.0);
            out.equation(vec![(left_minus, 1.0), (q, -1.0), (p, -mu)], 0.0);
            vec![(q, 1.0)]
        };
        let mut terms = along(0, 1.0);
        terms.extend([(gap_left, 1.0), (p, -c_n)]);
        out.equation(terms, gap);
        for (row, (terms, _)) in balance.iter_mut().enumerate() {
            let (body, k) = out.dofs[row];
            if [c.a, c.b].contains(&(body as u32)) {
                let [n, t] = derivatives(program, c, body);
                terms.push((p, n[k]));
                terms.extend(shear.iter().map(|(column, sign)| (*column, sign * t[k])));
            }
        }
        out.forces.push((p, shear));
    }
    balance.into_iter().for_each(|(terms, right)| out.equation(terms, right));
    let columns = out.columns;
    out.rows.iter_mut().for_each(|row| {
        assert!(columns <= row.len());
        row.truncate(columns);
    });
    Some(out)
}

/// M and b of w = M z + b, with the free variables eliminated. `None` if the free variables and w
/// do not follow from z.
fn reduce(problem: &Problem) -> Option<(Vec<Vec<f64>>, Vec<f64>)> {
    let mut rows = problem.rows.clone();
    rows.iter_mut().zip(&problem.right).for_each(|(row, right)| row.push(*right));
    let mut at = vec![None; problem.columns];
    let mut open: Vec<usize> = (0..rows.len()).collect();
    let start = problem.free.iter().copied().chain(problem.pairs.iter().map(|pair| pair[0]));
    for column in start {
        let (k, row) = open
            .iter()
            .copied()
            .enumerate()
            .max_by(|a, b| rows[a.1][column].abs().total_cmp(&rows[b.1][column].abs()))?;
        let by = rows[row][column];
        if by.abs() < 1e-12 {
            return None;
        }
        open.swap_remove(k);
        at[column] = Some(row);
        rows[row].iter_mut().for_each(|x| *x /= by);
        let pivotal = rows[row].clone();
        for (i, other) in rows.iter_mut().enumerate() {
            let factor = other[column];
            if i != row && factor != 0.0 {
                other.iter_mut().zip(&pivotal).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
    let of_w = || problem.pairs.iter().map(|pair| &rows[at[pair[0]].unwrap()]);
    let matrix = of_w().map(|row| problem.pairs.iter().map(|pair| -row[pair[1]]).collect());
    Some((matrix.collect(), of_w().map(|row| *row.last().unwrap()).collect()))
}

/// Forces (p, q) by contact and displacements by body, over the scales of the program.
struct Found {
    forces: Vec<[f64; 2]>,
    displacements: Vec<[f64; 3]>,
}

/// The solution of Lemke's method with a covering vector. `None` if it ends on a ray.
fn pivoted(program: &ConeProgram, problem: &Problem, cover: &[f64]) -> Option<Found> {
    let (matrix, b) = reduce(problem)?;
    let basis = lemke::basis(&matrix, &b, &cover[..b.len()], 5000)?;
    // The equations once more, in the variables of the last basis.
    let m = b.len();
    let of_pairs = basis.iter().map(|k| problem.pairs[k % m][k / m]);
    let used: Vec<usize> = problem.free.iter().copied().chain(of_pairs).collect();
    let mut square: Vec<Vec<f64>> =
        problem.rows.iter().map(|row| used.iter().map(|k| row[*k]).collect()).collect();
    let values = solve(&mut square, &mut problem.right.clone())?;
    let mut x = vec![0.0; problem.columns];
    used.iter().zip(values).for_each(|(column, value)| x[*column] = value);
    let mut displacements = imposed(program);
    for ((body, k), column) in problem.dofs.iter().zip(&problem.free) {
        displacements[*body][*k] = x[*column];
    }
    let forces = problem.forces.iter();
    let forces = forces
        .map(|(p, q)| [x[*p], q.iter().map(|(column, sign)| sign * x[*column]).sum()])
        .collect();
    Some(Found { forces, displacements })
}

/// Maximum error of the balance and of the natural map of Coulomb's law, over the maximum force and
/// displacement.
fn error(program: &ConeProgram, found: &Found) -> f64 {
    let s = &program.scales;
    let unit = s.displacement / s.force;
    let force = found.forces.as_flattened().iter().fold(1e-6, |a: f64, x| a.max(x.abs()));
    let length = found.displacements.as_flattened().iter().fold(1e-6, |a: f64, x| a.max(x.abs()));
    let mut rows = vec![[0.0; 3]; program.bodies.len()];
    let mut worst = 0.0_f64;
    for (c, [p, q]) in program.interactions.iter().zip(&found.forces) {
        for body in [c.a as usize, c.b as usize] {
            let [n, t] = derivatives(program, c, body);
            (0..3).for_each(|k| rows[body][k] += p * n[k] + q * t[k]);
        }
        let [closing, slip] = kinematics(program, c, &found.displacements);
        let gap = (c.offset / s.displacement + c.normal_compliance / unit * p - closing) / length;
        let sliding =
            (slip - c.tangential_compliance / unit * (q - c.previous_shear / s.force)) / length;
        let (p, q) = (p / force, q / force);
        let limit = c.limits.friction * p.max(0.0);
        worst = worst.max(p.min(gap).abs());
        worst = worst.max((q - (q + sliding).clamp(-limit, limit)).abs());
    }
    for (i, body) in program.bodies.iter().enumerate() {
        for k in 0..3 {
            if let Dof::Free(dof) = body.dofs[k] {
                let l = if k == 2 { s.length } else { 1.0 };
                let u = found.displacements[i][k];
                let inertia = (dof.inertia + dof.proximal) * unit / (l * l);
                let load = (dof.load + dof.proximal * dof.reference) / (s.force * l);
                worst = worst.max((inertia * u + rows[i][k] - load).abs() / force);
            }
        }
    }
    worst
}

/// Maximum difference of the motions over the maximum motion, and of the forces over the maximum
/// force.
fn difference(a: &Found, b: &Found) -> [f64; 2] {
    let of = |a: &[f64], b: &[f64]| {
        let largest = a.iter().fold(1e-12_f64, |m, x| m.max(x.abs()));
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
    };
    [
        of(a.displacements.as_flattened(), b.displacements.as_flattened()),
        of(a.forces.as_flattened(), b.forces.as_flattened()),
    ]
}

/// The solution of the engine, over the scales of the program.
fn of_engine(program: &ConeProgram) -> Option<Found> {
    let s = &program.scales;
    let found = coulomb(program, SWEPT)?;
    let forces = found.forces.iter().map(|f| [f[0] / s.force, f[1] / s.force]).collect();
    let u = found.displacements.iter();
    let u = u.map(|u| [u[0], u[1], u[2] * s.length].map(|u| u / s.displacement)).collect();
    Some(Found { forces, displacements: u })
}

/// Number of covering vectors, and of those where none of their paths ends at the engine's motion.
const COVERS: usize = 5;
const MORE_COVERS: usize = 400;

/// Maximum error of an answer of Lemke's method.
const ANSWER: f64 = 1e-11;

/// Solutions of Lemke's method for covering vectors of ones and of random numbers.
fn all_pivoted(program: &ConeProgram, covers: usize) -> Option<Vec<Found>> {
    let problem = problem(program)?;
    let r = &mut Random(ChaCha8Rng::seed_from_u64(1));
    let of = |k: usize, r: &mut Random| match k {
        0 => 1.0,
        1..COVERS => r.between(0.2, 2.0),
        _ => 10_f64.powf(r.between(-2.0, 2.0)),
    };
    let cover = |k: usize, r: &mut Random| -> Vec<f64> {
        (0..problem.pairs.len()).map(|_| of(k, r)).collect()
    };
    let covers: Vec<Vec<f64>> = (0..covers).map(|k| cover(k, r)).collect();
    let found = covers.iter().filter_map(|cover| pivoted(program, &problem, cover));
    // Pivots of very different size may end at a wrong basis: an answer must fulfil the law.
    Some(found.filter(|found| error(program, found) < ANSWER).collect())
}

/// Lemke's method finds what the enumeration of all combinations finds.
#[test]
fn pivots_end_at_enumerated_solutions() {
    for dynamic in [true, false] {
        let (mut compared, mut missed) = (0, 0);
        for seed in 0..200 {
            let program = random(seed, dynamic);
            let Some(all) = solutions(&program) else { continue };
            let found = all_pivoted(&program, COVERS).unwrap();
            assert!(!all.is_empty() || found.is_empty(), "seed {seed}");
            missed += usize::from(!all.is_empty() && found.is_empty());
            for found in &found {
                let far = |s: &crate::enumeration::Solution| {
                    let s =
                        Found { forces: s.forces.clone(), displacements: s.displacements.clone() };
                    let [u, f] = difference(&s, found);
                    u.max(f)
                };
                let nearest = all.iter().map(far).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-7, "seed {seed}, dynamic {dynamic}: {nearest:e}");
            }
            compared += usize::from(!found.is_empty());
        }
        println!("dynamic {dynamic}: {compared} compared, {missed} missed");
    }
}

/// Result of a comparison of some programs.
#[derive(Debug, Default)]
struct Count {
    programs: usize,
    /// Solved by Lemke's method, by the engine, by both.
    solved: [usize; 3],
    /// Of those solved by both: the motions of all covering vectors agree, so that the solution
    /// seems unique.
    unique: usize,
    /// Of these: maximum difference of the motions, and errors of pivoting and engine.
    apart: f64,
    errors: [f64; 2],
    /// Contacts of the largest program.
    contacts: usize,
    /// Programs in which both have a solution, and none of Lemke's is that of the engine.
    other: usize,
}

fn compare(programs: impl Iterator<Item = (String, ConeProgram)>) -> Count {
    let mut count = Count::default();
    for (name, program) in programs {
        let Some(mut all) = all_pivoted(&program, COVERS) else { continue };
        let engine = of_engine(&program);
        let has = |all: &[Found], engine: &Found| {
            all.iter().any(|found| difference(found, engine)[0] <= 1e-5)
        };
        if let Some(engine) = engine.as_ref().filter(|engine| !all.is_empty() && !has(&all, engine))
        {
            println!("{name}: error of the engine {:.1e}", error(&program, engine));
            all = all_pivoted(&program, MORE_COVERS).unwrap_or_default();
        }
        count.programs += 1;
        count.contacts = count.contacts.max(program.interactions.len());
        count.solved[0] += usize::from(!all.is_empty());
        count.solved[1] += usize::from(engine.is_some());
        let errors = all.iter().map(|found| error(&program, found)).fold(0.0, f64::max);
        count.errors[0] = count.errors[0].max(errors);
        let Some(engine) = engine else {
            println!("{name}: engine has none, Lemke {}", all.len());
            continue;
        };
        count.errors[1] = count.errors[1].max(error(&program, &engine));
        let Some(first) = all.first() else {
            println!("{name}: Lemke ends on a ray");
            continue;
        };
        count.solved[2] += 1;
        let spread = all.iter().map(|found| difference(first, found)[0]).fold(0.0, f64::max);
        let nearest = all.iter().map(|found| difference(found, &engine)[0]);
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        println!(
            "{name}: {} contacts, Lemke {}, spread {spread:.1e}, engine off {nearest:.1e}, errors {errors:.1e} {:.1e}",
            program.interactions.len(),
            all.len(),
            error(&program, &engine)
        );
        if spread < 1e-7 {
            count.unique += 1;
            count.apart = count.apart.max(nearest);
        }
        count.other += usize::from(nearest > 1e-5);
    }
    println!("{count:?}");
    count
}

const FALL: Kind = Kind {
    name: "rigid disks that fall, Coulomb",
    contact: "friction: 0.5",
    bond: "",
    scene: "friction_law: Coulomb(), analysis: Dynamic(dt: 5.0e-3), gravity: (0.0, -9.81),",
    stages: r#"Load(name: "load", increments: 30, remove_walls: ["top", "right"])"#,
};

const PRESS: Kind = Kind {
    name: "elastic disks between plates, Coulomb",
    contact: "normal_stiffness: 6.0e7, tangential_stiffness: 3.0e7, friction: 0.5",
    bond: "",
    scene: "friction_law: Coulomb(),",
    stages: r#"Load(name: "load", increments: 10, walls: { "top": Displacement(0.0, -5.0e-5) }),
        Load(name: "shear", increments: 20, walls: { "right": Displacement(1.0e-4, 0.0) })"#,
};

/// Programs of running scenes that were solved under Coulomb's law.
fn of_scene(kind: &'static Kind) -> impl Iterator<Item = (String, ConeProgram)> {
    (1..=4_u32).flat_map(move |seed| {
        let all = increments(kind, seed).into_iter().enumerate();
        all.filter(|(_, (program, solution))| {
            solution.law == SlidingLaw::Coulomb && (8..=30).contains(&program.interactions.len())
        })
        .map(move |(k, (program, _))| (format!("{}, seed {seed}, {k}", kind.name), program))
    })
}

fn randomised(dynamic: bool) -> impl Iterator<Item = (String, ConeProgram)> {
    (0..40_u64).map(move |seed| {
        let r = &mut Random(ChaCha8Rng::seed_from_u64(1000 + seed));
        (format!("random {dynamic} {seed}"), random_of(r, 10, 26, dynamic))
    })
}

/// Every time step is solved by both. Where all paths of pivots end at one motion, that of the
/// engine is the same; where they end at several, it is one of these in all programs but one.
#[test]
fn time_steps_are_those_of_lemke() {
    let random = compare(randomised(true));
    assert_eq!(random.solved, [40; 3], "{random:?}");
    assert!(random.unique == random.programs && random.apart < 1e-7, "{random:?}");
    let falling = compare(of_scene(&FALL));
    assert!(falling.programs >= 20 && falling.contacts <= 30, "{falling:?}");
    assert_eq!(falling.solved, [falling.programs; 3], "{falling:?}");
    assert!(falling.unique >= 20 && falling.apart < 1e-7, "{falling:?}");
    assert!(random.other + falling.other <= 1, "{random:?} {falling:?}");
    assert!(random.errors[1].max(falling.errors[1]) < 1e-9, "{random:?} {falling:?}");
}

/// Equilibria have several solutions, and Lemke's method may end on a ray. All programs of the scene
/// are solved by the engine, and a random one that pivots solve is solved by the engine.
#[test]
fn equilibria_are_solved_where_lemke_solves_them() {
    let random = compare(randomised(false));
    assert_eq!(random.solved[0], random.solved[2], "{random:?}");
    assert!(random.apart < 1e-7, "{random:?}");
    let pressed = compare(of_scene(&PRESS));
    assert_eq!(pressed.solved[1], pressed.programs, "{pressed:?}");
    assert!(pressed.solved[2] >= 20, "{pressed:?}");
}
