//! The search for the end of the increment in which a measure comes to its value.
//!
//! All tries begin at the same state, so that the measure is one function of the progress at the
//! end of the increment. The search finds where this function comes to the value first.

/// Length of an increment below which a measure that passes its value is taken to jump.
pub(crate) const RESOLUTION: f64 = 1e-7;

/// Number of tries that may fall short before the whole increment is tried.
const PATIENCE: u32 = 6;

/// Progress of the stage, in increments, and the measure there.
pub type Point = [f64; 2];

/// Where a reading lies from the value, seen from where the measure comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Before it.
    Short,
    /// Within the tolerance.
    At,
    /// Beyond it.
    Past,
}

/// What to do after a try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Next {
    /// The increment stays, and the stage continues.
    GoOn,
    /// The increment stays, and the stage ends with it.
    Land,
    /// The increment is repeated up to this progress.
    Repeat(f64),
}

/// One try.
#[derive(Clone, Copy, Debug)]
pub struct Try {
    /// Where it ended.
    pub end: Point,
    /// Where the measure is.
    pub side: Side,
    /// Whether it ended before the progress that was asked for: it was halved, or a bond broke.
    pub is_cut: bool,
    /// Whether a bond broke at its end.
    pub ruptures: bool,
}

/// The search within one increment.
#[derive(Clone, Debug)]
pub struct Search {
    value: f64,
    /// The point before the base, from another increment.
    before: Option<Point>,
    base: Point,
    /// The longest possible increment ends here.
    whole: f64,
    /// End of the longest try that fell short.
    low: Point,
    /// End of the shortest try that did not, and whether it was at the value, with ruptures.
    high: Option<(Point, Side, bool)>,
    /// Number of tries that fell short of where they were expected to land.
    short: u32,
    /// Length of the bracket before the last try.
    length: f64,
    /// The next try is the last, whether it lands or not.
    is_last: bool,
}

impl Search {
    /// A search from the last of the `points`.
    pub fn new(points: &[Point], whole: f64, value: f64) -> Option<Self> {
        let (base, earlier) = points.split_last()?;
        Some(Self {
            value,
            before: earlier.last().copied().filter(|before| before[0] < base[0]),
            base: *base,
            whole,
            low: *base,
            high: None,
            short: 0,
            length: f64::INFINITY,
            is_last: false,
        })
    }

    /// End of a try while none has reached the value: where the measure is expected to reach it, or
    /// the end of the whole increment.
    pub fn ahead(&self) -> f64 {
        self.expected().filter(|end| *end < self.whole - RESOLUTION).unwrap_or(self.whole)
    }

    /// Takes the last try back in favour of the one before it that did not fall short, or of the
    /// whole increment. `None` if the last try was that already.
    pub(crate) fn without_last(&mut self) -> Option<f64> {
        if self.is_last {
            return None;
        }
        self.is_last = true;
        Some(self.high.map_or(self.whole, |(end, ..)| end[0]))
    }

    /// What follows from a try.
    pub fn see(&mut self, made: Try) -> Next {
        let Try { end, side, is_cut, ruptures } = made;
        if side == Side::Short {
            if is_cut || self.is_last || end[0] >= self.whole - RESOLUTION {
                return Next::GoOn;
            }
            self.low = end;
            if self.high.is_none() {
                // It was expected to land here.
                self.short += 1;
                return Next::Repeat(if self.short < PATIENCE { self.ahead() } else { self.whole });
            }
        } else {
            if self.is_last || (side == Side::At && self.is_first_at(end)) {
                return Next::Land;
            }
            self.high = Some((end, side, ruptures));
        }
        let Some((high, ..)) = self.high else { return Next::GoOn };
        if high[0] - self.low[0] <= RESOLUTION {
            if side != Side::Short {
                return Next::Land;
            }
            self.is_last = true;
            return Next::Repeat(high[0]);
        }
        let next = self.within();
        if next >= high[0] {
            self.is_last = true;
        }
        Next::Repeat(next)
    }

    /// Whether a reading at the value is the first one: the measure has not come to rest there
    /// before, as the stress of a specimen does that has been unloaded.
    fn is_first_at(&self, end: Point) -> bool {
        let to_base = self.before.map(|before| (before, self.base));
        let to_low = Some((self.base, self.low)).filter(|(base, low)| low[0] > base[0]);
        let earlier = to_low.or(to_base).and_then(|(a, b)| rate(a, b));
        let now = rate(self.low, end);
        matches!((earlier, now), (Some(earlier), Some(now)) if now / earlier >= 0.5)
    }

    /// Where the measure comes to the value at the rate that it has come with.
    fn expected(&self) -> Option<f64> {
        let from = if self.low[0] > self.base[0] { Some(self.base) } else { self.before };
        let rate = rate(from?, self.low)?;
        let way = (self.value - self.low[1]) / rate;
        (way > 0.0 && way.is_finite()).then_some(self.low[0] + way)
    }

