//! Inverse kinematics of the arm in closed form, with joint 7 as the redundancy.
//!
//! In: a pose of the flange in the base, and joint 7. Out: all joint positions that have it, at most eight. With joint 7 fixed the
//! pose gives axis 6 and the wrist W, where axes 5 and 6 meet; the shoulder S, where axes 1 to 3 meet, is fixed. Frames are those of the
//! [chain](crate::Fr3); a is the offset of the elbow, l and k are the lengths of upper arm and forearm:
//!
//! ```text
//! R_6 = R_7 R_z(-q7) R_x(-90°)           W = p_7 - 0.088 x_6
//! W - S = A + B                          A = a x_3 + l z_3,  B = -a x_4 + k y_4,  x_4 = c4 x_3 + s4 z_3,  y_4 = -s4 x_3 + c4 z_3
//! |W - S|² = |A|² + |B|² + 2 (P c4 + Q s4)         P = l k - a²,  Q = -a (l + k)          two q4
//! z_5 = y_4 = s6 x_6 + c6 y_6            z_5 · (W - S) is known from q4                   two q6
//! y_5 = -z_6 = -s5 x_4 - c5 z_4          R_3 = R_z(q1) R_y(q2) R_z(q3)                    two q2
//! ```
//!
//! With joint 7 as parameter after He and Liu, *Analytical inverse kinematics for Franka Emika Panda* (2021).

use core::f64::consts::{FRAC_PI_2, TAU};

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::rejoining::Joints;

/// Height of the shoulder above the base, lengths of the upper arm and the forearm, offset of the elbow, of axis 7 from axis 6,
/// and of the flange from the wrist along axis 7 \[m\].
pub const SHOULDER: f64 = 0.333;
pub const UPPER_ARM: f64 = 0.316;
pub const FOREARM: f64 = 0.384;
pub const ELBOW: f64 = 0.0825;
pub const WRIST: f64 = 0.088;
pub const FLANGE: f64 = 0.107;

/// Below this sine of joint 2, joints 1 and 3 turn about one axis; below this \[m\], axis 5 goes through the shoulder.
const SINGULAR: f64 = 1e-9;

/// What round-off may leave beyond 1 of a cosine.
const ROUND_OFF: f64 = 1e-12;

/// The angle \[rad\] of a cosine, if there is one.
fn arc(cosine: f64) -> Option<f64> {
    (cosine.abs() <= 1.0 + ROUND_OFF).then(|| cosine.clamp(-1.0, 1.0).acos())
}

/// The angle turned as near to another as full turns allow \[rad\].
fn closest(angle: f64, near: f64) -> f64 {
    angle + TAU * ((near - angle) / TAU).round()
}

/// Calls `visit` with every solution for the flange at `X_BF` in the base with joint 7 at `q7` \[rad\]; other joints are turned as
/// near to `near` as full turns allow.
///
/// # Errors
/// There is none with this joint 7; then `visit` has not been called.
#[allow(non_snake_case, clippy::many_single_char_names)]
pub fn solutions(
    X_BF: &Pose,
    q7: f64,
    near: &Joints,
    visit: &mut dyn FnMut(&Joints),
) -> Result<(), NoInverse> {
    let turned = |axis: Vector3<f64>| *Rotation3::from_scaled_axis(axis).matrix();
    let R_7: Matrix3<f64> = *X_BF.rotation.to_rotation_matrix().matrix();
    let R_6 = R_7 * turned(Vector3::z() * -q7) * turned(Vector3::x() * -FRAC_PI_2);
    let [x_6, y_6, z_6] = [0, 1, 2].map(|i| R_6.column(i).into_owned());
    let wrist = X_BF.translation.vector - R_7.column(2) * FLANGE - x_6 * WRIST;
    let w = wrist - Vector3::z() * SHOULDER;
    let (a, l, k) = (ELBOW, UPPER_ARM, FOREARM);
    let squares = 2.0 * a * a + l * l + k * k;
    let (P, Q) = (l * k - a * a, -a * (l + k));
    let most = P.hypot(Q);
    let out_of_reach = || {
        let reach = |sign: f64| (squares + sign * 2.0 * most).max(0.0).sqrt();
        NoInverse::OutOfReach { distance: w.norm(), min: reach(-1.0), max: reach(1.0) }
    };
    let bent = arc((0.5 * (w.norm_squared() - squares)) / most).ok_or_else(out_of_reach)?;
    let mut worst = 1.0_f64;
    let mut found = false;
    for q4 in [Q.atan2(P) - bent, Q.atan2(P) + bent] {
        let (s4, c4) = q4.sin_cos();
        // W - S along x_3 and z_3, and across the forearm.
        let (x, z) = (a - a * c4 - k * s4, l - a * s4 + k * c4);
        let across = x * c4 + z * s4;
        let (along, size) = (z * c4 - x * s4, w.dot(&x_6).hypot(w.dot(&y_6)));
        let Some(aside) = arc(along / size).filter(|_| across.abs() > SINGULAR) else {
            worst = worst.max((along / size).abs());
            continue;
        };
        for aside in [aside, -aside] {
            let angle = w.dot(&y_6).atan2(w.dot(&x_6)) + aside;
            let (s, c) = angle.sin_cos();
            let z_5 = x_6 * c + y_6 * s;
            let x_3 = (w * c4 - z_5 * z) / across;
            let z_3 = (w * s4 + z_5 * x) / across;
            let y_3 = z_3.cross(&x_3);
            let x_4 = x_3 * c4 + z_3 * s4;
            let (q5, q6) = (z_6.dot(&x_4).atan2(-z_6.dot(&y_3)), c.atan2(s));
            let sine = z_3.x.hypot(z_3.y);
            for side in [1.0, -1.0] {
                let q2 = side * sine.atan2(z_3.z);
                let [q1, q3] = if sine > SINGULAR {
                    [(side * z_3.y).atan2(side * z_3.x), (side * y_3.z).atan2(-side * x_3.z)]
                } else {
                    // Both turn about one axis: joint 1 stays.
                    let turn = if z_3.z > 0.0 { x_3.y.atan2(x_3.x) } else { (-x_3.y).atan2(-x_3.x) };
                    let sum = if z_3.z > 0.0 { turn - near[0] } else { near[0] - turn };
                    [near[0], sum]
                };
                let q = [q1, q2, q3, q4, q5, q6];
                let q = Joints::from_fn(|i, _| if i == 6 { q7 } else { closest(q[i], near[i]) });
                found = true;
                visit(&q);
            }
        }
    }
    if found {
        return Ok(());
    }
    if worst <= 1.0 + ROUND_OFF {
        return Err(NoInverse::Singular { name: "forearm through shoulder" });
    }
    let what = "cosine between forearm and axis 6 with this joint 7";
    Err(NoInverse::NotAttainable { what, actual: worst, tolerance: 1.0, unit: "" })
}
