//! What an arm has in its hand: where the tip of a tool is on the flange, and where a camera is.
//!
//! In: poses of the flange as a controller tells them, with the tip on one fixed point, or with where the camera sees a fixed board. Nothing of the arm itself must be
//! known. Out: the tip or the camera on the flange with standard deviations, what is left, and what cannot be told from these poses.

use core::fmt;

use mrroc::pose::{Pose, Rpy};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::arm::Arm;
use crate::device::{FullPose, Touch};
use crate::fit::{Fit, NoFit};
use crate::known::{
    CAMERA, CAMERA_TURN, SEEING, SEEING_TURN, TIP, TOUCHING, WRONG, WRONG_ALONE, WRONG_PIXELS, WRONG_TURN,
};
use crate::least_squares::Settings;
use crate::parameter::{Parameter, Unit};
use crate::pose_text::pose_text;
use crate::problem::{ArmId, Freedom, Noise, Problem};

/// An arm of which only poses of its flange are known: its six joint positions are x, y, z \[m\] and a rotation vector \[rad\].
#[derive(Clone, Copy, Debug, Default)]
pub struct PoseArm;

impl Arm for PoseArm {
    fn parameters(&self) -> &[Parameter] {
        &[]
    }

    fn joints(&self) -> usize {
        6
    }

    fn flange(&self, q: &[f64], _: &[f64]) -> Pose {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(q[3], q[4], q[5]));
        Pose::from_parts(Vector3::new(q[0], q[1], q[2]).into(), turn)
    }
}

/// What was found on a flange.
#[derive(Clone, Debug)]
pub struct InHand {
    /// Where it is on the flange, or in the arm's base; of a tip the position alone.
    pub frame: Pose,
    /// The standard deviations of x, y, z \[m\], and of turns about its own axes \[rad\] if they were found.
    pub sigma: Vec<f64>,
    /// Root mean squares of what is left of positions \[m\], and of orientations \[rad\].
    pub left: [f64; 2],
    /// The same of pixels, if it was found from these.
    pub pixels: Option<f64>,
    /// What these poses do not tell, by name.
    pub unseen: Vec<String>,
    /// What they tell too badly, by name, with how well; by the limits of [`known`](crate::known).
    pub unsure: Vec<String>,
    /// By pose what is left: of its position \[m\] and orientation \[rad\], or of its pixels, twice.
    pub poses: Vec<[f64; 2]>,
}

impl InHand {
    /// By what poses do not fit, if they do not.
    #[must_use]
    pub fn misfit(&self) -> Option<String> {
        let worst = |part: usize| self.poses.iter().map(|left| left[part]).fold(0.0, f64::max);
        if let Some(pixels) = self.pixels {
            let worst = worst(0);
            let is_wrong = pixels > WRONG_PIXELS || worst > WRONG_ALONE * WRONG_PIXELS;
            return is_wrong.then(|| {
                format!(
                    "{pixels:.1} px rms are left, of {WRONG_PIXELS:.0} at most, and {worst:.1} px in one pose"
                )
            });
        }
        let limits = [WRONG, WRONG_TURN];
        let is_wrong =
            (0..2).any(|part| self.left[part] > limits[part] || worst(part) > WRONG_ALONE * limits[part]);
        let [length, turn] = self.left.map(|left| 1e3 * left);
        let [most, most_turn] = limits.map(|limit| 1e3 * limit);
        let one = format!("{:.1} mm", 1e3 * worst(0));
        is_wrong.then(|| match self.sigma.len() {
        0..=3 => format!("{length:.1} mm rms are left, of {most:.0} mm at most, and {one} in one pose"),
        _ => format!(
            "{length:.1} mm and {turn:.1} mrad rms are left, of {most:.0} mm and {most_turn:.0} mrad at most, and {one} and {:.1} mrad in one pose",
            1e3 * worst(1)
        ),
    })
    }

