use super::*;
fn pairs(path: &str) -> (usize, Vec<(u32, u32)>) {
    let text = std::fs::read_to_string(path).unwrap();
    let disks: Vec<[f64; 3]> = text
        .lines()
        .skip(1)
        .map(|l| {
            let v: Vec<f64> = l.split(',').map(|x| x.parse().unwrap()).collect();
            [v[0], v[1], v[2]]
        })
        .collect();
    let d = 2.0 * disks.iter().map(|d| d[2]).fold(0.0, f64::max) + 1e-4;
    let mut cells: std::collections::HashMap<(i64, i64), Vec<u32>> = Default::default();
    let key = |x: f64| (x / d).floor() as i64;
    for (k, p) in disks.iter().enumerate() {
        cells.entry((key(p[0]), key(p[1]))).or_default().push(k as u32);
    }
    let mut pairs = Vec::new();
    for (k, p) in disks.iter().enumerate() {
        for i in -1..2 {
            for j in -1..2 {
                for &o in cells.get(&(key(p[0]) + i, key(p[1]) + j)).map_or(&[][..], |v| v) {
                    let q = disks[o as usize];
                    if (o as usize) < k && (p[0] - q[0]).hypot(p[1] - q[1]) < p[2] + q[2] + 6e-5 {
                        pairs.push((o, k as u32));
                    }
                }
            }
        }
    }
    let n = disks.len() as u32;
    let top = disks.iter().map(|d| d[1] + d[2]).fold(0.0, f64::max);
    for (k, p) in disks.iter().enumerate() {
        if p[1] - p[2] < 6e-5 {
            pairs.push((k as u32, n));
        }
        if p[1] + p[2] > top - 6e-5 {
            pairs.push((k as u32, n + 1));
        }
    }
    (n as usize + 2, pairs)
}
#[test]
fn temp_path() {
    for path in [
        "/work/lab/t/l1/specimen.csv",
        "/work/lab/t/l4/specimen.csv",
        "/work/lab/t/l15/specimen.csv",
    ] {
        let (bodies, pairs) = pairs(path);
        let start = std::time::Instant::now();
        let mut m = BodyMatrix::new(bodies, &pairs).unwrap();
        let t_symbolic = start.elapsed().as_secs_f64();
        let f = &m.pattern.fronts;
        let above = schedule::parents(&f.sizes);
        let mut depth = vec![0; f.tasks.len()];
        for divisible in [false, true] {
            let mut total = 0.0;
            let mut path_of = vec![0.0_f64; f.tasks.len()];
            let mut longest = 0.0_f64;
            let mut works = vec![];
            for (k, task) in f.tasks.iter().enumerate() {
                let (mut all, mut w) = (0.0, 0.0);
                for fr in &f.list[task.fronts.clone()] {
                    let x = tasks::work(fr.pivots.len(), fr.rows.len());
                    all += x;
                    w += if divisible && packed::packed_len(fr) > 0 { x / 12.0 } else { x };
                }
                total += all;
                works.push(w);
                path_of[k] += w;
                longest = longest.max(path_of[k]);
                if let Some(a) = above[k] {
                    path_of[a] = path_of[a].max(path_of[k]);
                }
            }
            for k in (0..f.tasks.len()).rev() {
                depth[k] = above[k].map_or(1, |a| depth[a] + 1);
            }
            // List scheduling.
            let mut model = String::new();
            for p in [2, 4, 8, 16] {
                let mut left: Vec<usize> = f.below.iter().map(Vec::len).collect();
                let mut up = vec![0.0_f64; works.len()];
                for k in (0..works.len()).rev() {
                    up[k] = works[k] + above[k].map_or(0.0, |a| up[a]);
                }
                let mut ready: Vec<usize> = (0..works.len()).filter(|k| left[*k] == 0).collect();
                let mut running: Vec<(f64, usize)> = vec![];
                let mut now = 0.0;
                loop {
                    while running.len() < p && !ready.is_empty() {
                        ready.sort_by(|a, b| up[*a].total_cmp(&up[*b]));
                        let k = ready.pop().unwrap();
                        running.push((now + works[k], k));
                    }
                    if running.is_empty() {
                        break;
                    }
                    running.sort_by(|a, b| b.0.total_cmp(&a.0));
                    let (t, k) = running.pop().unwrap();
                    now = t;
                    if let Some(a) = above[k] {
                        left[a] -= 1;
                        if left[a] == 0 {
                            ready.push(a);
                        }
                    }
                }
                model += &format!(" {p}:{:.2}", total / now);
            }
            println!(
                "{bodies} tasks {} depth {} divisible {divisible} total {total:.3e} path {:.4} bound {:.2} model{model}",
                f.tasks.len(),
                depth.iter().max().unwrap(),
                longest / total,
                total / longest
            );
            if !divisible {
                let stack: usize = f.tasks.iter().map(|t| t.update_len[0] + t.update_len[1]).sum();
                let factor: usize = f.tasks.iter().map(|t| t.factor_len).sum();
                println!(
                    "   updates {stack} factor {factor} beyond {} symbolic {t_symbolic:.3}s",
                    f.beyond.len()
                );
                let b = f.branches();
                let n: usize = m.branches().iter().map(|r| r.len()).sum();
                println!(
                    "   branches {} of {n}: {:?}",
                    b.len(),
                    m.branches().iter().map(|r| r.len()).collect::<Vec<_>>()
                );
                let mut fr: Vec<_> = f
                    .list
                    .iter()
                    .map(|x| {
                        (
                            tasks::work(x.pivots.len(), x.rows.len()) / total,
                            x.pivots.len(),
                            x.rows.len(),
                        )
                    })
                    .collect();
                fr.sort_by(|a, b| b.0.total_cmp(&a.0));
                println!("   {:?}", &fr[..8]);
            }
        }
        let mut results = vec![];
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                m.clear();
                let mut a = m.assembly();
                for i in 0..bodies {
                    for k in 0..3 {
                        a.add_diagonal(i, k, 1e-3 + (i % 3) as f64);
                    }
                }
                for k in 0..pairs.len() {
                    let (s, c) = (k as f64).sin_cos();
                    let rows = [[[c, -s], [s, c], [0.0, 0.5]], [[-c, s], [-s, -c], [0.0, 0.5]]];
                    a.add(k, &rows, &[[1.0, 0.0], [0.0, 0.3]]);
                }
                let mut x: Vec<[f64; 3]> =
                    (0..bodies).map(|i| [1.0, (i % 7) as f64 - 3.0, 0.1]).collect();
                let right = x.clone();
                assert!(m.factorise_and_solve(&mut x));
                let start = std::time::Instant::now();
                x.clone_from(&right);
                assert!(m.factorise_and_solve(&mut x));
                let t = start.elapsed();
                let mut y = right.clone();
                m.solve(&mut y);
                assert!(x == y);
                println!("   threads {threads}: {t:?}");
                results.push(x);
            });
        }
        assert!(results[0] == results[1] && results[0] == results[2]);
    }
}
