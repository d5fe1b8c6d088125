//! What a Jacobian says of the parameters: its rank, which combinations of them nothing depends on, and the covariance of the others.
//!
//! In: a Jacobian of residuals with unit standard deviation. Its columns are scaled to norm 1, so that units do not matter, and
//! factored: `J S = Q R`, `R = U sigma V^T`. Out: with the singular values above `RANK` of the largest as the rank, the null space
//! `N` (the last columns of V), and `cov = S V sigma^-2 V^T S`.
//!
//! A null space has infinitely many bases. The one told here is `N N_p^-1`: each of its vectors moves one parameter of `p` and none of the
//! others of `p`. With `p` fixed, all other parameters are determined. `p` is chosen by pivoting; where several would do, the least
//! important one.

use nalgebra::{DMatrix, DVector};

/// A singular value below this part of the largest is 0: residuals have some 1e-12 of round-off, and differences some 1e-9.
const RANK: f64 = 1e-8;

/// What moves by less than this beside the parameter that moves most, each as a part of what it does to the residuals, does not move.
const MOVES: f64 = 1e-9;

/// And what moves by less than this is not worth telling.
const NAMED: f64 = 1e-3;

/// What a Jacobian says.
#[derive(Clone, Debug)]
pub struct Information {
    /// The singular values of the Jacobian with columns of norm 1, from the largest.
    pub singular_values: Vec<f64>,
    /// How many of them are not 0.
    pub rank: usize,
    /// The combinations that nothing depends on.
    pub unseen: Vec<Unseen>,
}

/// Parameters that can move together without any residual noticing.
#[derive(Clone, Debug, PartialEq)]
pub struct Unseen {
    /// The parameter to fix.
    pub fixed: usize,
    /// What moves with it, and how far for a unit of it, from the one that matters most.
    pub with: Vec<(usize, f64)>,
    /// How many of these are worth telling: the others hardly move.
    pub named: usize,
}

impl Information {
    /// What `jacobian` says; `importance` is one number for each parameter: of those that cannot be told apart the least important
    /// one is to be fixed.
    #[must_use]
    pub fn of(jacobian: &DMatrix<f64>, importance: &[u8]) -> Self {
        let Factors { values, vectors, norms, rank } = Factors::of(jacobian);
        let n = norms.len();
        let null = vectors.columns(rank, n - rank).into_owned();
        let unseen = basis(&null, importance, &norms);
        Self { singular_values: values.iter().copied().collect(), rank, unseen }
    }

    /// How many parameters there are.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.singular_values.len()
    }
}

/// The covariance of the parameters of `jacobian` in the directions that it says something of; 0 in the others.
#[must_use]
pub fn covariance(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let Factors { values, vectors, norms, rank } = Factors::of(jacobian);
    let mut scaled = vectors.columns(0, rank).into_owned();
    for (mut column, value) in scaled.column_iter_mut().zip(values.iter()) {
        column /= *value;
    }
    for (mut row, norm) in scaled.row_iter_mut().zip(norms.iter()) {
        row /= *norm;
    }
    &scaled * scaled.transpose()
}

struct Factors {
    values: DVector<f64>,
    /// Right singular vectors, by column.
    vectors: DMatrix<f64>,
    /// Norms of the columns, 1 for those that are 0.
    norms: DVector<f64>,
    rank: usize,
}

impl Factors {
    fn of(jacobian: &DMatrix<f64>) -> Self {
        let n = jacobian.ncols();
        let norms = DVector::from_fn(n, |i, _| {
            Some(jacobian.column(i).norm()).filter(|norm| *norm > 0.0).unwrap_or(1.0)
        });
        // At least as many rows as columns: rows of zeros say nothing.
        let rows = jacobian.nrows().max(n);
        let mut scaled = DMatrix::zeros(rows, n);
        scaled.rows_mut(0, jacobian.nrows()).copy_from(jacobian);
        for (mut column, norm) in scaled.column_iter_mut().zip(norms.iter()) {
            column /= *norm;
        }
        let svd = scaled.qr().r().svd(false, true);
        let order = svd.singular_values;
        let vectors = svd.v_t.map_or_else(|| DMatrix::identity(n, n), |v_t| v_t.transpose());
        let largest = order.iter().copied().fold(0.0, f64::max);
        let rank = order.iter().filter(|value| **value > RANK * largest).count();
        Self { values: order, vectors, norms, rank }
    }
}