    /// A pose in the arm's base, of what stands beside the arm.
    #[must_use]
    pub fn base_text(&self, name: &str, made: &str) -> String {
        format!(
            "# The {name} in the arm's base, found on {made}: write this into cell.toml, if the arm's base is the world.\n# m.\n\
             [frames.{name}]\n{}# Standard deviations of x, y, z, and of turns about its own axes.\n# sigma = {:?}\n",
            pose_text(&self.frame),
            self.sigma
        )
    }

    /// A pose as `cell.toml` writes it, for a table `[tools.NAME]`.
    #[must_use]
    pub fn text(&self, name: &str, made: &str) -> String {
        format!(
            "# The {name} on the flange, found on {made}: write this into a table [tools.NAME] of cell.toml.\n# m.\n\
             {}# Standard deviations of x, y, z, and of turns about its own axes if they were found.\n# sigma = {:?}\n",
            pose_text(&self.frame),
            self.sigma
        )
    }
}

impl fmt::Display for InHand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (p, turn) = (self.frame.translation.vector * 1e3, Rpy::of(&self.frame.rotation));
        let told = |f: &mut fmt::Formatter<'_>, name: &str, of: [f64; 3], sigma: &[f64], factor: f64| {
            write!(f, "{name:9} {:10.4} {:10.4} {:10.4}   known to", of[0], of[1], of[2])?;
            sigma.iter().try_for_each(|sigma| write!(f, " {:.4}", sigma * factor))?;
            writeln!(f)
        };
        told(f, "xyz [mm]", [p.x, p.y, p.z], &self.sigma[..self.sigma.len().min(3)], 1e3)?;
        if self.sigma.len() > 3 {
            told(f, "rpy [rad]", [turn.roll, turn.pitch, turn.yaw], &self.sigma[3..], 1.0)?;
        }
        if let Some(pixels) = self.pixels {
            return writeln!(f, "left: {pixels:.3} px rms");
        }
        write!(f, "left: {:.3} mm rms", 1e3 * self.left[0])?;
        if self.sigma.len() > 3 {
            write!(f, ", {:.3} mrad rms", 1e3 * self.left[1])?;
        }
        writeln!(f)
    }
}

/// The tip of a tool that was on one fixed point in all these poses of the flange.
///
/// # Errors
/// [`NoFit`].
pub fn tip(flanges: &[Pose]) -> Result<InHand, NoFit> {
    // Of the tip and the point, which both are linear in what is known, about where they are.
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let mean = |part: &dyn Fn(&Pose) -> Matrix3<f64>| -> Matrix3<f64> {
        flanges.iter().map(part).sum::<Matrix3<f64>>() / flanges.len().max(1) as f64
    };
    let turns = mean(&|flange| *flange.rotation.to_rotation_matrix().matrix());
    let places = flanges.iter().map(|flange| flange.translation.vector).sum::<Vector3<f64>>()
        / flanges.len().max(1) as f64;
    for flange in flanges {
        let turn = flange.rotation.to_rotation_matrix().matrix() - turns;
        normal += turn.transpose() * turn;
        right -= turn.transpose() * (flange.translation.vector - places);
    }
    let at = normal.pseudo_inverse(1e-6).map_or(Vector3::zeros(), |inverse| inverse * right);
    let point = turns * at + places;
    let place = Pose::translation(point.x, point.y, point.z);
    let settings = Settings { tolerance: 1e-12, ..Settings::default() };
    let fitted = |noise: Noise| {
        let mut problem = Problem::new();
        let arm = problem.arm("arm", PoseArm, Pose::identity(), Freedom::FIXED);
        let start = Pose::translation(at.x, at.y, at.z);
        let target = problem.target("tip", Some(arm), start, Freedom::POINT);
        let touched = problem.instrument("point", Touch, None, place, Freedom::POINT, noise);
        for flange in flanges {
            let posture = posture(&mut problem, arm, flange);
            problem.measure(touched, target, &[posture], &[0.0; 3]);
        }
        let fit = problem.fit(&settings)?;
        Ok::<_, NoFit>((fit.frame(problem.frame_of(target)), fit.noise(touched).to_vec(), fit))
    };
    let (frame, noise, fit) = fitted(Noise::Unknown(vec![1e-4; 3]))?;
    let (_, _, evaluated) = fitted(Noise::Known(noise.iter().map(|sigma| sigma.max(TOUCHING)).collect()))?;
    Ok(InHand { unsure: unsure(&evaluated, "tip ", [TIP, f64::INFINITY]), ..in_hand(&fit, frame, "tip ") })
}

