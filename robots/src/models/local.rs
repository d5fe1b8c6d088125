//! What dimensions cannot say of an arm: smooth errors of its joints, corrected where they were measured.
//!
//! In: joint positions as encoders read them. Out: by how much the joints are off there, after the dimensions of a calibration:
//!
//! ```text
//! joints stand at q + d(q),   d(q) = w(q) sum_k c_k f_k(q)
//! f: cos a_j, sin a_j of each joint, and the four products of each two neighbours     (2 N + 4 (N - 1) of them)
//! a_j = q_j of a turning joint, (q_j - middle) / half the range of a sliding one
//! w = 1 where postures were measured, sinks to 0 beside that, and is 0 beyond         (product over joints of 1 - 10 s^3 + 15 s^4 - 6 s^5)
//! ```
//!
//! That is what a gear out of centre (once a turn) and a link that sags (by the angles of two joints) do. Going back is `q <- p - d(q)`, which comes nearer by the
//! steepness of `d` each time: files with more than [`LocalCorrection::STEEPEST`] are refused, so that [`ROUNDS`] are enough.

use nalgebra::{SMatrix, SVector};

use mrroc::robot::JointKind;

/// How often to go back at most.
const ROUNDS: usize = 20;

/// What is near enough when going back [rad or m].
const NEAR: f64 = 1e-14;

/// What is no calibration: why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoCalibration(pub(crate) String);

/// A local correction as its file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalCorrection {
    /// By joint the lowest and the highest position that was measured, and how far beside that the correction fades out [rad or m], > 0.
    pub range: Vec<[f64; 3]>,
    /// By joint whether it turns or slides.
    pub kinds: Vec<JointKind>,
    /// By function `f` what each joint is off by [rad or m].
    pub coefficients: Vec<Vec<f64>>,
}

impl LocalCorrection {
    /// How much `d` may change for a unit of the joints, a ratio: gears and links are off by a thousandth.
    pub const STEEPEST: f64 = 0.05;

    /// How many functions there are of so many joints.
    #[must_use]
    pub const fn count(joints: usize) -> usize {
        2 * joints + 4 * joints.saturating_sub(1)
    }

    /// Checks it for an arm.
    ///
    /// # Errors
    /// [`NoCalibration`]: another number of joints or functions, an empty range, or more than [`LocalCorrection::STEEPEST`].
    pub fn check(&self) -> Result<(), NoCalibration> {
        let no = |what: String| Err(NoCalibration(what));
        let n = self.range.len();
        if n == 0 || self.kinds.len() != n || self.coefficients.len() != Self::count(n) {
            return no(format!(
                "its `local` has {} rows, of {n} joints there are {}",
                self.coefficients.len(),
                Self::count(n)
            ));
        }
        if self.coefficients.iter().any(|row| row.len() != n || !row.iter().all(|one| one.is_finite())) {
            return no(format!("a row of its `local` has not one number for each of {n} joints"));
        }
        // No comparison with a number that is none is true.
        let sound = |[low, high, fade]: &[f64; 3]| {
            low < high && *fade > 0.0 && [low, high, fade].into_iter().all(|x| x.is_finite())
        };
        if !self.range.iter().all(sound) {
            return no("a row of its `local_range` is not lowest, highest and a width > 0".to_owned());
        }
        let steepest = self.steepest();
        if steepest <= Self::STEEPEST {
            return Ok(());
        }
        no(format!(
            "its `local` may change by {steepest:.3} for a unit of a joint, more than {}",
            Self::STEEPEST
        ))
    }

    /// A bound of how much any joint's correction changes where all joints move by a unit. With `|c|` of a joint's coefficients, `|f|^2 = 2 N - 1`, and at most 3 for
    /// a slope by one joint; a product of at most 8 fading weights changes by at most 4.2 over the narrowest width.
    #[must_use]
    pub fn steepest(&self) -> f64 {
        let n = self.range.len();
        let slopes = self.range.iter().zip(&self.kinds).map(|(range, kind)| slope(*kind, range)).sum::<f64>();
        let narrowest = self.range.iter().map(|[_, _, fade]| *fade).fold(f64::INFINITY, f64::min);
        let most = 3.0_f64.sqrt() * slopes + (2.0 * n as f64 - 1.0).sqrt() * 4.2 / narrowest;
        let norm = |joint: usize| self.coefficients.iter().map(|row| row[joint].powi(2)).sum::<f64>().sqrt();
        (0..n).map(|joint| norm(joint) * most).fold(0.0, f64::max)
    }

    /// The functions at `q`, written to `out`.
    ///
    /// `out` has [`LocalCorrection::count`] places.
    pub fn functions(&self, q: &[f64], out: &mut [f64]) {
        let n = self.range.len();
        let turn = |j: usize| angle(self.kinds[j], &self.range[j], q[j]).sin_cos();
        let mut before = (0.0, 0.0);
        for j in 0..n {
            let (s, c) = turn(j);
            out[2 * j] = c;
            out[2 * j + 1] = s;
            if j > 0 {
                let (sb, cb) = before;
                let at = 2 * n + 4 * (j - 1);
                out[at..at + 4].copy_from_slice(&[cb * c, cb * s, sb * c, sb * s]);
            }
            before = (s, c);
        }
    }

