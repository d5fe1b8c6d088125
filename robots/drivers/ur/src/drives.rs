//! The drives of an arm behind a controller of Universal Robots.
//!
//! In: positions for the ends of the controller's periods. Out: a set-point for its script in each of them; what the joints
//! read; why the robot stands, if it was not stopped from here.
//!
//! ```text
//!  cell                          controller
//!  pulse  <-- RTDE: state ------  every 2 ms
//!  tick   --- set-point -------> script: servoj in the next step
//!  reset  --- dashboard, script -> releases a protective stop, starts the script again
//! ```

use core::time::Duration;
use std::net::{IpAddr, SocketAddr};

use mrroc::pose::{Pose, Wrench};
use mrroc::robot::{
    Channels, ClearedBy, DriveFault, Driver, Load, Measured, Outputs, Pace, Pulse, Recovery, Robot,
    RobotStop, Signals, StopCause, Values,
};
use mrroc_robots::{Serial, Six};

use crate::calibration::Calibration;
use crate::models::{JOINTS, UrModel};
use crate::outputs::{self, Group, Groups};
use crate::payload::{self, Payload};
use crate::script::Script;
use crate::set_point::{Ask, SetPoint};
use crate::state::{PERIOD, State};
use crate::stop::{self, Connected};
use crate::wire::{ConnectionLost, Job, JobState, Ports, Sockets, Wire};

/// How often the drives look, when they are opened, whether the controller is ready: 20 s for [`Sockets`].
const LOOKS: u32 = 20_000;

/// A controller, and what its script is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UrSettings {
    /// The controller's address.
    pub robot: IpAddr,
    /// This machine's address in the controller's network, and the port at which its script calls.
    pub listen: SocketAddr,
    /// How long the script waits for a set-point before it brakes and ends; 20 ms by default. Until then the arm goes on at
    /// the speed it had.
    pub read_timeout: Duration,
    /// How hard the script brakes then [rad/s²], > 0: the joint that is fastest, and the others with it. By default the
    /// smallest acceleration limit of the model.
    pub deceleration: f64,
    /// `lookahead_time` of `servoj`: 0.03 s by default, at most 0.2.
    pub lookahead: Duration,
    /// `gain` of `servoj`: 2000 by default, at least 100.
    pub gain: f64,
    /// How long the controller may say nothing before that is a fault; 100 ms by default.
    pub timeout: Duration,
    /// Its ports.
    pub ports: Ports,
    /// The calibration with which the arm was made; `None`, the default, if with the nominal dimensions. An arm
    /// with another calibration is not opened.
    pub calibration: Option<Calibration>,
    /// Where a program node of UR's External Control URCap asks for the script, on this machine, such as `"192.168.1.2:50002"`: then a
    /// person starts its program at the pendant, and the controller need not be in remote control. `None`, the default: the
    /// script is sent.
    pub external_control: Option<SocketAddr>,
    /// The model, for the text of its calibration.
    pub model: UrModel,
}

impl UrSettings {
    /// With the defaults for a model.
    #[must_use]
    pub fn new(model: UrModel, robot: IpAddr, listen: SocketAddr) -> UrSettings {
        let script = Script::new(listen, model.accelerations().min());
        UrSettings {
            robot,
            listen,
            read_timeout: Duration::from_millis(20),
            deceleration: script.deceleration,
            lookahead: script.lookahead,
            gain: script.gain,
            timeout: Duration::from_millis(100),
            ports: Ports::default(),
            calibration: None,
            external_control: None,
            model,
        }
    }

    /// The longest that the arm goes on when set-points do not come any more: the read timeout, and the script's braking
    /// from the largest velocity of the model.
    #[must_use]
    pub fn longest_stop(&self, model: UrModel) -> Duration {
        self.read_timeout + Duration::from_secs_f64(model.velocities().max() / self.deceleration)
    }
}

