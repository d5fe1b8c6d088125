//! A controller in the process of the cell, on a clock that goes with the cell's.
//!
//! In: set-points, scripts and commands of a driver. Out: its states. All of it passes through the bytes of its protocols. For
//! the virtual clock: the controller goes on when its driver asks what has come.

use core::cell::RefCell;
use core::time::Duration;
use std::collections::VecDeque;
use std::net::{Ipv4Addr, SocketAddr};
use std::rc::Rc;

use mrroc_ur::outputs::{Group, Groups};
use mrroc_ur::rtde::{Answer, Package, Request};
use mrroc_ur::{
    Calibration, Connected, ConnectionLost, Job, JobState, SetPoint, State, TimedState, Wire, primary,
    recipe_names,
};

use crate::controller::Controller;
use crate::session::Session;

/// Where its script calls: nobody is there, and nobody is called.
const REVERSE: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 50001);

/// Which set-points the network loses, by their count from 0.
type Loses = Box<dyn Fn(u64) -> bool>;

/// A connection with a controller in the same process.
///
/// ```
/// use std::cell::RefCell;
/// use std::rc::Rc;
/// use mrroc_robots::Six;
/// use mrroc_ur::{Ur, UrModel, UrSettings};
/// use mrroc_ur_controller::{Controller, Inside};
///
/// let start = Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0);
/// let controller = Rc::new(RefCell::new(Controller::new(UrModel::Ur5e, &start)?));
/// let wire = Inside::new(Rc::clone(&controller));
/// let settings = UrSettings::new(UrModel::Ur5e, "127.0.0.1".parse()?, "127.0.0.1:50001".parse()?);
/// let drives = Ur::over(wire, settings); // for `RobotSetup::new("arm", arm, drives)`
/// # drop(drives);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Inside {
    controller: Rc<RefCell<Controller>>,
    session: Option<Session>,
    /// When its next period begins by the cell's clock, and how long it is \[s\].
    next: f64,
    period: f64,
    heard: VecDeque<(f64, State)>,
    connected: Connected,
    job: Option<Job>,
    /// The recipes by which its driver switches outputs of the groups.
    written: [Option<u8>; 2],
    told: u64,
    loses: Loses,
    is_deaf: bool,
}

impl core::fmt::Debug for Inside {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Inside").field("controller", &self.controller).finish_non_exhaustive()
    }
}

impl Inside {
    /// A connection that loses nothing, with a controller whose clock goes as the cell's.
    #[must_use]
    pub fn new(controller: Rc<RefCell<Controller>>) -> Inside {
        Inside {
            controller,
            session: None,
            next: 0.0003,
            period: 0.002,
            heard: VecDeque::new(),
            connected: Connected::NotYet,
            job: None,
            written: [None; 2],
            told: 0,
            loses: Box::new(|_| false),
            is_deaf: false,
        }
    }

    /// The same with a controller whose clock is slow by this part of it, such as 5e-5.
    #[must_use]
    pub fn slow_by(mut self, rate: f64) -> Inside {
        self.period *= 1.0 + rate;
        self
    }

    /// The same with a network that loses set-points, by their count from 0.
    #[must_use]
    pub fn losing(mut self, loses: impl Fn(u64) -> bool + 'static) -> Inside {
        self.loses = Box::new(loses);
        self
    }

    /// The same with a script that hears nothing of what the arm carries.
    #[must_use]
    pub fn deaf_to_loads(mut self) -> Inside {
        self.is_deaf = true;
        self
    }

    /// One period of the controller, which begins at this time of the cell \[s\].
    fn step(&mut self, at: f64) {
        let mut controller = self.controller.borrow_mut();
        if let (Some(Job::Offer(script)), Some(_)) = (&self.job, controller.asks()) {
            controller.take_answer(script);
        }
        controller.step();
        if controller.calls().is_some() {
            let awaited = matches!(self.job, Some(Job::Start(_) | Job::Offer(_)));
            controller.connected(awaited);
            if awaited {
                self.connected = Connected::Yes;
            }
        }
        if let Some(ended) = controller.says() {
            self.connected = Connected::Ended(Some(ended));
        }
        if self.connected == Connected::Yes && !controller.is_connected() {
            self.connected = Connected::Ended(None);
        }
        let mut bytes = Vec::new();
        if let Some(session) = &self.session {
            session.outputs(&controller, &mut bytes);
        }
        let state = read(&bytes, |answer| match answer {
            Answer::Data { values, .. } => State::read(values),
            _ => None,
        });
        self.heard.extend(state.map(|state| (at, state)));
    }

    fn ask(&mut self, request: &Request<'_>) -> Vec<u8> {
        let (mut asked, mut answer) = (Vec::new(), Vec::new());
        request.write(&mut asked);
        if let (Ok(Some((package, _))), Some(session)) = (Package::first(&asked), &mut self.session)
            && let Some(request) = Request::read(&package)
        {
            session.request(&mut self.controller.borrow_mut(), &request, &mut answer);
        }
        answer
    }
}