/// A camera on the flange that sees a board fixed in the world: poses of the flange, each with where the board is in the camera.
///
/// # Errors
/// [`NoFit`].
pub fn hand_eye(seen: &[(Pose, Pose)]) -> Result<InHand, NoFit> {
    let settings = Settings { tolerance: 1e-12, ..Settings::default() };
    let fitted = |noise: Noise| {
        let mut problem = Problem::new();
        let arm = problem.arm("arm", PoseArm, Pose::identity(), Freedom::FIXED);
        let board = problem.target("board", None, Pose::identity(), Freedom::FRAME);
        let camera =
            problem.instrument("camera", FullPose::new(), Some(arm), Pose::identity(), Freedom::FRAME, noise);
        for (flange, board_in_camera) in seen {
            let posture = posture(&mut problem, arm, flange);
            let (p, q) = (board_in_camera.translation.vector, board_in_camera.rotation.quaternion());
            problem.measure(camera, board, &[posture], &[p.x, p.y, p.z, q.w, q.i, q.j, q.k]);
        }
        problem.find_start(camera)?;
        let fit = problem.fit(&settings)?;
        Ok::<_, NoFit>((fit.frame(problem.place_of(camera)), fit.noise(camera).to_vec(), fit))
    };
    let (frame, noise, fit) = fitted(Noise::Unknown(vec![1e-3, 1e-3, 1e-3, 2e-3, 2e-3, 2e-3]))?;
    let floors = [SEEING, SEEING, SEEING, SEEING_TURN, SEEING_TURN, SEEING_TURN];
    let noise = noise.iter().zip(floors).map(|(sigma, floor)| sigma.max(floor)).collect();
    let (_, _, evaluated) = fitted(Noise::Known(noise))?;
    let unsure = unsure(&evaluated, "camera ", [CAMERA, CAMERA_TURN]);
    Ok(InHand { unsure, ..in_hand(&fit, frame, "camera ") })
}

/// What was found less well than to these standard deviations \[m, rad\].
pub(crate) fn unsure(fit: &Fit, name: &str, limits: [f64; 2]) -> Vec<String> {
    let told = |found: crate::FoundParameter| {
        let limit = if found.parameter.unit == Unit::Metre { limits[0] } else { limits[1] };
        let (unit, factor) = found.parameter.unit.shown();
        let (sigma, most) = (factor * found.sigma, factor * limit);
        let sure = found.sigma <= limit;
        (!sure).then(|| {
            format!(
                "{} is known to {sigma:.1} {unit} only, of {most:.0} {unit} at most",
                found.parameter.name
            )
        })
    };
    fit.found().filter(|found| found.parameter.name.starts_with(name)).filter_map(told).collect()
}

/// How the hand was turned between poses: by how much at most \[rad\], and, beside the axis about which it was turned most, by how much about others.
#[must_use]
pub fn turned(flanges: &[Pose]) -> [f64; 2] {
    let mut spread = Matrix3::zeros();
    let (mut most, mut count) = (0.0_f64, 0.0_f64);
    for (i, a) in flanges.iter().enumerate() {
        for b in &flanges[..i] {
            let turn = a.rotation.rotation_to(&b.rotation).scaled_axis();
            most = most.max(turn.norm());
            spread += turn * turn.transpose();
            count += 1.0;
        }
    }
    let mut squares: Vec<f64> = spread.symmetric_eigenvalues().iter().copied().collect();
    squares.sort_by(|a, b| b.total_cmp(a));
    [most, (squares[1].max(0.0) / count.max(1.0)).sqrt()]
}

