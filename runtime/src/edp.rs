//! EDP: the effector driver process of one robot.
//!
//! In: demands of the ECP, one per step. Out: the joint positions that the drives get, one per servo period,
//! and the robot's image in every reply. Servo periods begin half a period after the steps, so that the demand of a step
//! is there before the drives ask for it; each gets the position for its end, interpolated in joints or in the task
//! space ([`Interpolation`]). The reply to a demand leaves as soon as the demand is accepted: the next one is computed
//! while the robot moves.

use core::time::Duration;

use crate::braking::Braking;
use crate::demand::{Coordinates, Demand};
use crate::driver::{Driver, Measured, Regulators};
use crate::fault::{Fault, FaultKind, ProcessId};
use crate::image::{RobotImage, RobotState};
use crate::interpolation::{Interpolation, InterpolationSpace};
use crate::joints::JointVector;
use crate::limits::{AcceptedDemand, Acceptor};
use crate::link::{Closed, Nanos, Server, Waiter};
use crate::message::{Kind, Message, RequestKind, flag};
use crate::pose::Pose;
use crate::robot::Robot;
use crate::stopping::{detection_time, missed_step_budget, stop_steps};
use crate::task_space::TaskSpace;
use crate::wire::Wire;

/// What a servo period did, for recording and for pictures.
pub struct ServoRecord<R: Robot> {
    /// Time since the cell started, at the period's end \[s\].
    pub time: f64,
    /// Joint positions that the drives got [rad or m].
    pub demanded: R::Joints,
    /// What the encoders read at the period's end.
    pub measured: Measured<R::Joints>,
    /// The tool in force, `X_FE`.
    pub tool: Pose,
}

/// What an observer of servo periods is.
pub type Observer<R> = Box<dyn FnMut(&ServoRecord<R>)>;

/// How a robot is set up.
pub(crate) struct EdpConfig<R: Robot> {
    pub process: ProcessId,
    pub robot: R,
    pub driver: Box<dyn Driver<R>>,
    pub tool: Pose,
    pub step: Duration,
    /// The cell's delay between demands and drives; `None`: drives take each demand as it is.
    pub delay: Option<Duration>,
    pub space: InterpolationSpace,
    /// Largest difference between demanded and measured joint positions [rad or m].
    pub following_error: R::Joints,
    pub observers: Vec<Observer<R>>,
}

#[expect(clippy::large_enum_variant, reason = "a braking tail is a part of a step: it allocates nothing")]
enum Mode<J> {
    /// No demand is due.
    Holding,
    /// A demand is due in every step; those of so many steps are missing.
    Moving { missed: u32 },
    /// On the way to a standstill.
    Braking(Braking<J>),
    /// A drive gave up and has its brake applied.
    Off,
}

/// The process.
pub(crate) struct Edp<'w, R: Robot> {
    config: EdpConfig<R>,
    waiter: &'w dyn Waiter,
    port: Box<dyn Server>,
    acceptor: Acceptor<R>,
    mode: Mode<R::Joints>,
    /// Accepted for the step that is about to begin, and the regulators chosen with it.
    next: Option<AcceptedDemand<R>>,
    regulators: Option<Regulators>,
    /// What the ticks make of the demands.
    interpolation: Interpolation<R::Joints>,
    task_space: TaskSpace<R::Joints>,
    /// What the drives were told last.
    commanded: R::Joints,
    /// The first step that has not begun here, and when it does; when the next servo period begins \[ns\].
    due: u64,
    next_step: Nanos,
    next_tick: Nanos,
    step: Nanos,
    servo: Nanos,
    /// Steps for which the demands have stood still.
    still: u64,
    measured: Measured<R::Joints>,
    stopped: bool,
    fault: Option<Fault>,
    request: Message,
    reply: Message,
}

