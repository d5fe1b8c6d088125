//! What joints are off by, anew in each posture: friction that winds up a gear, backlash. All measurements of a posture share it.
//!
//! With `G` what a standard deviation of each joint adds to the residuals of a posture (unit standard deviation each by themselves), those
//! have the covariance `C = 1 + G G^T = L L^T`. The residuals `L^-1 r` are independent again, and all else (iteration, rank, covariance)
//! needs to know nothing of it.
//!
//! ```text
//! what the instrument was off by:   n = C^-1 r,   with the covariance 1 - C^-1 that is left
//! ```

use nalgebra::{DMatrix, DVector};

use crate::problem::{PostureId, Problem};

/// Measurements that share what joints are off by.
pub(crate) struct Block {
    /// Their measurements, each with its first row and how many it has.
    pub(crate) parts: Vec<(usize, usize, usize)>,
    /// What a standard deviation of each joint adds to each row.
    shares: DMatrix<f64>,
}

/// Makes independent what a block's rows share.
pub(crate) struct Whitening {
    rows: Vec<usize>,
    /// L, a lower triangle.
    root: DMatrix<f64>,
}

/// Groups measurements, each with its first row, by the postures that they share. `share` writes what the joints of a posture add to a
/// measurement's rows.
pub(crate) fn blocks(
    problem: &Problem,
    used: Vec<(usize, usize)>,
    share: impl Fn(usize, usize, &mut DMatrix<f64>),
) -> Vec<Block> {
    let scatters = |id: &PostureId| !problem.arms[problem.postures[id.0].arm.0].scatter.is_empty();
    // A measurement of two arms ties their postures together.
    let mut tied: Vec<usize> = (0..problem.postures.len()).collect();
    let root = |tied: &[usize], mut one: usize| {
        while tied[one] != one {
            one = tied[one];
        }
        one
    };
    let mut ones = Vec::new();
    for (measurement, row) in used {
        let own: Vec<usize> = problem.measurements[measurement]
            .postures
            .iter()
            .filter(|id| scatters(id))
            .map(|id| id.0)
            .collect();
        let Some(first) = own.first() else { continue };
        for other in &own[1..] {
            let (a, b) = (root(&tied, *first), root(&tied, *other));
            tied[a] = b;
        }
        ones.push((measurement, row, own));
    }
    let mut groups: std::collections::BTreeMap<usize, Vec<_>> = std::collections::BTreeMap::new();
    for one in ones {
        groups.entry(root(&tied, one.2[0])).or_default().push(one);
    }
    groups.into_values().map(|group| block(problem, &group, &share)).collect()
}

fn block(
    problem: &Problem,
    group: &[(usize, usize, Vec<usize>)],
    share: &impl Fn(usize, usize, &mut DMatrix<f64>),
) -> Block {
    let mut postures: Vec<usize> = group.iter().flat_map(|(.., own)| own.iter().copied()).collect();
    postures.sort_unstable();
    postures.dedup();
    let mut columns = Vec::new();
    let mut width = 0;
    for posture in &postures {
        columns.push(width);
        width += problem.postures[*posture].q.len();
    }
    let parts: Vec<(usize, usize, usize)> =
        group.iter().map(|(i, row, _)| (*i, *row, problem.device_of(*i).residuals())).collect();
    let height = parts.iter().map(|(.., rows)| rows).sum();
    let mut shares = DMatrix::zeros(height, width);
    let mut row = 0;
    for ((i, _, own), (.., rows)) in group.iter().zip(&parts) {
        for posture in own {
            let Ok(at) = postures.binary_search(posture) else { continue };
            let mut one = DMatrix::zeros(*rows, problem.postures[*posture].q.len());
            share(*i, *posture, &mut one);
            shares.view_mut((row, columns[at]), one.shape()).copy_from(&one);
        }
        row += rows;
    }
    Block { parts, shares }
}

impl Block {
    fn rows(&self) -> Vec<usize> {
        self.parts.iter().flat_map(|(_, row, rows)| *row..row + rows).collect()
    }

    fn covariance(&self) -> DMatrix<f64> {
        let n = self.shares.nrows();
        DMatrix::identity(n, n) + &self.shares * self.shares.transpose()
    }

    /// `None` if a share is not finite.
    pub(crate) fn whitening(&self) -> Option<Whitening> {
        Some(Whitening { rows: self.rows(), root: self.covariance().cholesky()?.unpack() })
    }

    /// By row what the instrument is expected to have been off by, squared, in units of its standard deviation.
    pub(crate) fn noise(&self, residuals: &[f64]) -> Vec<(usize, f64)> {
        let rows = self.rows();
        let own = DVector::from_iterator(rows.len(), rows.iter().map(|row| residuals[*row]));
        let Some(inverse) = self.covariance().try_inverse() else { return Vec::new() };
        let noise = &inverse * own;
        let square = |(i, row): (usize, usize)| (row, noise[i] * noise[i] + 1.0 - inverse[(i, i)]);
        rows.into_iter().enumerate().map(square).collect()
    }
}

impl Whitening {
    /// `L^-1 r`, in place.
    pub(crate) fn apply(&self, residuals: &mut [f64]) {
        for (i, row) in self.rows.iter().enumerate() {
            let known: f64 = (0..i).map(|j| self.root[(i, j)] * residuals[self.rows[j]]).sum();
            residuals[*row] = (residuals[*row] - known) / self.root[(i, i)];
        }
    }
}