pub(crate) fn posture(problem: &mut Problem, arm: ArmId, flange: &Pose) -> crate::PostureId {
    let (p, v) = (flange.translation.vector, flange.rotation.scaled_axis());
    problem.posture(arm, &[p.x, p.y, p.z, v.x, v.y, v.z])
}

pub(crate) fn in_hand(fit: &Fit, frame: Pose, name: &str) -> InHand {
    let mut sums = [(0.0, 0.0_f64); 2];
    let mut poses = Vec::new();
    for (_, _, raw) in fit.residuals() {
        let norm = |part: Option<&[f64]>| {
            part.map_or(0.0, |part| part.iter().map(|one| one * one).sum::<f64>().sqrt())
        };
        let mut parts = raw.chunks(3);
        poses.push([norm(parts.next()), norm(parts.next())]);
        for (sum, part) in sums.iter_mut().zip(raw.chunks(3)) {
            sum.0 += part.iter().map(|one| one * one).sum::<f64>();
            sum.1 += 1.0;
        }
    }
    let found = fit.found().filter(|one| one.parameter.name.starts_with(name));
    InHand {
        frame,
        sigma: found.map(|one| one.sigma).collect(),
        left: sums.map(|(sum, count)| (sum / count.max(1.0)).sqrt()),
        pixels: None,
        unseen: fit.unseen().iter().map(ToString::to_string).collect(),
        unsure: Vec::new(),
        poses,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flanges() -> Vec<Pose> {
        // Turns about several axes, with the tip where `tip_at` has it.
        let turns = [
            [3.1, 0.0, 0.0],
            [2.7, 0.4, 0.1],
            [2.8, -0.5, 0.2],
            [2.9, 0.2, -0.6],
            [2.6, 0.1, 0.5],
            [2.9, -0.2, 0.9],
        ];
        turns.map(|turn| Pose::new(Vector3::zeros(), Vector3::from(turn))).to_vec()
    }

    #[test]
    fn a_tip_is_where_one_point_was_touched_from() {
        let (tool, point) = (Vector3::new(0.02, -0.01, 0.18), Vector3::new(0.7, 0.1, 0.2));
        let touching =
            |flange: &Pose| Pose::from_parts((point - flange.rotation * tool).into(), flange.rotation);
        let all: Vec<Pose> = flanges().iter().map(touching).collect();
        let found = tip(&all).expect("a tip");
        assert!((found.frame.translation.vector - tool).norm() < 1e-9, "{found:?}");
        assert!(found.unseen.is_empty() && found.left[0] < 1e-9, "{found:?}");
        // Only turned about z of the flange: how far along it the tip is cannot be told.
        let turned = |i: i32| touching(&Pose::new(Vector3::zeros(), Vector3::z() * (0.5 * f64::from(i))));
        let found = tip(&(0..4).map(turned).collect::<Vec<_>>()).expect("a tip");
        assert_eq!(found.unseen.len(), 1, "{found:?}");
        assert!(found.unseen[0].contains("tip z"), "{found:?}");
    }

    #[test]
    fn a_camera_is_where_a_board_was_seen_from() {
        let camera = Pose::new(Vector3::new(0.05, 0.0, 0.06), Vector3::new(0.1, -0.2, 1.5));
        let board = Pose::new(Vector3::new(0.8, -0.1, 0.0), Vector3::new(0.0, 0.1, 0.4));
        let places = flanges().into_iter().enumerate();
        let seen: Vec<(Pose, Pose)> = places
            .map(|(i, flange)| {
                let at = Vector3::new(0.6 + 0.05 * i as f64, 0.03 * i as f64, 0.5 - 0.04 * i as f64);
                let flange = Pose::from_parts(at.into(), flange.rotation);
                (flange, (flange * camera).inv_mul(&board))
            })
            .collect();
        let found = hand_eye(&seen).expect("a camera");
        let off = camera.inv_mul(&found.frame);
        assert!(off.translation.vector.norm() < 1e-7 && off.rotation.angle() < 1e-7, "{off}");
        assert_eq!(found.sigma.len(), 6);
    }
}