impl<'w, R: Robot> Edp<'w, R> {
    pub fn new(config: EdpConfig<R>, waiter: &'w dyn Waiter, port: Box<dyn Server>) -> Self {
        let measured = config.driver.measured();
        let (step, servo) = (config.step.as_nanos() as Nanos, config.driver.period().as_nanos() as Nanos);
        let reaction = detection_time(config.step);
        let acceptor = Acceptor::new(config.robot.clone(), config.tool, measured.position, reaction);
        let (now, shorter) = (waiter.now(), servo.min(step));
        // Half a period after multiples of the period, from now on.
        let due = (now + step - shorter / 2).div_ceil(step.max(1)).saturating_sub(1);
        let tick = now.saturating_sub(servo / 2).div_ceil(servo.max(1));
        let interpolation = Interpolation::new(measured.position, due, config.step, config.delay);
        let mut edp = Edp {
            waiter,
            port,
            acceptor,
            mode: Mode::Holding,
            next: None,
            regulators: None,
            still: interpolation.settling_steps(),
            interpolation,
            task_space: TaskSpace::new(),
            commanded: measured.position,
            due,
            next_step: due * step + shorter / 2,
            next_tick: tick * servo + servo / 2,
            step,
            servo,
            measured,
            stopped: false,
            fault: None,
            request: Message::empty(),
            reply: Message::empty(),
            config,
        };
        // Where encoders give no numbers, there is nothing to hold: the drives get no demand at all.
        if let Err(fault) = edp.check_following(edp.interpolation.goal(), FaultKind::FollowingError) {
            edp.mode = Mode::Off;
            edp.latch(fault, 0);
        }
        edp
    }

    /// Keeps the first fault.
    fn latch(&mut self, fault: Fault, step: u64) {
        self.fault.get_or_insert(fault.in_process(self.config.process).at_step(step));
    }

    /// Serves until the cell closes.
    ///
    /// # Errors
    /// `PeerLost` when the robot still moved then and did not come to a standstill in the time that its stops may take.
    pub fn run(mut self) -> Result<(), Fault> {
        while self.waiter.wait(Some(self.next_step.min(self.next_tick))) != Err(Closed) {
            while self.port.receive(&mut self.request) {
                self.serve();
            }
            while self.waiter.now() >= self.next_step.min(self.next_tick) {
                self.advance();
            }
        }
        self.come_to_rest()
    }

    /// Brakes what still moves when the cell closes: its other processes may be gone. Where time stands still then,
    /// nothing moves.
    fn come_to_rest(&mut self) -> Result<(), Fault> {
        self.stopped = true;
        self.brake();
        let delay = self.config.delay.unwrap_or_default();
        let began = self.due;
        let last = began + stop_steps(self.config.robot.limits(), self.config.step, delay);
        // The demand that holds is one of the next step, and the drives are there at the end of that step.
        while !self.is_at_standstill() || self.due <= began + 2 {
            if self.due > last {
                let text = "the cell closed while the robot moved, and it does not come to a standstill";
                return Err(Fault::new(FaultKind::PeerLost).in_process(self.config.process).text(text));
            }
            let next = self.next_step.min(self.next_tick);
            if self.waiter.wait_closing(next).is_err() {
                return Ok(());
            }
            while self.waiter.now() >= self.next_step.min(self.next_tick) {
                self.advance();
            }
        }
        Ok(())
    }

    /// The step or servo period that begins next; a step before the servo period that begins with it.
    fn advance(&mut self) {
        if self.next_step <= self.next_tick {
            self.begin_step();
            self.next_step += self.step;
        } else {
            self.tick(self.next_tick);
            self.next_tick += self.servo;
        }
    }

    fn serve(&mut self) {
        let result = guarded(|| self.act()).and_then(|result| result);
        if let Err(fault) = result {
            self.latch(fault, self.request.header.step);
            self.brake();
        }
        if let Err(fault) = guarded(|| self.answer()) {
            self.latch(fault, self.request.header.step);
            self.brake();
            // With a fault there is no image to compute.
            self.answer();
        }
    }

    fn act(&mut self) -> Result<(), Fault> {
        let request = match self.request.header.kind {
            Kind::Request(request) => request,
            Kind::Order(_) | Kind::Read | Kind::Reply | Kind::Fault => {
                return Err(Fault::new(FaultKind::Message));
            }
        };
        match request {
            RequestKind::Query => self.check_standing_start(),
            RequestKind::Demand => self.demand(),
            RequestKind::Brake => {
                self.brake();
                Ok(())
            }
            RequestKind::Stop => {
                self.stopped = true;
                self.brake();
                Ok(())
            }
        }
    }

