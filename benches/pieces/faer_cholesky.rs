//! The same matrix in faer's sparse Cholesky factorisation, supernodal and in an order of minimum
//! degree.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, Mat, Par, Side};

/// Matrix, order, and room for the factor.
pub struct FaerCholesky {
    matrix: SparseColMat<usize, f64>,
    symbolic: SymbolicCholesky<usize>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl FaerCholesky {
    /// `diagonal` on the diagonal, and for each pair a spring of stiffness 1 in each of the degrees
    /// of freedom.
    pub fn new(bodies: usize, pairs: &[(u32, u32)], diagonal: f64) -> Self {
        let n = 3 * bodies;
        let mut entries: Vec<_> = (0..n).map(|k| Triplet::new(k, k, diagonal)).collect();
        for (a, b) in pairs.iter().map(|(a, b)| (3 * *a as usize, 3 * *b as usize)) {
            // Zeros too: the matrix has them where directions differ.
            for (row, column) in (0..9).map(|k| (k / 3, k % 3)) {
                let value = if row == column { -1.0 } else { 0.0 };
                entries.push(Triplet::new(a.max(b) + row, a.min(b) + column, value));
            }
            entries.extend((0..3).flat_map(|k| [a + k, b + k]).map(|k| Triplet::new(k, k, 1.0)));
        }
        let matrix =
            SparseColMat::try_new_from_triplets(n, n, &entries).unwrap_or_else(|e| panic!("{e:?}"));
        let symbolic = factorize_symbolic_cholesky(
            matrix.symbolic(),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..Default::default()
            },
        )
        .unwrap_or_else(|e| panic!("{e:?}"));
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let factor = vec![0.0; symbolic.len_val()];
        Self { matrix, symbolic, factor, memory: MemBuffer::new(scratch) }
    }

    pub fn factorise(&mut self) {
        let no = LltRegularization {
            dynamic_regularization_delta: 0.0,
            dynamic_regularization_epsilon: 0.0,
        };
        let memory = MemStack::new(&mut self.memory);
        let matrix = self.matrix.as_ref();
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                matrix,
                Side::Lower,
                no,
                Par::Seq,
                memory,
                Default::default(),
            )
            .unwrap_or_else(|e| panic!("{e:?}"));
    }

    pub fn solve(&mut self, x: &mut Mat<f64>) {
        let factor = LltRef::new(&self.symbolic, &self.factor[..]);
        let memory = MemStack::new(&mut self.memory);
        factor.solve_in_place_with_conj(Conj::No, x.as_mut(), Par::Seq, memory);
    }
}