    /// The end of the next try in the bracket.
    fn within(&mut self) -> f64 {
        let Some((high, side, ruptures)) = self.high else { return self.whole };
        let (low, length) = (self.low, high[0] - self.low[0]);
        let is_slow = length > 0.5 * self.length;
        self.length = length;
        // Without the rupture, which is at the end of the try, the measure is short.
        if ruptures && self.low[0] <= self.base[0] {
            return high[0] - 0.5 * RESOLUTION;
        }
        let inside = |end: &f64| *end > low[0] && *end < high[0];
        let expected = self.expected();
        let half = 0.5 * (low[0] + high[0]);
        let next = match side {
            // The measure comes to the value where this try ended, and not before.
            Side::At if expected.is_some_and(|end| end >= high[0] - RESOLUTION) => return high[0],
            _ if is_slow => half,
            Side::Past => expected
                .filter(inside)
                .unwrap_or_else(|| low[0] + length * (self.value - low[1]) / (high[1] - low[1])),
            _ => expected.filter(inside).unwrap_or(half),
        };
        next.clamp(low[0] + 0.4 * RESOLUTION, high[0] - 0.4 * RESOLUTION)
    }
}

fn rate(from: Point, to: Point) -> Option<f64> {
    let rate = (to[1] - from[1]) / (to[0] - from[0]);
    (rate.is_finite() && rate != 0.0).then_some(rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: f64 = 1e-6;

    /// Lengths of the increments until a function of the progress has landed, where it landed, and
    /// the number of tries.
    fn land(f: impl Fn(f64) -> f64, value: f64) -> (Vec<f64>, Point, usize) {
        let (mut points, mut made, mut tries) = (vec![[0.0, f(0.0)]], Vec::new(), 0);
        let scale = f64::max(f(0.0).abs(), value.abs());
        let side = |now: f64| {
            let short = (value - f(0.0)).signum() * (value - now);
            match short {
                _ if short.abs() <= TOLERANCE * scale => Side::At,
                _ if short > 0.0 => Side::Short,
                _ => Side::Past,
            }
        };
        while made.len() < 50 {
            let base = points[points.len() - 1][0];
            let whole = base.floor() + 1.0;
            let mut search = Search::new(&points, whole, value).unwrap_or_else(|| unreachable!());
            let mut asked = search.ahead();
            let (end, next) = loop {
                tries += 1;
                let end = [asked, f(asked)];
                let made = Try { end, side: side(end[1]), is_cut: false, ruptures: false };
                match search.see(made) {
                    Next::Repeat(next) => asked = next,
                    next => break (end, next),
                }
            };
            made.push(end[0] - base);
            points.push(end);
            if next == Next::Land {
                break;
            }
        }
        (made, points[points.len() - 1], tries)
    }

    #[test]
    fn a_straight_line_lands_in_one_shortened_increment() {
        let (made, [_, at], tries) = land(|x| 3.0 * x, 10.0);
        assert!((at - 10.0).abs() <= 1e-5, "{at}");
        assert_eq!((made.len(), tries), (4, 4), "{made:?}");
        // Within the first increment no rate is known.
        let (made, [x, _], tries) = land(|x| 5.0 - 20.0 * x, 0.0);
        assert!((x - 0.25).abs() < 1e-6 && made.len() == 1 && tries <= 4, "{x} {tries}");
    }

    /// An increment that ends at the value is not shortened by round-off.
    #[test]
    fn a_value_at_the_end_of_an_increment_takes_no_more_tries() {
        let (made, _, tries) = land(|x| 0.1 * x, 1.0);
        assert_eq!((made, tries), (vec![1.0; 10], 10));
    }

    #[test]
    fn curves_land_within_the_tolerance() {
        for (name, f, value) in [
            ("hardens", (|x: f64| x * x) as fn(f64) -> f64, 7.3),
            ("softens", |x: f64| x.sqrt(), 2.2),
            ("saturates", |x: f64| 1.0 - (-x).exp(), 0.9),
            ("explodes", |x: f64| x.exp(), 50.0),
            ("closes a gap", |x: f64| (x - 1.6).max(0.0), 1.7),
            ("unloads", |x: f64| (4.0 - x).max(0.0).powf(1.5), 0.1),
        ] {
            let (made, [x, at], tries) = land(f, value);
            let scale = f64::max(value, f(0.0));
            assert!((at - value).abs() <= 1.01 * TOLERANCE * scale, "{name}: {x} {at}");
            // At worst every second try halves the bracket.
            assert!(tries <= made.len() + 2 * 24, "{name}: {tries} tries");
            let shortened = made.iter().filter(|length| **length < 1.0 - 1e-9).count();
            assert_eq!(shortened, 1, "{name}: {made:?}");
        }
    }

    /// A specimen that has been unloaded carries no tension: the stress stays at zero. The stage ends
    /// where it comes to zero, and not where the increment ends.
    #[test]
    fn a_measure_that_rests_at_its_value_lands_where_it_came_to_it() {
        for kink in [0.3, 1.3, 2.02, 2.97] {
            let (_, [x, at], tries) = land(|x| (kink - x).max(0.0), 0.0);
            assert!((x - kink).abs() <= 1e-5 && at <= 3e-6, "{kink}: {x} {at}");
            assert!(tries <= 30, "{kink}: {tries} tries");
        }
    }

    #[test]
    fn a_jump_is_found_and_passed() {
        for jump in [0.4, 1.234, 3.999] {
            for value in [0.01, 0.5, 0.99] {
                let (_, [x, at], tries) = land(|x| f64::from(x >= jump), value);
                assert!(x >= jump && x - jump <= RESOLUTION, "{jump}: {x}");
                assert!((at - 1.0).abs() < 1e-15 && tries <= 50, "{tries} tries");
            }
        }
    }
}