    /// A robot that does not stand where it was last told to stand must not start.
    fn check_standing_start(&self) -> Result<(), Fault> {
        if self.request.is(flag::FIRST) && matches!(self.mode, Mode::Holding) {
            self.check_following(self.interpolation.goal(), FaultKind::StartPoseMismatch)
                .map_err(|fault| fault.text("the robot is not where its last demand put it"))
        } else {
            Ok(())
        }
    }

    fn check_following(&self, demanded: &R::Joints, kind: FaultKind) -> Result<(), Fault> {
        for i in 0..R::Joints::LEN {
            let (error, limit) =
                ((self.measured.position[i] - demanded[i]).abs(), self.config.following_error[i]);
            // A NaN from an encoder is no small error.
            let is_small = error <= limit && self.measured.velocity[i].is_finite();
            if !is_small {
                return Err(Fault::new(kind).at_joint(i).exceeds(
                    error,
                    limit,
                    self.config.robot.joint(i).unit(0),
                ));
            }
        }
        Ok(())
    }

    fn demand(&mut self) -> Result<(), Fault> {
        if self.stopped || self.fault.is_some() {
            return Err(Fault::new(FaultKind::StoppedByCell));
        }
        let header = self.request.header;
        // Woken late: what was due before the demand's step comes before the demand.
        while self.due < header.step && self.waiter.now() >= self.next_step.min(self.next_tick) {
            self.advance();
        }
        if self.request.is(flag::FIRST) {
            self.acceptor.begin();
        }
        let demand = Demand::get(self.request.words()).map_err(|_| Fault::new(FaultKind::Message))?;
        if let Some(sets) = &demand.regulators {
            self.check_regulators(sets)?;
            self.regulators = Some(*sets);
        }
        // What was to be done in a step that is over has been bridged, and is never made up for; what was chosen with
        // it stays in force.
        if header.step < self.due {
            return self.acceptor.choose_tool(&demand);
        }
        // A late demand's own count of periods says how far its path has come; the steps before it were bridged.
        let duration = self.config.step.as_secs_f64();
        let accepted = self.acceptor.accept(&demand, header.dt / header.duration * duration, duration);
        let first = self.request.is(flag::FIRST) && !matches!(self.mode, Mode::Moving { .. });
        self.next = Some(accepted.map_err(|fault| if first { fault.of_first_demand() } else { fault })?);
        let stands = self.config.space == InterpolationSpace::Task && self.interpolation.stands();
        match demand.coordinates {
            Coordinates::Hold => {}
            Coordinates::Joints(_) => self.task_space.accept(false, stands),
            Coordinates::Pose(_) | Coordinates::Displacement(_) => self.task_space.accept(true, stands),
        }
        self.mode = Mode::Moving { missed: 0 };
        Ok(())
    }

    fn check_regulators(&self, sets: &Regulators) -> Result<(), Fault> {
        let driver = &self.config.driver;
        match (0..R::Joints::LEN).find(|&joint| !driver.has_regulator(joint, sets.set(joint))) {
            Some(joint) => {
                let text = format!("parameter set {}", sets.set(joint));
                Err(Fault::new(FaultKind::NoRegulator).at_joint(joint).text(&text))
            }
            None => Ok(()),
        }
    }

    fn brake(&mut self) {
        match self.mode {
            Mode::Moving { .. } if self.acceptor.can_hold(self.config.step.as_secs_f64()) => {
                self.mode = Mode::Holding
            }
            Mode::Moving { .. } => self.mode = Mode::Braking(self.acceptor.braking()),
            Mode::Holding | Mode::Braking(_) | Mode::Off => {}
        }
    }

    /// Whether the robot stands, and its drives have come to the last demand.
    fn is_at_standstill(&self) -> bool {
        match self.mode {
            Mode::Holding => self.still >= self.interpolation.settling_steps(),
            Mode::Off => true,
            Mode::Moving { .. } | Mode::Braking(_) => false,
        }
    }