fn read<T>(bytes: &[u8], wanted: impl FnOnce(&Answer<'_>) -> Option<T>) -> Option<T> {
    let (package, _) = Package::first(bytes).ok()??;
    wanted(&Answer::read(&package)?)
}

impl Wire for Inside {
    fn hardware(&self) -> Option<String> {
        None
    }

    fn reverse(&self) -> SocketAddr {
        REVERSE
    }

    fn connect(&mut self, switches: Groups) -> Result<State, ConnectionLost> {
        self.session = Some(Session::new(&mut self.controller.borrow_mut()));
        let offers = self.ask(&Request::Outputs { frequency: 500.0, names: &recipe_names() });
        let offers = read(&offers, |answer| match answer {
            Answer::Outputs { offers, .. } => Answer::offers(offers),
            _ => None,
        });
        if offers.is_none_or(|offers| mrroc_ur::check_offers(&offers).is_err()) {
            return Err(ConnectionLost("the controller lacks a field of RTDE"));
        }
        for group in Group::ALL.into_iter().filter(|group| switches.has(*group)) {
            let offers = self.ask(&Request::Inputs { names: group.names() });
            let offered = read(&offers, |answer| match answer {
                Answer::Inputs { recipe, offers } => Some((*recipe, Answer::offers(offers))),
                _ => None,
            });
            let (recipe, offers) = offered.ok_or(ConnectionLost("the controller does not answer on RTDE"))?;
            group.check(&offers.unwrap_or_default()).map_err(ConnectionLost)?;
            self.written[group as usize] = Some(recipe);
        }
        self.ask(&Request::Start);
        self.heard.clear();
        self.step(0.0);
        self.heard.pop_back().map(|(_, state)| state).ok_or(ConnectionLost("the controller tells nothing"))
    }

    fn switch(&mut self, group: Group, values: &[u8]) {
        if let Some(recipe) = self.written[group as usize] {
            self.ask(&Request::Data { recipe, values });
        }
    }

    fn calibration(&mut self) -> Result<Calibration, ConnectionLost> {
        let message = primary::with_kinematics(&self.controller.borrow().calibration());
        primary::calibration(&message).ok_or(ConnectionLost("the controller tells no calibration"))
    }

    fn disconnect(&mut self) {
        self.written = [None; 2];
        if let Some(session) = self.session.take() {
            session.end(&mut self.controller.borrow_mut());
        }
        self.hang_up();
        self.job = None;
    }

    fn heard(&mut self, now: Duration) -> Result<Option<TimedState>, ConnectionLost> {
        if self.session.is_none() {
            return Err(ConnectionLost("RTDE is not connected"));
        }
        while self.next <= now.as_secs_f64() {
            let at = self.next;
            self.step(at);
            self.next += self.period;
        }
        let age = |at: f64| Duration::from_secs_f64((now.as_secs_f64() - at).max(0.0));
        Ok(self.heard.pop_front().map(|(at, state)| TimedState { state, age: age(at) }))
    }

    fn tell(&mut self, message: &SetPoint) -> bool {
        if self.connected != Connected::Yes {
            return false;
        }
        self.told += 1;
        let is_unheard = self.is_deaf && message.load().is_some();
        if !is_unheard && !(self.loses)(self.told - 1) {
            self.controller.borrow_mut().take_set_point(&message.bytes());
        }
        true
    }

    fn script(&mut self) -> Connected {
        self.connected
    }

    fn hang_up(&mut self) {
        self.controller.borrow_mut().hung_up();
        self.connected = Connected::NotYet;
    }

    fn begin(&mut self, job: Job) {
        match &job {
            Job::Start(script) => {
                self.hang_up();
                self.controller.borrow_mut().take_script(script);
            }
            Job::Offer(_) => self.hang_up(),
            Job::Unlock => {}
        }
        self.job = Some(job);
    }

    fn job(&mut self) -> JobState {
        let Some(job) = &self.job else { return JobState::None };
        let mut controller = self.controller.borrow_mut();
        let state = match job {
            Job::Start(_) | Job::Offer(_) if self.connected == Connected::Yes => JobState::Done,
            Job::Offer(_) => JobState::Busy,
            _ if controller.dashboard("is in remote control") == "false" => JobState::Local,
            Job::Start(_) if !controller.runs() => {
                JobState::Refused("the controller does not start the script")
            }
            Job::Start(_) => JobState::Busy,
            Job::Unlock => {
                controller.dashboard("close safety popup");
                match controller.dashboard("unlock protective stop").contains("releasing") {
                    true => JobState::Done,
                    false => JobState::Busy,
                }
            }
        };
        drop(controller);
        if state != JobState::Busy {
            self.job = None;
        }
        state
    }

    fn wait(&mut self) {
        self.step(0.0);
    }
}