/// The drives. They are paced by the controller.
#[derive(Debug)]
pub struct Ur<W = Sockets> {
    settings: UrSettings,
    wire: W,
    /// The arm in its own base, for where its flange is; `None` if the calibration is that of another model.
    arm: Option<Serial<JOINTS>>,
    state: Option<State>,
    recovery: ResetStage,
    /// Which outputs programs switch, and what these take when the script gets no set-points any more.
    switches: Groups,
    when_lost: Outputs,
    payload: Payload,
    /// An analog output was told what it cannot be.
    is_beyond: bool,
    /// The drives could not be opened, so they are opened again because an operator has asked for a reset.
    was_refused: bool,
}

/// How far a reset has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ResetStage {
    /// Nothing is being done.
    None,
    /// The protective stop is being released.
    Unlocks,
    /// It has been, and the controller is to say so.
    Unlocked,
    /// The script has been sent.
    Starts,
}

const CLOSED: DriveFault = DriveFault::Other("the controller is not connected");

const BEYOND: DriveFault = DriveFault::Other(
    "an analog output is told what is not between 0 and 1, the fraction of its range: it was not switched",
);

const OTHER_ARM: DriveFault = DriveFault::Other(
    "the `calibration` in cell.toml is not that of this arm: print it anew by `-- calibration`, followed by the robot's name",
);

fn lost(why: ConnectionLost) -> DriveFault {
    DriveFault::Stopped(RobotStop::new(StopCause::CommunicationLost).named(why.0))
}

impl Ur<Sockets> {
    /// Drives that connect to nothing before they are opened.
    #[must_use]
    pub fn new(settings: UrSettings) -> Ur {
        let sockets = Sockets::new(settings.robot, settings.listen, settings.ports);
        Ur::over(sockets.asked_at(settings.external_control), settings)
    }
}

impl<W: Wire> Ur<W> {
    /// Drives that reach their controller by other means: one in the same process.
    #[must_use]
    pub fn over(wire: W, settings: UrSettings) -> Ur<W> {
        let (model, base) = (settings.model, Pose::identity());
        let arm = match &settings.calibration {
            Some(calibration) => model.calibrated(base, calibration),
            None => model.arm(base),
        };
        Ur {
            settings,
            wire,
            arm: arm.ok(),
            state: None,
            recovery: ResetStage::None,
            switches: Groups::NONE,
            when_lost: Outputs::NONE,
            payload: Payload::unsaid(settings.lookahead),
            is_beyond: false,
            was_refused: false,
        }
    }

    /// What the controller said last.
    #[must_use]
    pub fn state(&self) -> Option<&State> {
        self.state.as_ref()
    }

    /// How they reach their controller.
    #[must_use]
    pub fn wire(&self) -> &W {
        &self.wire
    }

    /// What starts the script.
    fn start(&mut self) -> Job {
        self.payload.begin();
        let UrSettings { deceleration, lookahead, gain, .. } = self.settings;
        let (reverse, when_lost) = (self.wire.reverse(), self.when_lost);
        let script = Script { reverse, deceleration, lookahead, gain, when_lost };
        match self.settings.external_control {
            None => Job::Start(script.text()),
            Some(_) => Job::Offer(script.node_text()),
        }
    }

    /// Hears all that has come, and returns how old the last of it is.
    fn hear(&mut self, now: Duration) -> Result<Option<Duration>, ConnectionLost> {
        let mut age = None;
        while let Some(heard) = self.wire.heard(now)? {
            (self.state, age) = (Some(heard.state), Some(heard.age));
        }
        Ok(age)
    }

    /// What has stopped the arm.
    fn stop(&mut self) -> Option<RobotStop> {
        let script = self.wire.script();
        self.state.as_ref().and_then(|state| stop::of(state, script))
    }

    fn measured_now(&self) -> Result<Measured<Six>, DriveFault> {
        let state = self.state.as_ref().ok_or(CLOSED)?;
        Ok(Measured { position: Six::from(state.actual_q), velocity: Six::from(state.actual_qd) })
    }

