//! Moves the tool to a place in a frame that a sensor reports, and on with that frame.

use core::marker::PhantomData;

use mrroc::fault::FaultKind;
use mrroc::prelude::*;

use mrroc_generators::cooperation::{TrackedFrame, Tracking};
use mrroc_generators::line::LinePath;

/// Moves the tool onto `X_WF X_FG` and keeps it there. The frame F moves by itself, such as a part on a conveyor.
/// Readings tell where it was; a [`TrackedFrame`] computes from them where it is. The approach is that of
/// [`MovingFrame`](super::MovingFrame) and begins with the first reading; until then the tool holds.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::sensor::SensorImage;
/// use mrroc_generators::cooperation::{Displacement, Tracking};
/// use mrroc_generators::generators::FollowedFrame;
/// use mrroc_generators::rehearsal::rehearse_with;
/// use mrroc_robots::Irp6;
///
/// # struct Camera;
/// # impl Sensor for Camera {
/// #     const KIND: &'static str = "camera";
/// #     type Reading = Displacement;
/// #     type Configuration = ();
/// # }
/// let irp6 = Irp6::nominal();
/// // A part that moves along y at 0.05 m/s; 5 cm above it after 1 s, and with it until 1.5 s have passed.
/// let mut part = irp6.forward(&Irp6::READY) * Pose::translation(0.0, 0.0, 0.1);
/// let how = Tracking { rate: 15.0, acceleration: 1.0, turning: 5.0 };
/// let above = Pose::translation(0.0, 0.0, -0.05);
/// let follow = FollowedFrame::<Irp6, Camera>::to(|seen| Some(seen.pose), above, how, 1.0, 1.5, 1);
/// let demands = rehearse_with(follow, &irp6, Irp6::READY, 0.002, |_| {
///     part.translation.y += 0.05 * 0.002;
///     (Order::new(()), Reading::new((SensorImage::new(Displacement { pose: part }, 0),)))
/// })?;
/// assert_eq!(demands.len(), 750);
/// let end = demands.last().and_then(Demand::as_pose);
/// // The part has moved on by 0.1 mm in the step that ended the motion.
/// let off = end.map(|end| (end.translation.vector - (part * above).translation.vector).norm());
/// assert!(off.is_some_and(|off| off < 1.01e-4), "{off:?}");
/// # Ok::<(), Fault>(())
/// ```
pub struct FollowedFrame<R, S: Sensor> {
    see: fn(&S::Reading) -> Option<Pose>,
    place: Pose,
    how: Tracking,
    frame: TrackedFrame,
    approach: f64,
    duration: f64,
    oldest: u32,
    start: Pose,
    age: f64,
    of: PhantomData<R>,
}

impl<R: Robot, S: Sensor> FollowedFrame<R, S> {
    /// To `X_FG` in the frame that `see` finds in a reading (`X_WF`, as it was when the reading was taken), followed as `how`
    /// says, within `approach` \[s\], > 0, and with it until `duration` \[s\], >= `approach`, has passed. Readings may be `oldest`
    /// steps old.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn to(
        see: fn(&S::Reading) -> Option<Pose>,
        X_FG: Pose,
        how: Tracking,
        approach: f64,
        duration: f64,
        oldest: u32,
    ) -> Self {
        let (frame, start, age) = (TrackedFrame::new(how), Pose::identity(), 0.0);
        FollowedFrame {
            see,
            place: X_FG,
            how,
            frame,
            approach,
            duration,
            oldest,
            start,
            age,
            of: PhantomData,
        }
    }
}

#[generator(ecp)]
impl<R: Robot, S: Sensor> FollowedFrame<R, S> {
    fn first_step(&mut self, e: &State<R>, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        let all = [self.how.rate, self.how.acceleration, self.how.turning, self.approach, self.duration];
        if !all.iter().all(|x| x.is_finite() && *x > 0.0) || self.approach > self.duration {
            return Err(Fault::thrown(
                "rate, accelerations, approach and duration of following a frame must be finite and > 0, the approach no longer than the motion",
            ));
        }
        self.start = e.demanded().pose;
        self.next_step(v, t)
    }