    fn answer(&mut self) {
        let at_standstill = self.is_at_standstill();
        let reply = &mut self.reply;
        reply.header.step = self.request.header.step;
        reply.header.instruction = self.request.header.instruction;
        reply.header.flags = 0;
        if at_standstill {
            reply.header.flags |= flag::STANDSTILL;
        }
        if let Some(fault) = &self.fault {
            reply.set_fault(fault);
        } else {
            reply.header.kind = Kind::Reply;
            reply.header.headroom = self.acceptor.headroom();
            reply.header.len = 0;
            if self.request.is(flag::WANT_STATE) {
                reply.header.flags |= flag::STATE;
                reply.header.len = RobotImage::<R>::LEN as u32;
                let (q, v) = (*self.acceptor.position(), *self.acceptor.velocity());
                let demanded = RobotState { joints: q, velocity: v, pose: self.acceptor.tool_pose(&q) };
                let q = self.measured.position;
                let measured = RobotState {
                    joints: q,
                    velocity: self.measured.velocity,
                    pose: self.acceptor.tool_pose(&q),
                };
                RobotImage::<R>::new(measured, demanded).put(&mut reply.body);
            }
        }
        self.port.reply(reply);
    }

    /// A step begins: its demand, or what replaces it, is what the drives are on their way to.
    fn begin_step(&mut self) {
        if !matches!(self.mode, Mode::Off) {
            let demand = *self.next_demand().joints();
            self.still = if demand == *self.interpolation.goal() { self.still + 1 } else { 0 };
            self.interpolation.push(demand);
            if let Some(sets) = self.regulators.take() {
                let chosen = guarded(|| self.config.driver.choose_regulators(&sets));
                if let Err(panic) = chosen {
                    self.mode = Mode::Off;
                    self.latch(panic, self.due);
                }
            }
        }
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
        self.acceptor.check_speed(&R::Joints::zeros(), &difference, self.config.step.as_secs_f64())?;
        let before = self.commanded - *joints;
        let way = difference - before;
        self.acceptor.check_speed(&R::Joints::zeros(), &way, self.servo as f64 * 1e-9)?;
        Ok(difference)
    }