    /// One step of what a reset does at the controller: releases a protective stop, and starts the script.
    fn advance(&mut self) -> Result<Recovery, DriveFault> {
        match self.recovery {
            ResetStage::None => match self.stop() {
                None => Ok(Recovery::Over),
                Some(stop) if stop.cleared_by() != ClearedBy::Operator => Err(stop.into()),
                Some(stop) if stop.cause() == StopCause::ProtectiveStop => {
                    self.wire.begin(Job::Unlock);
                    Ok(self.goes_on(ResetStage::Unlocks))
                }
                Some(_) => {
                    let start = self.start();
                    self.wire.begin(start);
                    Ok(self.goes_on(ResetStage::Starts))
                }
            },
            ResetStage::Unlocks => match self.wire.job() {
                JobState::Busy => Ok(Recovery::GoesOn),
                JobState::Done => Ok(self.goes_on(ResetStage::Unlocked)),
                refused => self.refused(refused, StopCause::ProtectiveStop),
            },
            ResetStage::Unlocked => {
                match self.stop() {
                    Some(stop) if stop.cause() == StopCause::ProtectiveStop => {}
                    Some(_) | None => self.recovery = ResetStage::None,
                }
                Ok(Recovery::GoesOn)
            }
            ResetStage::Starts => match self.wire.job() {
                JobState::Busy => Ok(Recovery::GoesOn),
                JobState::Done => {
                    self.recovery = ResetStage::None;
                    Ok(Recovery::Over)
                }
                refused => self.refused(refused, StopCause::ProgramNotRunning),
            },
        }
    }

    fn goes_on(&mut self, stage: ResetStage) -> Recovery {
        self.recovery = stage;
        Recovery::GoesOn
    }

    fn refused(&mut self, state: JobState, cause: StopCause) -> Result<Recovery, DriveFault> {
        self.recovery = ResetStage::None;
        let stop = match state {
            JobState::Local => RobotStop::new(StopCause::PendantInControl).named("not in remote control"),
            JobState::Refused(why) => RobotStop::new(cause).named(why),
            JobState::None | JobState::Busy | JobState::Done => RobotStop::new(cause),
        };
        Err(stop.into())
    }

    fn try_open(&mut self) -> Result<(), DriveFault> {
        if let Some(calibration) = self.settings.calibration
            && !self.wire.calibration().map_err(lost)?.is_of_the_same_arm(&calibration)
        {
            return Err(OTHER_ARM);
        }
        if !outputs::are_fractions(&self.when_lost) {
            return Err(BEYOND);
        }
        self.state = Some(self.wire.connect(self.switches).map_err(lost)?);
        // A protective stop is released at a reset, and not when a cell starts.
        if let Some(stop) = self.stop().filter(|stop| stop.cause() == StopCause::ProtectiveStop)
            && !self.was_refused
        {
            return Err(stop.into());
        }
        for _ in 0..LOOKS {
            if self.advance()? == Recovery::Over {
                return Ok(());
            }
            self.wire.wait();
            self.hear(Duration::ZERO).map_err(lost)?;
        }
        Err(self.stop().map_or(CLOSED, DriveFault::from))
    }
}

impl<R: Robot<Joints = Six>, W: Wire> Driver<R> for Ur<W> {
    fn period(&self) -> Duration {
        PERIOD
    }

    fn pace(&self) -> Pace {
        Pace::Robot { timeout: self.settings.timeout }
    }

    fn hardware(&self) -> Option<String> {
        self.wire.hardware()
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        (self.recovery, self.is_beyond) = (ResetStage::None, false);
        let opened = self.try_open();
        if opened.is_err() {
            self.wire.disconnect();
        }
        self.was_refused = opened.is_err();
        opened
    }

    fn close(&mut self) {
        // Whether the script hears it or the connection's end changes nothing: it ends.
        self.wire.tell(&SetPoint::only(Ask::End, self.settings.read_timeout));
        self.wire.disconnect();
        self.state = None;
    }