    /// How much of the correction counts at `q`: 1 where it was measured, 0 far from there.
    #[must_use]
    pub fn weight(&self, q: &[f64]) -> f64 {
        self.range.iter().zip(q).map(|(range, q)| fading(range, *q).0).product()
    }

    /// What the joints are off by at `q` [rad or m]; it allocates.
    #[must_use]
    pub fn at(&self, q: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.coefficients.len()];
        self.functions(q, &mut values);
        let weight = self.weight(q);
        let one = |j: usize| {
            weight * self.coefficients.iter().zip(&values).map(|(row, value)| row[j] * value).sum::<f64>()
        };
        (0..self.range.len()).map(one).collect()
    }
}

fn angle(kind: JointKind, [low, high, _]: &[f64; 3], q: f64) -> f64 {
    match kind {
        JointKind::Revolute => q,
        JointKind::Prismatic => (q - 0.5 * (low + high)) / (0.5 * (high - low)),
    }
}

/// How much the angle changes for a unit of the joint.
fn slope(kind: JointKind, [low, high, _]: &[f64; 3]) -> f64 {
    match kind {
        JointKind::Revolute => 1.0,
        JointKind::Prismatic => 2.0 / (high - low),
    }
}

/// A joint's part of the weight, and its slope.
fn fading([low, high, fade]: &[f64; 3], q: f64) -> (f64, f64) {
    let (beyond, sign) = if q > *high { (q - high, 1.0) } else { (low - q, -1.0) };
    let s = beyond / fade;
    if s <= 0.0 {
        return (1.0, 0.0);
    }
    if s >= 1.0 {
        return (0.0, 0.0);
    }
    let square = s * s;
    let weight = 1.0 - square * s * (10.0 - 15.0 * s + 6.0 * square);
    (weight, -sign * 30.0 * square * (1.0 - s) * (1.0 - s) / fade)
}

/// The same for an arm of `N` joints, in a step: no allocation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Local<const N: usize> {
    range: [[f64; 3]; N],
    kinds: [JointKind; N],
    coefficients: Vec<SVector<f64, N>>,
}

impl<const N: usize> Local<N> {
    /// # Errors
    /// [`NoCalibration`], as [`LocalCorrection::check`], or of an arm with other joints.
    pub(super) fn of(
        file: &LocalCorrection,
        kind: impl Fn(usize) -> JointKind,
    ) -> Result<Self, NoCalibration> {
        file.check()?;
        let joints = file.range.len();
        let same = joints == N && file.kinds.iter().enumerate().all(|(j, own)| *own == kind(j));
        if !same {
            return Err(NoCalibration(format!("its `local` is of another arm with {joints} joints")));
        }
        Ok(Self {
            range: core::array::from_fn(|j| file.range[j]),
            kinds: core::array::from_fn(|j| file.kinds[j]),
            coefficients: file.coefficients.iter().map(|row| SVector::from_fn(|j, _| row[j])).collect(),
        })
    }

    /// `d(q)`, and its derivative if that is wanted.
    fn evaluate(
        &self,
        q: &SVector<f64, N>,
        mut derivative: Option<&mut SMatrix<f64, N, N>>,
    ) -> SVector<f64, N> {
        let mut sum = SVector::zeros();
        let (mut weight, mut turns) = (1.0, [(0.0, 0.0, 0.0); N]);
        for j in 0..N {
            weight *= fading(&self.range[j], q[j]).0;
            let (s, c) = angle(self.kinds[j], &self.range[j], q[j]).sin_cos();
            turns[j] = (s, c, slope(self.kinds[j], &self.range[j]));
        }
        if let Some(derivative) = derivative.as_deref_mut() {
            derivative.fill(0.0);
        }
        if weight == 0.0 {
            return sum;
        }
        let mut rows = self.coefficients.iter();
        let mut add = |value: f64, slopes: &[(usize, f64)]| {
            let Some(row) = rows.next() else { return };
            sum += row * value;
            if let Some(derivative) = derivative.as_deref_mut() {
                for (joint, slope) in slopes {
                    let mut column = derivative.column_mut(*joint);
                    column += row * (weight * slope);
                }
            }
        };
        for (j, (s, c, k)) in turns.into_iter().enumerate() {
            add(c, &[(j, -s * k)]);
            add(s, &[(j, c * k)]);
        }
        for j in 1..N {
            let ((sa, ca, ka), (sb, cb, kb)) = (turns[j - 1], turns[j]);
            let i = j - 1;
            add(ca * cb, &[(i, -sa * cb * ka), (j, -ca * sb * kb)]);
            add(ca * sb, &[(i, -sa * sb * ka), (j, ca * cb * kb)]);
            add(sa * cb, &[(i, ca * cb * ka), (j, -sa * sb * kb)]);
            add(sa * sb, &[(i, ca * sb * ka), (j, sa * cb * kb)]);
        }
        if let Some(derivative) = derivative {
            for j in 0..N {
                let (own, slope) = fading(&self.range[j], q[j]);
                if slope != 0.0 {
                    let mut column = derivative.column_mut(j);
                    column += sum * (weight / own * slope);
                }
            }
        }
        sum * weight
    }