    /// One servo period.
    fn tick(&mut self, now: Nanos) {
        if matches!(self.mode, Mode::Off) {
            return;
        }
        let demanded = self.position_at(now + self.servo);
        self.commanded = demanded;
        let fault = match guarded(|| self.config.driver.tick(&demanded)) {
            Ok(Ok(measured)) => {
                self.measured = measured;
                self.check_following(&demanded, FaultKind::FollowingError).err()
            }
            // What a driver that panicked still does is unknown: it is told nothing more.
            Err(panic) => {
                self.mode = Mode::Off;
                Some(panic)
            }
            Ok(Err(trip)) => {
                self.mode = Mode::Off;
                Some(Fault::of_drive(&trip))
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
    fn next_demand(&mut self) -> AcceptedDemand<R> {
        // A demand accepted before a stop is still the state that the stop begins at.
        if let Some(next) = self.next.take() {
            return next;
        }
        let step = self.config.step.as_secs_f64();
        match &mut self.mode {
            Mode::Holding | Mode::Off => self.acceptor.hold(step),
            Mode::Moving { missed } => {
                *missed = missed.saturating_add(1);
                if *missed <= missed_step_budget(self.config.step) {
                    return self.acceptor.extrapolate(step);
                }
                self.latch(Fault::new(FaultKind::PeerLost).text("no demand from the ECP"), self.due);
                self.mode = Mode::Braking(self.acceptor.braking());
                self.next_demand()
            }
            Mode::Braking(braking) if braking.is_over() => {
                self.mode = Mode::Holding;
                self.acceptor.hold(step)
            }
            Mode::Braking(braking) => self.acceptor.brake(braking, step),
        }
    }
}

/// Runs code of the user's, a driver, an observer, a robot's kinematics; its panic is a fault of the process.
pub(crate) fn guarded<T>(run: impl FnOnce() -> T) -> Result<T, Fault> {
    let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
    caught.map_err(|panic| crate::fault::panicked(&*panic))
}

#[cfg(test)]
mod tests {
    use core::cell::RefCell;
    use std::rc::Rc;

    use nalgebra::Vector1;

    use super::*;
    use crate::driver::DriveFault;
    use crate::fault::Role;
    use crate::message::OrderKind;
    use crate::name::Name;
    use crate::robot::{Limits, NoInverse};

    #[derive(Clone)]
    struct Slide(Limits<Vector1<f64>>);

    impl Robot for Slide {
        const KIND: &'static str = "slide";
        type Joints = Vector1<f64>;
        fn limits(&self) -> &Limits<Vector1<f64>> {
            &self.0
        }
        fn forward(&self, q: &Vector1<f64>) -> Pose {
            Pose::translation(q[0], 0.0, 0.0)
        }
        #[allow(non_snake_case)]
        fn inverse(&self, X_WF: &Pose, _: &Vector1<f64>) -> Result<Vector1<f64>, NoInverse> {
            Ok(Vector1::new(X_WF.translation.x))
        }
    }

    struct Exact(Duration, Measured<Vector1<f64>>);

    impl Driver<Slide> for Exact {
        fn period(&self) -> Duration {
            self.0
        }
        fn measured(&self) -> Measured<Vector1<f64>> {
            self.1
        }
        fn tick(&mut self, demanded: &Vector1<f64>) -> Result<Measured<Vector1<f64>>, DriveFault> {
            self.1.position = *demanded;
            Ok(self.1)
        }
    }

    struct Still;

    impl Waiter for Still {
        fn now(&self) -> Nanos {
            0
        }
        fn wait(&self, _: Option<Nanos>) -> Result<(), Closed> {
            Err(Closed)
        }
    }

    /// Keeps the replies.
    struct Replies(Rc<RefCell<Vec<Message>>>);

    impl Server for Replies {
        fn receive(&self, _: &mut Message) -> bool {
            false
        }
        fn reply(&self, reply: &Message) {
            self.0.borrow_mut().push(*reply);
        }
    }

    fn edp(servo: Duration) -> (Edp<'static, Slide>, Rc<RefCell<Vec<Message>>>) {
        let zero = Vector1::zeros();
        let limits = Limits {
            lower: Vector1::new(-1.0),
            upper: Vector1::new(1.0),
            velocity: Vector1::new(1.0),
            acceleration: Vector1::new(10.0),
            jerk: None,
        };
        let config = EdpConfig {
            process: ProcessId::new(Role::Edp, Name::new("g").expect("a name")),
            robot: Slide(limits),
            driver: Box::new(Exact(servo, Measured { position: zero, velocity: zero })),
            tool: Pose::identity(),
            step: Duration::from_millis(1),
            delay: crate::interpolation::delay(Duration::from_millis(1), [servo].into_iter()),
            space: InterpolationSpace::Joints,
            following_error: Vector1::new(1.0),
            observers: Vec::new(),
        };
        let replies = Rc::default();
        (Edp::new(config, &Still, Box::new(Replies(Rc::clone(&replies)))), replies)
    }

    #[test]
    fn fault_14_an_edp_bridges_twenty_steps_however_long_its_servo_period_is() {
        for millis in [1, 2, 4, 5, 8, 20] {
            let (mut edp, _) = edp(Duration::from_millis(millis));
            edp.request = Message::new(Kind::Request(RequestKind::Demand));
            (edp.request.header.dt, edp.request.header.duration) = (1e-3, 1e-3);
            edp.request.header.len = <Demand<Slide> as Wire>::LEN as u32;
            Demand::<Slide>::joints(Vector1::new(1e-6)).put(&mut edp.request.body);
            edp.serve();
            // The demand itself, and then nothing.
            edp.begin_step();
            let mut bridged = 0;
            while matches!(edp.mode, Mode::Moving { .. }) {
                bridged += 1;
                assert!(bridged < 1000, "never brakes");
                edp.begin_step();
            }
            // The last of them is the one that no longer bridges.
            assert_eq!(bridged - 1, 20, "servo period {millis} ms");
            assert_eq!(edp.fault.as_ref().map(Fault::kind), Some(FaultKind::PeerLost));
        }
    }

    #[test]
    fn what_is_no_request_is_a_fault_and_moves_nothing() {
        for kind in [Kind::Order(OrderKind::Step), Kind::Read, Kind::Reply, Kind::Fault] {
            let (mut edp, replies) = edp(Duration::from_millis(1));
            edp.request = Message::new(kind);
            edp.serve();
            let reply = *replies.borrow().last().expect("answered");
            assert_eq!((reply.header.kind, reply.fault().kind()), (Kind::Fault, FaultKind::Message));
            assert!(reply.is(flag::STANDSTILL));
        }
    }
}