    #[allow(non_snake_case)]
    fn next_step(&mut self, v: &Reading<(S,)>, t: Tick) -> Result<Step<R>, Fault> {
        // The exact end is demanded once; rounding must not cost a step.
        if self.age >= self.duration {
            return Ok(Step::Done);
        }
        let reading = v.0.reading();
        let age = v.0.age();
        if reading.is_some() && age > self.oldest {
            let fault = Fault::new(FaultKind::SensorStale);
            return Err(fault.exceeds(age.into(), self.oldest.into(), "step"));
        }
        let seen = reading.as_ref().and_then(self.see).map(|X_WF| (X_WF, f64::from(age) * t.duration));
        let Some(X_WF) = self.frame.follow(seen, t.duration, t.dt) else {
            return Ok(Step::Next(Demand::hold()));
        };
        self.age += t.dt;
        if self.duration - self.age <= 1e-9 * t.dt {
            self.age = self.duration;
        }
        let X_WG = X_WF * self.place;
        if !X_WG.to_homogeneous().iter().all(|x| x.is_finite()) {
            return Err(Fault::thrown("the place in the frame that the sensor reports is not finite"));
        }
        let s = (self.age / self.approach).min(1.0);
        let b = s * s * s * (10.0 + s * (6.0 * s - 15.0));
        Ok(Step::Next(Demand::pose(LinePath::new(self.start, X_WG).pose(b))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::payload::Payload;
    use mrroc::robot::{RobotImage, RobotState};
    use mrroc::sensor::SensorImage;
    use mrroc_robots::{Irp6, Six};
    use nalgebra::Vector3;

    struct Encoder;

    /// How far the belt has gone \[m\].
    #[derive(Clone, Copy, Payload)]
    struct Gone {
        distance: f64,
    }

    impl Sensor for Encoder {
        const KIND: &'static str = "encoder";
        type Reading = Gone;
        type Configuration = ();
    }

    /// A belt that starts, runs and is slowed down, read every fifth step, two to six steps late, in counts of 0.1 mm.
    #[test]
    fn a_tool_gets_onto_a_belt_that_changes_its_speed_and_stays_on_it() {
        const DT: f64 = 2e-3;
        let gone = |t: f64| if t < 2.0 { 0.1 * t } else { 0.2 + 0.05 * (t - 2.0) };
        let how = Tracking { rate: 15.0, acceleration: 1.0, turning: 5.0 };
        let start = Pose::translation(0.4, -0.2, 0.5);
        let place = Pose::translation(0.3, 0.1, 0.2);
        let see = |gone: &Gone| Some(Pose::translation(gone.distance, 0.0, 0.0));
        let mut generator = FollowedFrame::<Irp6, Encoder>::to(see, place, how, 1.0, 4.0, 8);
        let state = RobotState { joints: Six::zeros(), velocity: Six::zeros(), pose: start };
        let e = State::new(RobotImage::new(state, state));
        let t = Tick { step: 0, dt: DT, duration: DT };
        let mut trace = vec![start.translation.vector; 2];
        let mut step = Ok(Step::Next(Demand::hold()));
        let mut i = 0_u32;
        while let Ok(Step::Next(_)) = step {
            i += 1;
            let of = (i.saturating_sub(2) / 5) * 5;
            let counts = (gone(f64::from(of) * DT) * 1e4).round() * 1e-4;
            let v = Reading::new((SensorImage::new(Gone { distance: counts }, i - of),));
            step = if i == 1 { generator.first_step(&e, &v, t) } else { generator.next_step(&v, t) };
            let Ok(Step::Next(demand)) = &step else { break };
            let here = demand.as_pose().expect("a pose").translation.vector;
            let now = f64::from(i) * DT;
            if (1.2..2.0).contains(&now) || now > 3.0 {
                let off = here - place.translation.vector - Vector3::x() * gone(now);
                assert!(off.norm() < 2e-4, "{off} at {now} s");
            }
            trace.push(here);
        }
        assert_eq!((step, i), (Ok(Step::Done), 2001));
        for w in trace.windows(3) {
            // 5.78 of the distance within a second, twice 1.875 of the belt's speed, and what the tracking takes.
            let a = (w[2] - w[1] * 2.0 + w[0]).norm() / (DT * DT);
            assert!(a < 5.78 * 0.55 + 3.75 * 0.1 + 1.0, "{a}");
        }
    }
}
