//! Singular values of a Jacobian by one-sided Jacobi rotations (Hestenes 1958), on the stack.
//!
//! The columns (of the matrix, or of its transpose where it is wider than high) are rotated in pairs until all are
//! perpendicular to each other; their lengths are the singular values, small ones to full relative accuracy.

use nalgebra::SMatrix;

use mrroc::robot::MAX_JOINTS;

/// Sweeps over all pairs; six columns are perpendicular to round-off after about five.
const SWEEPS: usize = 12;

/// Cosine of the angle between two columns that counts as perpendicular.
const PERPENDICULAR: f64 = 1e-15;

/// The `min(6, N)` singular values of `diag(1/length, 1) J`, in no order, then zeros.
pub(crate) fn singular_values<const N: usize>(jacobian: &SMatrix<f64, 6, N>, length: f64) -> [f64; 6] {
    let scaled = |row: usize, joint: usize| jacobian[(row, joint)] / if row < 3 { length } else { 1.0 };
    let count = N.min(6);
    let mut columns = [[0.0; MAX_JOINTS]; 6];
    for (i, column) in columns.iter_mut().enumerate().take(count) {
        for (k, entry) in column.iter_mut().enumerate().take(N.max(6)) {
            *entry = if N < 6 { scaled(k, i) } else { scaled(i, k) };
        }
    }
    for _ in 0..SWEEPS {
        let mut turned = false;
        for i in 0..count {
            for j in i + 1..count {
                turned |= make_perpendicular(&mut columns, i, j);
            }
        }
        if !turned {
            break;
        }
    }
    columns.map(|column| dot(&column, &column).sqrt())
}

/// Rotates two columns until they are perpendicular; whether that was needed.
fn make_perpendicular(columns: &mut [[f64; MAX_JOINTS]; 6], i: usize, j: usize) -> bool {
    let (a, b) = (columns[i], columns[j]);
    let aa = dot(&a, &a);
    let bb = dot(&b, &b);
    let ab = dot(&a, &b);
    if ab.is_nan() || ab.abs() <= PERPENDICULAR * (aa * bb).sqrt() {
        return false;
    }
    let zeta = (bb - aa) / (2.0 * ab);
    let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = cosine * tangent;
    for k in 0..MAX_JOINTS {
        columns[i][k] = cosine * a[k] - sine * b[k];
        columns[j][k] = sine * a[k] + cosine * b[k];
    }
    true
}

fn dot(a: &[f64; MAX_JOINTS], b: &[f64; MAX_JOINTS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::singular_values;
    use nalgebra::SMatrix;

    /// Expected values: nalgebra's bidiagonalising singular value decomposition.
    #[test]
    fn singular_values_agree_with_those_of_nalgebra() {
        let entry = |i: usize, j: usize| (1.0 + 3.7 * i as f64 + 1.9 * (j * j) as f64).sin();
        let wide = SMatrix::<f64, 6, 7>::from_fn(entry);
        let mut found = singular_values(&wide, 1.0);
        found.sort_by(|a, b| b.total_cmp(a));
        for (found, expected) in found.iter().zip(wide.singular_values().iter()) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
        let narrow = SMatrix::<f64, 6, 5>::from_fn(entry);
        let mut found = singular_values(&narrow, 1.0);
        found.sort_by(|a, b| b.total_cmp(a));
        for (found, expected) in found.iter().zip(narrow.singular_values().iter()) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
    }
}
