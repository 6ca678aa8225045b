//! The ball on shaken grids, lattices and few disks.

use super::*;

/// Numbers between 0 and 1.
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Disks on a shaken grid, some of them missing.
fn loose(seed: u64, columns: usize, rows: usize) -> (Vec<DVec2>, Vec<f64>) {
    let mut random = random(seed);
    let mut disks = (Vec::new(), Vec::new());
    for k in 0..columns * rows {
        let radius = 0.3 + 0.2 * random();
        let room = 0.5 - radius;
        let shake = DVec2::new(random() - 0.5, random() - 0.5) * 2.0 * room;
        if random() < 0.9 {
            let place = DVec2::new((k % columns) as f64, (k / columns) as f64);
            disks.0.push(place + DVec2::splat(0.5) + shake);
            disks.1.push(radius);
        }
    }
    disks
}

/// The ball, at rest between two disks of a chain, as two points; the one on the right of the
/// way from i to j.
fn ball_between(ball: &RollingBall, i: usize, j: usize) -> DVec2 {
    let (x, y) = (ball.positions[i], ball.positions[j]);
    let d = y - x;
    let along =
        (ball.reach(i).powi(2) + d.length_squared() - ball.reach(j).powi(2)) / (2.0 * d.length());
    let aside = (ball.reach(i).powi(2) - along * along).sqrt();
    x + d.normalize() * along - d.normalize().perp() * aside
}

fn is_free(ball: &RollingBall, centre: DVec2) -> bool {
    let near = |i: usize| centre.distance(ball.positions[i]) - ball.reach(i);
    (0..ball.positions.len()).all(|i| near(i) > -1e-7)
}

#[test]
fn the_ball_cuts_no_disk_on_its_way() {
    for seed in 0..40 {
        let (positions, radii) = loose(seed, 12, 17);
        let ball = RollingBall::new(&positions, &radii, None);
        let bottom = Line { point: DVec2::ZERO, inward: DVec2::Y };
        let top = Line { point: DVec2::new(0.0, 17.0), inward: DVec2::NEG_Y };
        let around = ball.around().unwrap();
        let right = ball.between(&bottom, &top).unwrap();
        let left = ball.between(&top, &bottom).unwrap();
        assert!(around.len() > 30 && right.len() > 10 && left.len() > 10, "seed {seed}");
        for (i, j) in around.iter().zip(around.iter().cycle().skip(1)) {
            assert!(is_free(&ball, ball_between(&ball, *i, *j)), "seed {seed}: {i} to {j}");
        }
        for chain in [&right, &left] {
            for pair in chain.windows(2) {
                let centre = ball_between(&ball, pair[0], pair[1]);
                assert!(is_free(&ball, centre), "seed {seed}: {pair:?}");
                let free = ball.ball - 1e-7;
                assert!(bottom.height(centre) > free && top.height(centre) > free);
            }
        }
        let middle = |chain: &[usize]| {
            chain.iter().map(|i| positions[*i].x).sum::<f64>() / chain.len() as f64
        };
        assert!(middle(&left) < 1.5 && middle(&right) > 10.5, "seed {seed}");
    }
}

#[test]
fn a_lattice_whose_disks_touch_the_ball_three_at_a_time_has_a_chain() {
    // Where a row begins one disk further in, the ball lies in a site of the lattice.
    let mut positions = Vec::new();
    for row in 0..10 {
        for column in (row / 3)..(12 - row % 2) {
            let x = 2.0 * column as f64 + (row % 2) as f64;
            positions.push(DVec2::new(x, 1.0 + row as f64 * 3.0_f64.sqrt()));
        }
    }
    let radii = vec![1.0; positions.len()];
    let ball = RollingBall::new(&positions, &radii, None);
    let top = 2.0 + 9.0 * 3.0_f64.sqrt();
    let bottom = Line { point: DVec2::ZERO, inward: DVec2::Y };
    let top = Line { point: DVec2::new(0.0, top), inward: DVec2::NEG_Y };
    assert_eq!(ball.between(&bottom, &top).map(|chain| chain.len()), Some(10));
    let left = ball.between(&top, &bottom).unwrap();
    assert!(left.len() >= 10, "{left:?}");
    let around = ball.around().unwrap();
    assert!(around.len() >= 12 + 10 + 8 + 10 - 4, "{around:?}");
}

#[test]
fn few_disks_and_spilled_ones() {
    let at = |list: &[(f64, f64)]| list.iter().map(|x| DVec2::from(*x)).collect::<Vec<_>>();
    let bottom = Line { point: DVec2::ZERO, inward: DVec2::Y };
    let top = Line { point: DVec2::new(0.0, 6.0), inward: DVec2::NEG_Y };
    let column = at(&[(0.0, 1.0), (0.0, 3.0), (0.0, 5.0), (9.0, 1.0), (7.0, 1.0), (5.0, 2.9)]);
    let radii = [1.0; 6];
    let ball = RollingBall::new(&column, &radii, None);
    // The three disks on the right lie on the floor or in the air; the ball passes above them.
    assert_eq!(ball.between(&bottom, &top), Some(vec![0, 1, 2]));
    assert_eq!(ball.between(&top, &bottom), Some(vec![2, 1, 0]));
    assert_eq!(ball.around(), Some(vec![0, 1, 2, 1]));
    // Where it does not fit between the upper one and the plate, they are the outermost.
    let high = at(&[(0.0, 1.0), (0.0, 3.0), (0.0, 5.0), (9.0, 1.0), (7.0, 1.0), (5.0, 3.1)]);
    let ball = RollingBall::new(&high, &radii, None);
    assert_eq!(ball.between(&bottom, &top), Some(vec![3, 4, 5]));
    let one = RollingBall::new(&column[..1], &radii[..1], None);
    assert_eq!(one.around(), Some(vec![0]));
    assert_eq!(one.between(&bottom, &top), None);
    assert_eq!(RollingBall::new(&[], &[], None).around(), None);
}

#[test]
fn a_disk_in_a_wide_notch_is_found_and_one_behind_others_is_not() {
    // Disks on two columns; on the right the third disk of five is missing.
    let mut positions: Vec<DVec2> =
        (0..5).map(|k| DVec2::new(0.0, 1.0 + 2.0 * f64::from(k))).collect();
    positions.extend([0, 1, 3, 4].map(|k| DVec2::new(2.0, 1.0 + 2.0 * f64::from(k))));
    let radii = vec![1.0; positions.len()];
    let bottom = Line { point: DVec2::ZERO, inward: DVec2::Y };
    let top = Line { point: DVec2::new(0.0, 10.0), inward: DVec2::NEG_Y };
    let chain = |ball: f64| RollingBall::new(&positions, &radii, Some(ball)).between(&bottom, &top);
    assert_eq!(chain(0.9), Some(vec![5, 6, 2, 7, 8]));
    assert_eq!(chain(1.1), Some(vec![5, 6, 7, 8]));
}
