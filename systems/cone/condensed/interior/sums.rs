//! What passes over the interactions add up.

use std::ops::Add;

/// Maxima over interactions: residuals of kinematics and limits, force, product; and sums. Two sets
/// of interactions are added up.
#[derive(Clone, Copy, Default)]
pub struct Sizes {
    pub kinematic: f64,
    pub primal: f64,
    pub force: f64,
    pub product: f64,
    /// Sum of the products.
    pub products: f64,
    /// The terms `l's`, `b'lambda` and `s'Cs` of the duality gap.
    pub linear: f64,
    pub strength: f64,
    pub energy: f64,
}

impl Add for Sizes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            kinematic: self.kinematic.max(other.kinematic),
            primal: self.primal.max(other.primal),
            force: self.force.max(other.force),
            product: self.product.max(other.product),
            products: self.products + other.products,
            linear: self.linear + other.linear,
            strength: self.strength + other.strength,
            energy: self.energy + other.energy,
        }
    }
}

/// The length of a step to the boundary, and the products along it.
#[derive(Clone, Copy)]
pub struct Ahead {
    /// Maximum length, at most 1, that leaves all slacks and multipliers positive.
    pub length: f64,
    /// Sum of products, and its derivatives by the length: first, and half the second.
    products: [f64; 3],
}

impl Default for Ahead {
    fn default() -> Self {
        Self { length: 1.0, products: [0.0; 3] }
    }
}

impl Add for Ahead {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let products = [0, 1, 2].map(|k| self.products[k] + other.products[k]);
        Self { length: self.length.min(other.length), products }
    }
}

impl Ahead {
    /// Takes a slack w and its multiplier lambda along with their steps.
    #[inline]
    pub fn take(&mut self, w: f64, lambda: f64, dw: f64, dlambda: f64) {
        if w + self.length * dw < 0.0 {
            self.length = -w / dw;
        }
        if lambda + self.length * dlambda < 0.0 {
            self.length = -lambda / dlambda;
        }
        self.products[0] += w * lambda;
        self.products[1] += w * dlambda + lambda * dw;
        self.products[2] += dw * dlambda;
    }

    pub(crate) fn products_after(&self) -> f64 {
        let [constant, linear, quadratic] = self.products;
        (constant + self.length * (linear + self.length * quadratic)).max(0.0)
    }

    /// Shortens the step to where the sum of products has grown by the factor.
    pub(crate) fn bound_growth(&mut self, factor: f64) {
        let [constant, linear, quadratic] = self.products;
        if self.products_after() > factor * constant && constant > 0.0 {
            // The positive root of quadratic x^2 + linear x = (factor - 1) constant, without
            // cancellation.
            let right = (factor - 1.0) * constant;
            let root = (linear * linear + 4.0 * quadratic * right).max(0.0).sqrt();
            self.length = self.length.min(2.0 * right / (linear + root));
        }
    }
}

/// What the responses A and B say about tau: their gains, and the sum of squares in the
/// denominator of its step.
#[derive(Clone, Copy, Default)]
pub(crate) struct Gains {
    pub of_residuals: f64,
    pub of_products: f64,
    pub squares: f64,
}

impl Add for Gains {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            of_residuals: self.of_residuals + other.of_residuals,
            of_products: self.of_products + other.of_products,
            squares: self.squares + other.squares,
        }
    }
}
