//! temporary
use glam::DVec2;
pub fn pairs_within(x: &[DVec2], r: &[f64], reach: f64, out: &mut Vec<(u32,u32)>) { out.clear(); for i in 0..x.len() { for j in i+1..x.len() { if x[i].distance(x[j]) - r[i]-r[j] <= reach { out.push((i as u32,j as u32)); } } } }