    fn pulse(&mut self, now: Duration) -> Result<Option<Pulse>, DriveFault> {
        let Some(age) = self.hear(now).map_err(lost)? else { return Ok(None) };
        let stop = self.stop();
        let state = self.state.as_ref().ok_or(CLOSED)?;
        if let Some(stop) = stop {
            // A script that was only paused must not find set-points from before when it goes on.
            if stop::of_safety(state).or(stop::of_power(state)).is_some() {
                self.wire.hang_up();
            }
            // A stop of another cause is told as that.
            let is_refusal =
                stop.cause() == StopCause::ProgramNotRunning && self.wire.script() == Connected::Ended(None);
            return Err(self.payload.refusal().filter(|_| is_refusal).unwrap_or(stop.into()));
        }
        let count = (state.timestamp / PERIOD.as_secs_f64()).round() as u64;
        Ok(Some(Pulse { count, age }))
    }

    fn held(&self) -> Option<Six> {
        self.state.as_ref().map(|state| Six::from(state.target_q))
    }

    fn measured(&self) -> Result<Measured<Six>, DriveFault> {
        self.measured_now()
    }

    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        if self.is_beyond {
            return Err(BEYOND);
        }
        let timeout = self.settings.read_timeout;
        let demanded = (*demanded).into();
        if let Some(state) = &self.state {
            self.payload.look(state)?;
            for message in self.payload.next(state, &demanded, timeout).iter().flatten() {
                // A script that does not take it takes no set-point either.
                self.wire.tell(message);
            }
        }
        if !self.wire.tell(&SetPoint::to(&demanded, timeout)) {
            let stop = self.stop().unwrap_or(RobotStop::new(StopCause::ProgramNotRunning));
            return Err(stop.into());
        }
        self.measured_now()
    }

    fn channels(&self) -> Channels {
        outputs::CHANNELS
    }

    fn signals(&self) -> Signals {
        self.state.as_ref().map_or(Signals::OFF, |state| {
            let fraction =
                |i: usize| outputs::fraction(state.analog_outputs[i], state.voltages >> (2 + i) & 1 != 0);
            Signals {
                inputs: Values::new(state.digital_inputs as u32, state.analog_inputs),
                outputs: Values::new(state.digital_outputs as u32, [fraction(0), fraction(1), 0.0, 0.0]),
            }
        })
    }

    fn switch_outputs(&mut self, told: &Outputs) {
        // The others are switched all the same: a stop may be what switches them.
        self.is_beyond |= !outputs::are_fractions(told);
        if Group::Digital.is_in(told) {
            self.wire.switch(Group::Digital, &outputs::digital_bytes(told));
        }
        if Group::Analog.is_in(told) {
            let voltages = self.state.as_ref().map_or(0, |state| (state.voltages >> 2 & 0b11) as u8);
            self.wire.switch(Group::Analog, &outputs::analog_bytes(told, voltages));
        }
    }

    fn declare_outputs(&mut self, named: &Outputs, when_lost: &Outputs) {
        (self.switches, self.when_lost) = (Groups::of(named), *when_lost);
    }

    /// The script tells the controller when the arm stands. Where nothing is said of a load, that of its installation holds.
    fn carry(&mut self, load: &Load) {
        self.payload.carry(load);
    }

    fn load_time(&self) -> Duration {
        payload::time(self.settings.lookahead)
    }

    fn motor_currents(&self) -> Option<Six> {
        self.state.as_ref().map(|state| Six::from(state.actual_current))
    }

    fn calibration(&mut self) -> Result<Option<String>, DriveFault> {
        let model = self.settings.model;
        self.wire.calibration().map_err(lost).map(|calibration| Some(calibration.text(model)))
    }

    /// What the controller measures, by a sensor in the flange: without the weight of the payload that it knows.
    fn wrench(&self) -> Option<Wrench> {
        let state = self.state.as_ref()?;
        Some(state.flange_wrench(&self.arm.as_ref()?.forward(&Six::from(state.actual_q))))
    }

    /// The slider of the pendant.
    fn speed_scaling(&self) -> f64 {
        self.state.as_ref().map_or(1.0, |state| state.speed_fraction.clamp(0.0, 1.0))
    }

    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        self.advance()
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.is_beyond = false;
        self.stop().map_or(Ok(()), |stop| Err(stop.into()))
    }
}
