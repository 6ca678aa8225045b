//! temporary
use glam::DVec2;
#[derive(Default, Clone, Debug)]
pub struct CandidatePairs { pairs: Vec<(u32,u32)> }
impl CandidatePairs {
  pub fn ensure(&mut self, positions:&[DVec2], radii:&[f64], reach: f64) -> bool { super::grid::pairs_within(positions, radii, reach, &mut self.pairs); self.pairs.sort_unstable(); true }
  pub fn pairs(&self) -> &[(u32,u32)] { &self.pairs }
}