    /// Where the joints stand when their encoders read `q`.
    pub(super) fn stand(&self, q: &SVector<f64, N>) -> SVector<f64, N> {
        q + self.evaluate(q, None)
    }

    /// The same, and how that changes with `q`.
    pub(super) fn stand_with_slope(&self, q: &SVector<f64, N>) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
        let mut slope = SMatrix::zeros();
        let off = self.evaluate(q, Some(&mut slope));
        (q + off, slope + SMatrix::identity())
    }

    /// What encoders read when the joints stand at `p`.
    pub(super) fn read(&self, p: &SVector<f64, N>) -> SVector<f64, N> {
        let mut q = *p;
        for _ in 0..ROUNDS {
            let next = p - self.evaluate(&q, None);
            let moved = (next - q).amax();
            q = next;
            if moved < NEAR {
                break;
            }
        }
        q
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn local() -> LocalCorrection {
        let wave = |k: usize, j: usize| 2e-5 * ((k * 3 + j) as f64 * 1.3).sin();
        LocalCorrection {
            range: vec![[-1.0, 1.0, 0.3], [-0.5, 0.9, 0.2], [0.1, 0.4, 0.1]],
            kinds: vec![JointKind::Revolute, JointKind::Revolute, JointKind::Prismatic],
            coefficients: (0..LocalCorrection::count(3))
                .map(|k| (0..3).map(|j| wave(k, j)).collect())
                .collect(),
        }
    }

    fn arm(file: &LocalCorrection) -> Local<3> {
        Local::of(file, |j| file.kinds[j]).expect("sound")
    }

    fn postures() -> impl Iterator<Item = SVector<f64, 3>> {
        (0..400).map(|i| SVector::from_fn(|j, _| 1.3 * (f64::from(i) * 0.71 + j as f64 * 2.3).sin()))
    }

    #[test]
    fn what_an_arm_does_in_a_step_is_what_the_file_says_and_is_undone() {
        let file = local();
        let arm = arm(&file);
        for q in postures() {
            let stands = arm.stand(&q);
            let expected = SVector::<f64, 3>::from_vec(file.at(q.as_slice())) + q;
            assert!((stands - expected).amax() < 1e-15);
            assert!((arm.read(&stands) - q).amax() < 1e-13);
        }
    }

    #[test]
    fn its_slope_is_that_of_differences_and_within_its_bound() {
        let file = local();
        let (arm, bound) = (arm(&file), file.steepest());
        assert!(bound < LocalCorrection::STEEPEST, "{bound}");
        for q in postures() {
            let (_, slope) = arm.stand_with_slope(&q);
            for j in 0..3 {
                let h = SVector::<f64, 3>::ith(j, 1e-5);
                let expected = (arm.stand(&(q + h)) - arm.stand(&(q - h))) / 2e-5;
                assert!((slope.column(j) - expected).amax() < 1e-8, "{q} {slope}");
            }
            let change = slope - SMatrix::identity();
            assert!(change.row_iter().all(|row| row.iter().map(|x| x.abs()).sum::<f64>() <= bound));
        }
    }

    #[test]
    fn it_fades_smoothly_and_is_nothing_beyond() {
        let file = local();
        assert_eq!(file.weight(&[0.0, 0.0, 0.2]), 1.0);
        assert_eq!(file.weight(&[1.0, -0.5, 0.4]), 1.0);
        assert!((file.weight(&[1.15, 0.0, 0.2]) - 0.5).abs() < 1e-12);
        assert_eq!(file.at(&[1.31, 0.0, 0.2]), [0.0; 3]);
        let beyond = SVector::from([0.0, -0.75, 0.2]);
        assert_eq!(arm(&file).stand(&beyond), beyond);
    }

    #[test]
    fn fault_186_a_local_correction_that_is_none_is_refused() {
        let with = |change: fn(&mut LocalCorrection)| {
            let mut file = local();
            change(&mut file);
            file.check().expect_err("unsound").to_string()
        };
        assert!(with(|file| file.coefficients.truncate(13)).contains("13 rows, of 3 joints there are 14"));
        assert!(
            with(|file| file.coefficients[2].truncate(2)).contains("not one number for each of 3 joints")
        );
        assert!(with(|file| file.range[1] = [0.5, 0.5, 0.1]).contains("`local_range`"));
        assert!(with(|file| file.range[1][2] = 0.0).contains("`local_range`"));
        assert!(with(|file| file.coefficients[0][0] = 0.1).contains("more than 0.05"));
        assert!(with(|file| file.coefficients[0][0] = f64::NAN).contains("not one number"));
        assert!(Local::<2>::of(&local(), |_| JointKind::Revolute).is_err());
    }
}
