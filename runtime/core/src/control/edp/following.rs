//! What an EDP makes of the demands: a step's, and each servo period's.
//!
//! In: accepted demands, or none. Out: what the drives are told, what the encoders say; the faults of drives, of joints that
//! do not follow, of demands that stay away.

use crate::model::fault::{Fault, FaultKind};
use crate::model::robot::InterpolationSpace;
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::safety::limits::AcceptedDemand;

use crate::control::guarded::guarded;
use crate::observe::servo::ServoRecord;

use super::{Edp, Mode};

impl<R: Robot> Edp<'_, R> {
    /// A step begins: its demand, or what replaces it, is what the drives are on their way to.
    pub(super) fn begin_step(&mut self) {
        if !matches!(self.mode, Mode::Off) {
            let demand = *self.next_demand().joints();
            self.still = if demand == *self.interpolation.goal() { self.still + 1 } else { 0 };
            self.interpolation.push(demand);
            if let Some(sets) = self.regulators.take() {
                let chosen = guarded(|| self.config.drive.choose_regulators(&sets));
                if let Err(panic) = chosen {
                    (self.mode, self.lost) = (Mode::Off, true);
                    self.latch(panic, self.due);
                }
            }
        }
        self.tell_step();
        self.due += 1;
    }

    /// What the drives are told for the end of a servo period.
    fn position_at(&mut self, end: Nanos) -> R::Joints {
        let joints = self.interpolation.at(end);
        if self.config.space == InterpolationSpace::Joints || self.interpolation.is_direct() {
            return joints;
        }
        if self.task_space.advance(self.servo as f64 * 1e-9) {
            match guarded(|| self.beside_spline(end, &joints)).and_then(|difference| difference) {
                Ok(difference) => self.task_space.set_difference(difference),
                Err(fault) => {
                    self.task_space.fail();
                    self.latch(fault, self.due.saturating_sub(1));
                    self.brake();
                }
            }
        }
        joints + self.task_space.correction()
    }

    /// By how much the joints of the pose between the demands differ from those of the spline.
    fn beside_spline(&self, end: Nanos, joints: &R::Joints) -> Result<R::Joints, Fault> {
        let robot = &self.config.robot;
        let pose = self.interpolation.pose_at(end, |joints| robot.forward(joints));
        let difference = self.acceptor.flange_joints(&pose, joints)? - *joints;
        // On another branch, or where the pose turns about a singularity that the joints do not.
        self.acceptor.check_way(&difference, self.config.step.as_secs_f64())?;
        let way = *joints + difference - self.commanded;
        self.acceptor.check_way(&way, self.servo as f64 * 1e-9)?;
        Ok(difference)
    }

    /// One servo period.
    #[allow(non_snake_case)]
    pub(super) fn tick(&mut self, now: Nanos) {
        if matches!(self.mode, Mode::Off) {
            return;
        }
        let demanded = self.position_at(now + self.servo);
        self.commanded = demanded;
        let X_FE = *self.acceptor.tool();
        let fault = match guarded(|| self.config.drive.tick(now, &demanded, &X_FE, self.host.waiter)) {
            Ok(Ok(followed)) => {
                self.measured = followed.measured;
                self.check_following(&followed.demanded, FaultKind::FollowingError).err()
            }
            // What a driver that panicked still does is unknown: it is told nothing more.
            Err(panic) => {
                (self.mode, self.lost) = (Mode::Off, true);
                Some(panic)
            }
            Ok(Err(fault)) => {
                self.mode = Mode::Off;
                Some(fault)
            }
        };
        let observed = self.observe(now, demanded);
        if let Some(fault) = fault.or(observed.err()) {
            self.latch(fault, now / self.step.max(1));
            self.brake();
        }
    }

    /// Shows the servo period to the observers. One that panics ends them all.
    fn observe(&mut self, now: Nanos, demanded: R::Joints) -> Result<(), Fault> {
        if !self.config.observers.is_empty() {
            let record = ServoRecord {
                time: (now + self.servo) as f64 * 1e-9,
                demanded,
                measured: self.measured,
                tool: *self.acceptor.tool(),
            };
            let observers = &mut self.config.observers;
            let shown = guarded(|| observers.iter_mut().for_each(|observer| observer(&record)));
            if shown.is_err() {
                observers.clear();
            }
            return shown;
        }
        Ok(())
    }

    /// The demand of the step that begins: the one that came, or what replaces it.
    pub(super) fn next_demand(&mut self) -> AcceptedDemand<R> {
        // A demand accepted before a stop is still the state that the stop begins at.
        if let Some(next) = self.next.take() {
            return next;
        }
        let step = self.config.step.as_secs_f64();
        match &mut self.mode {
            Mode::Holding | Mode::Off => self.hold(step),
            Mode::Moving { missed } => {
                *missed = missed.saturating_add(1);
                let missed = *missed;
                if missed <= self.missed_step_budget() {
                    return self.bridge(step);
                }
                self.latch(Fault::new(FaultKind::PeerLost).text("no demand from the ECP"), self.due);
                self.mode = self.way_to_rest();
                self.next_demand()
            }
            Mode::OnScrew(braking) => match braking.advance(step) {
                Some(displacement) => self.slow_down(&displacement, step),
                None => self.hold(step),
            },
            Mode::Braking(braking) if braking.is_over() => self.hold(step),
            Mode::Braking(braking) => self.acceptor.brake(braking, step),
        }
    }
}
