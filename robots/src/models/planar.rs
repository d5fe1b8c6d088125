//! What the closed forms of arms share: angles as directions, an arm's plane about its first axis, and two links in it.

use mrroc::pose::Pose;
use nalgebra::{UnitQuaternion, Vector3};

use crate::models::sines::sin_cos;

/// Distance of the wrist centre from axis 1, or from axis 2, below which these joints are undetermined \[m\].
pub(crate) const CENTRE_SINGULAR: f64 = 1e-9;

/// Sine of the middle angle of a wrist (or of a shoulder) below which the two beside it are undetermined; the pose then errs
/// by no more than this \[rad\].
pub(crate) const WRIST_SINGULAR: f64 = 1e-10;

/// How far beyond its reach an arm may be asked to stretch, as a part of its length: round-off.
pub(crate) const STRETCH: f64 = 1e-13;

/// Largest round-off of the cosine of an angle between two directions.
pub(crate) const ROUND_OFF: f64 = 1e-14;

/// Sine of an angle, or part of the arm's length, below which a singularity counts as near.
pub(crate) const NEAR: f64 = 0.1;

/// An angle as a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Direction {
    pub(crate) sine: f64,
    pub(crate) cosine: f64,
}

impl Direction {
    #[inline(always)]
    pub(crate) fn of(angle: f64) -> Self {
        let [(sine, cosine)] = sin_cos([angle]);
        Self { sine, cosine }
    }

    /// Cosine of the angle between two directions.
    #[inline(always)]
    pub(crate) fn along(self, other: Self) -> f64 {
        self.cosine * other.cosine + self.sine * other.sine
    }

    /// The direction half a turn away.
    #[inline(always)]
    pub(crate) fn reversed(self) -> Self {
        Self { sine: -self.sine, cosine: -self.cosine }
    }
}

/// One position of the first joint.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Shoulder {
    pub(crate) theta1: Direction,
    /// How far the wrist centre lies in front of axis 1 in the plane of the arm \[m\], of either sign.
    pub(crate) forward: f64,
}

/// One position of the upper arm and the forearm.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Elbow {
    pub(crate) phi2: Direction,
    pub(crate) phi3: Direction,
}

/// The lengths of two links in a plane: from axis 2 to axis 3 and from there to the end \[m\], both > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Links {
    pub(crate) l: f64,
    pub(crate) k: f64,
}

/// The demanded pose of the wrist, in O.
pub(crate) struct Wanted {
    /// The wrist centre \[m\].
    pub(crate) centre: Vector3<f64>,
    /// The columns of the rotation matrix of C.
    pub(crate) columns: [Vector3<f64>; 3],
}

impl Wanted {
    /// The pose of the wrist's frame C that puts the flange at `X_WF`, in O, which stands at `X_WO`; the flange's rotation and
    /// origin in C are `R_CF` and `p_CF` \[m\].
    #[inline(always)]
    #[allow(non_snake_case)]
    pub(crate) fn of(X_WF: &Pose, X_WO: &Pose, R_CF: &UnitQuaternion<f64>, p_CF: &Vector3<f64>) -> Self {
        let R_OW = X_WO.rotation.inverse();
        let R_OC = R_OW * X_WF.rotation * R_CF.inverse();
        let p_OF = R_OW * (X_WF.translation.vector - X_WO.translation.vector);
        let matrix = R_OC.to_rotation_matrix().into_inner();
        let columns = [0, 1, 2].map(|i| Vector3::new(matrix[(0, i)], matrix[(1, i)], matrix[(2, i)]));
        Self { centre: p_OF - matrix * p_CF, columns }
    }
}

/// Both positions of the first joint for a `centre` that keeps `b` \[m\] beside the arm's plane. On axis 1 the joint is
/// undetermined and stays at `at`; `None` where the centre is nearer to axis 1 than that. `size`: the arm's length \[m\].
#[inline(always)]
pub(crate) fn shoulders(centre: &Vector3<f64>, b: f64, size: f64, at: Direction) -> Option<[Shoulder; 2]> {
    let (x, y) = (centre.x, centre.y);
    let square = x * x + y * y;
    let under_root = square - b * b;
    if under_root.is_nan() || under_root < -STRETCH * size * size {
        return None;
    }
    if square < CENTRE_SINGULAR * CENTRE_SINGULAR {
        return Some([Shoulder { theta1: at, forward: x * at.cosine + y * at.sine }; 2]);
    }
    let root = under_root.max(0.0).sqrt();
    let inverse = 1.0 / square;
    let shoulder = |forward: f64| Shoulder {
        theta1: Direction { sine: (forward * y - b * x) * inverse, cosine: (forward * x + b * y) * inverse },
        forward,
    };
    Some([shoulder(root), shoulder(-root)])
}

/// Both positions of two links whose end lies `across` and `height` \[m\] from axis 2; with the end on axis 2 the upper arm
/// is undetermined and stays at `at`; `None` out of reach.
#[inline(always)]
pub(crate) fn elbows(links: Links, across: f64, height: f64, at: Direction) -> Option<[Elbow; 2]> {
    let Links { l, k } = links;
    let square = across * across + height * height;
    let distance = square.sqrt();
    // Heron: 16 times the square of the area between upper arm, forearm and their span.
    let heron = (l + k - distance) * (l + k + distance) * (distance - l + k) * (distance + l - k);
    if heron.is_nan() || heron < -STRETCH * (l + k).powi(4) {
        return None;
    }
    let inverse_k = 1.0 / k;
    let elbow = |phi2: Direction| Elbow {
        phi2,
        phi3: Direction {
            sine: (across - l * phi2.sine) * inverse_k,
            cosine: (height - l * phi2.cosine) * inverse_k,
        },
    };
    if distance < CENTRE_SINGULAR {
        return Some([elbow(at); 2]);
    }
    let along = 0.5 * (square + (l - k) * (l + k)) / l;
    let root = 0.5 * heron.max(0.0).sqrt() / l;
    let inverse = 1.0 / square;
    let upper = |root: f64| {
        elbow(Direction {
            sine: (along * across - root * height) * inverse,
            cosine: (along * height + root * across) * inverse,
        })
    };
    Some([upper(root), upper(-root)])
}

/// The one of two whose measure is larger, then the other.
#[inline(always)]
pub(crate) fn nearer_first<T: Copy>([a, b]: [T; 2], measure: impl Fn(&T) -> f64) -> (T, T) {
    if measure(&b) > measure(&a) { (b, a) } else { (a, b) }
}

/// Both of two solutions, or one where they are the same.
pub(crate) fn distinct<T: PartialEq>(both: &[T; 2]) -> &[T] {
    if both[0] == both[1] { &both[..1] } else { both }
}
