//! Columns of numbers in a page: whole columns behind one another, compressed, as base64.
//!
//! The bytes of a column are split into planes, all lowest bytes first: the higher bytes of
//! neighbours are alike and shrink well. A column that changes from frame to frame holds whole
//! numbers: steps of a scale, identities, or the bits of `float16` (11 bits: three significant
//! digits, or steps below the scale) in their order. It is written as the difference from the same
//! column of the frame before, which loses nothing and is a third smaller. Differences are 0, -1,
//! 1, -2, ... as 0, 1, 2, 3, ... so that small ones have no higher bytes.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;

/// Largest number of steps that fits into this number of bytes. Its opposite less one marks a row
/// that is not in a frame.
pub(crate) fn most_steps(width: usize) -> i32 {
    (1 << (8 * width - 1)) - 1
}

/// Columns that are being encoded for a page.
#[derive(Default)]
pub struct Columns {
    bytes: Vec<u8>,
    /// Columns that change, as whole numbers.
    codes: Vec<Vec<i32>>,
    /// Those of the frame before; none if this one is to be read without it.
    before: Vec<Vec<i32>>,
}

impl Columns {
    /// Columns of the frame after that with `codes`.
    pub fn after(codes: Vec<Vec<i32>>) -> Self {
        Self { before: codes, ..Self::default() }
    }

    /// The lowest `width` bytes of all values.
    fn planes(&mut self, values: impl Iterator<Item = [u8; 4]> + Clone, width: usize) {
        for k in 0..width {
            self.bytes.extend(values.clone().map(|bytes| bytes[k]));
        }
    }

    /// A column that changes, of whole numbers that `width` bytes hold.
    pub fn changing(&mut self, codes: Vec<i32>, width: usize) {
        let before = self.before.get(self.codes.len());
        let beyond = 32 - 8 * width as u32;
        let change = |k: usize| {
            let change = codes[k].wrapping_sub(before.map_or(0, |before| before[k]));
            let change = (change << beyond) >> beyond;
            (((change << 1) ^ (change >> 31)) as u32).to_le_bytes()
        };
        let changes: Vec<_> = (0..codes.len()).map(change).collect();
        self.planes(changes.into_iter(), width);
        self.codes.push(codes);
    }

    /// Numbers over `scale` that change, rounded to `float16`.
    pub(crate) fn changing_halves(&mut self, values: &[f32], scale: f64) {
        self.changing(values.iter().map(|x| ordered(*x, scale)).collect(), 2);
    }

    pub fn counts(&mut self, values: &[u32]) {
        self.planes(values.iter().map(|x| x.to_le_bytes()), 4);
    }

    pub fn numbers(&mut self, values: &[f32]) {
        self.planes(values.iter().map(|x| x.to_le_bytes()), 4);
    }

    /// Numbers that change in steps of `step`, of two or three bytes each. Not a number is a row
    /// that is not there; numbers beyond the range are at its end.
    pub(crate) fn changing_steps(&mut self, values: &[f32], step: f64, width: usize) {
        let most = most_steps(width);
        let steps = |x: &f32| {
            let limit = f64::from(most);
            let steps = (f64::from(*x) / step).round().clamp(-limit, limit) as i32;
            if x.is_nan() { -most - 1 } else { steps }
        };
        self.changing(values.iter().map(steps).collect(), width);
    }

    /// The text in the page, and what the columns of the next frame start from.
    pub fn text(self) -> (String, Vec<Vec<i32>>) {
        // Writing to memory does not fail.
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
        let done = encoder.write_all(&self.bytes).and_then(|()| encoder.finish());
        (BASE64_STANDARD.encode(done.unwrap_or_default()), self.codes)
    }
}

/// Bits of `float16` as a whole number that grows with it.
fn ordered(x: f32, scale: f64) -> i32 {
    let bits = i32::from(f16::from_f64(f64::from(x) / scale).to_bits());
    if bits < 0x8000 { bits } else { 0x8000 - bits }
}

/// Level of the compression. Level 6 takes three times as long and gains 5 %.
const LEVEL: u32 = 1;

/// A scale for `float16` of numbers with this typical magnitude: a power of two, so that it changes
/// no digit. Numbers down to a sixteenth of it keep three digits (error at most 2^-11 of the
/// number); smaller ones have steps of at most 2^-14 of it, the subnormal numbers, so that they
/// change little from frame to frame. Numbers up to 2^25 times it fit.
pub fn scale(typical: f32) -> f64 {
    if typical > 0.0 && typical.is_finite() {
        2.0_f64.powi(f64::from(typical).log2().floor() as i32 + 10)
    } else {
        1.0
    }
}
