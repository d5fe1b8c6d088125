//! Where a camera is, on a flange or beside an arm, from what it sees of a board: the pixels of its corners.
//!
//! In: poses of the flange as a controller tells them, each with where the camera saw the corners. Out: the camera's place with standard deviations. The start is
//! that of [`hand_eye`](crate::hand_eye), from poses of the board; then pixels count, as the camera has them.

use mrroc::pose::Pose;
use mrroc_sensors::aggregation::Pattern;
use mrroc_sensors::camera::Camera;
use nalgebra::Vector2;

use crate::device::Device;
use crate::fit::NoFit;
use crate::hand::{InHand, PoseArm, hand_eye, in_hand, posture, unsure};
use crate::intrinsics::board_in_camera;
use crate::known::{CAMERA, CAMERA_TURN, SEEING_PIXELS};
use crate::least_squares::Settings;
use crate::pixels::Pixels;
use crate::problem::{Freedom, Noise, Problem};

/// What is left of corners at most, where a board of another size explains them \[pixel\].
const FITS: f64 = 2.0;

/// Where a camera is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Eye {
    /// On the flange; the board is fixed in the world.
    OnFlange,
    /// Fixed in the world; the board is on the flange.
    Fixed,
}

/// What a camera saw in one posture.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Where the flange was, in the arm's base.
    pub flange: Pose,
    /// Where the corners were seen \[pixel\], in the order of [`Pattern::points`].
    pub corners: Vec<Vector2<f64>>,
}

/// Where the camera is: on the flange, or in the arm's base. What is left are pixels. The camera counts as known: what its own calibration is unsure of is
/// not in the standard deviations.
///
/// # Errors
/// [`NoFit`].
pub fn eye(camera: &Camera, board: impl Into<Pattern>, mounted: Eye, seen: &[Seen]) -> Result<InHand, NoFit> {
    found(camera, &board.into(), mounted, seen, true)
}

/// The same, or without an estimate of how well it is known, which takes a second fit.
fn found(
    camera: &Camera,
    board: &Pattern,
    mounted: Eye,
    seen: &[Seen],
    is_evaluated: bool,
) -> Result<InHand, NoFit> {
    let boards: Option<Vec<Pose>> =
        seen.iter().map(|one| board_in_camera(camera, board, &one.corners)).collect();
    let boards = boards.ok_or(NoFit::Empty)?;
    // A camera beside the arm is one on the flange to who stands there.
    let flange = |one: &Seen| match mounted {
        Eye::OnFlange => one.flange,
        Eye::Fixed => one.flange.inverse(),
    };
    let pairs: Vec<(Pose, Pose)> = seen.iter().map(flange).zip(boards).collect();
    let start = hand_eye(&pairs)?.frame;
    let (first, in_camera) = pairs.first().ok_or(NoFit::Empty)?;
    let device = Pixels::of(*camera, board.points());
    let fitted = |noise: f64, is_known: bool| {
        let mut problem = Problem::new();
        let arm = problem.arm("arm", PoseArm, Pose::identity(), Freedom::FIXED);
        let target = problem.target("board", None, *first * start * in_camera, Freedom::FRAME);
        let noise = vec![noise; device.readings()];
        let noise = if is_known { Noise::Known(noise) } else { Noise::Unknown(noise) };
        let id = problem.instrument("camera", device.clone(), Some(arm), start, Freedom::FRAME, noise);
        for (one, (flange, _)) in seen.iter().zip(&pairs) {
            let posture = posture(&mut problem, arm, flange);
            let read: Vec<f64> = one.corners.iter().flat_map(|at| [at.x, at.y]).collect();
            problem.measure(id, target, &[posture], &read);
        }
        let fit = problem.fit(&Settings { tolerance: 1e-12, ..Settings::default() })?;
        let noise = fit.noise(id).first().copied().unwrap_or(0.0);
        Ok::<_, NoFit>((fit.frame(problem.place_of(id)), noise, fit))
    };
    let (frame, noise, fit) = fitted(0.5, false)?;
    let unsure = if is_evaluated {
        unsure(&fitted(noise.max(SEEING_PIXELS), true)?.2, "camera ", [CAMERA, CAMERA_TURN])
    } else {
        Vec::new()
    };
    let found = in_hand(&fit, frame, "camera ");
    let square = |raw: &[f64]| 2.0 * raw.iter().map(|one| one * one).sum::<f64>() / raw.len().max(1) as f64;
    let squares: Vec<f64> = fit.residuals().map(|(_, _, raw)| square(raw)).collect();
    Ok(InHand {
        left: [0.0; 2],
        pixels: Some((squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()),
        unsure,
        poses: squares.into_iter().map(|square| [square.sqrt(); 2]).collect(),
        ..found
    })
}

/// The side of a square \[m\] with which what a camera saw fits best, beside that of the board; `None` unless it is another one without doubt: more than
/// 0.1 % and five standard deviations from it, and what is left then is below 2 pixels: where nothing fits, the board is not to blame. It is looked for between 0.7 and 1.4 of what is believed.
///
/// # Errors
/// [`NoFit`].
pub fn square_seen(
    camera: &Camera,
    board: impl Into<Pattern>,
    mounted: Eye,
    seen: &[Seen],
) -> Result<Option<f64>, NoFit> {
    let board = board.into();
    let corners: usize = seen.iter().map(|one| one.corners.len()).sum();
    let left = |log: f64| -> Result<f64, NoFit> {
        let board = board.with_step(board.step() * log.exp());
        Ok(found(camera, &board, mounted, seen, false)?.pixels.unwrap_or(f64::INFINITY))
    };
    // Golden section of the logarithm of the size.
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.7_f64.ln(), 1.4_f64.ln());
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut left_a, mut left_b) = (left(a)?, left(b)?);
    while high - low > 2e-5 {
        if left_a < left_b {
            (high, b, left_b) = (b, a, left_a);
            a = high - golden * (high - low);
            left_a = left(a)?;
        } else {
            (low, a, left_a) = (a, b, left_b);
            b = low + golden * (high - low);
            left_b = left(b)?;
        }
    }
    let (log, least) = if left_a < left_b { (a, left_a) } else { (b, left_b) };
    // The sum of squares, in units of their variance, that the other size takes away.
    let squares = 2.0 * corners as f64 * ((left(0.0)? / least).powi(2) - 1.0);
    let fits = least < FITS;
    Ok((fits && log.abs() > 1e-3 && squares > 25.0).then(|| board.step() * log.exp()))
}