/// The basis of a null space in which each vector moves a parameter of its own.
fn basis(null: &DMatrix<f64>, importance: &[u8], norms: &DVector<f64>) -> Vec<Unseen> {
    let (n, k) = null.shape();
    let mut reduced = null.clone();
    let mut pivots: Vec<usize> = Vec::new();
    for vector in 0..k {
        let rest = |i: usize| reduced.view((i, vector), (1, k - vector)).norm();
        let free = || (0..n).filter(|i| !pivots.contains(i));
        let most = free().map(rest).fold(0.0, f64::max);
        // What moves not much less than any other will do as well.
        let will_do = free().filter(|i| rest(*i) >= 0.1 * most);
        let Some(pivot) = will_do.min_by_key(|i| importance.get(*i).copied().unwrap_or_default()) else {
            break;
        };
        pivots.push(pivot);
        // Turns the remaining vectors so that only the first of them moves the pivot.
        let row = reduced.view((pivot, vector), (1, k - vector)).transpose();
        let length = row.norm();
        let mut mirror = row;
        mirror[0] += if mirror[0] < 0.0 { -length } else { length };
        let square = mirror.norm_squared();
        if square > 0.0 {
            let mut rest = reduced.columns_mut(vector, k - vector);
            let along = &rest * &mirror * (2.0 / square);
            rest -= along * mirror.transpose();
        }
    }
    // Now pivot i moves with the vectors up to i alone: a triangle, whose inverse makes it 1 with its own and 0 with all others.
    let triangle = DMatrix::from_fn(pivots.len(), pivots.len(), |i, j| reduced[(pivots[i], j)]);
    let Some(inverse) = triangle.try_inverse() else { return Vec::new() };
    let own = reduced.columns(0, pivots.len()) * inverse;
    let told = pivots.iter().enumerate().map(|(vector, pivot)| {
        let column = own.column(vector);
        let most = column.amax();
        let mut with: Vec<(usize, f64)> = (0..n)
            .filter(|i| !pivots.contains(i) && column[*i].abs() > MOVES * most)
            .map(|i| (i, column[i]))
            .collect();
        with.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let named = with.iter().filter(|(_, moved)| moved.abs() > NAMED * most).count();
        // From columns of norm 1 back to the parameters themselves.
        let with = with.into_iter().map(|(i, moved)| (i, moved / norms[i] * norms[*pivot])).collect();
        Unseen { fixed: *pivot, with, named }
    });
    told.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_parameters_of_which_only_the_sum_counts_the_less_important_one_is_fixed() {
        // r = (2 (a + b), c, a + b + c): columns in other units do not matter.
        let jacobian = DMatrix::from_row_slice(3, 3, &[2.0, 200.0, 0.0, 0.0, 0.0, 1.0, 1.0, 100.0, 1.0]);
        let told = Information::of(&jacobian, &[9, 1, 9]);
        assert_eq!((told.rank, told.parameters()), (2, 3));
        let [one] = &told.unseen[..] else { panic!("{told:?}") };
        assert_eq!(one.fixed, 1);
        let [(0, moved)] = one.with[..] else { panic!("{told:?}") };
        assert!((moved + 100.0).abs() < 1e-9, "{moved}");
        assert_eq!(Information::of(&jacobian, &[1, 9, 9]).unseen[0].fixed, 0);
    }

    #[test]
    fn a_parameter_that_nothing_depends_on_is_unseen_alone() {
        let jacobian = DMatrix::from_row_slice(2, 3, &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        let told = Information::of(&jacobian, &[0; 3]);
        assert_eq!(told.unseen, [Unseen { fixed: 1, with: Vec::new(), named: 0 }]);
    }

    #[test]
    fn the_covariance_is_the_inverse_of_the_normal_matrix() {
        let jacobian = DMatrix::from_row_slice(4, 2, &[1.0, 2.0, 0.5, -1.0, 3.0, 0.1, 2.0, 2.0]);
        let expected = (jacobian.transpose() * &jacobian).try_inverse().expect("regular");
        assert!((covariance(&jacobian) - expected).amax() < 1e-14);
    }
}
