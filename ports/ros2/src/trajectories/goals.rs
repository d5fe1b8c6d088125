//! Goals and what becomes of them, apart from how they come and where they are told.
//!
//! In: requests and cancellations of other nodes, what the cell's program says of goals, where the robots are, the time. Out: what the cell's sensor is told,
//! the status of each goal, feedback and results.
//!
//! ```text
//!   request ──▶ Waiting ──▶ Sent ──▶ Working ──▶ Settling ──▶ Ended: succeeded, or out of tolerance
//!                  │          │         └──────────────────▶ Ended: cancelled, replaced, out of tolerance, a fault
//!                  └──────────┴────────────────────────────▶ Ended: refused, or cancelled before it began
//! ```

use mrroc_external::goals::{GoalFile, GoalNews, GoalState, MOST_ROBOTS, refusal};
use ros2_client::action_msgs::{
    CancelGoalResponse, CancelGoalResponseEnum, GoalId, GoalInfo, GoalStatus, GoalStatusEnum,
};
use ros2_client::builtin_interfaces::Time;

use super::messages::{
    Feedback, GOAL_TOLERANCE_VIOLATED, INVALID_GOAL, Outcome, PATH_TOLERANCE_VIOLATED, Point, Request,
    SUCCESSFUL,
};
use super::request::{Asked, Bounds, Offered};
use crate::messages::{Header, Stamp};

/// What is known of a robot in its newest step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Now {
    pub stamp: Stamp,
    /// Positions and velocities of the joints [rad or m, rad/s or m/s].
    pub demanded: [Vec<f64>; 2],
    pub measured: [Vec<f64>; 2],
}

/// A goal for which the cell has said nothing for so long will not be served \[ns\].
const SILENT: u64 = 1_000_000_000;

/// The time between two messages of feedback \[ns\], as in the joint trajectory controller.
const FEEDBACK: u64 = 50_000_000;

/// For how long the result of a goal can be asked for \[ns\].
const KEPT: u64 = 60_000_000_000;

/// Goals that are looked after at a time, and those that have ended and are kept; more are rejected, or forgotten.
const MOST: usize = 100;

/// Where a goal is.
enum Phase {
    /// It is not with the cell yet.
    Waiting,
    /// Its file is there, for the cell to take it, and goes with this.
    Sent { _file: GoalFile },
    /// The robots follow it.
    Working,
    /// They were told to get to its end, at this time \[ns\].
    Settling(u64),
    /// At this time \[ns\].
    Ended(u64),
}

struct Entry {
    server: usize,
    info: GoalInfo,
    status: GoalStatusEnum,
    phase: Phase,
    /// The number by which the cell knows it.
    number: u64,
    asked: Option<Asked>,
    /// What it ends with; of one that is at work, why it is halted.
    outcome: Option<Outcome>,
    /// When feedback is due \[ns\].
    due: u64,
}

/// All goals.
pub struct Goals {
    offered: Offered,
    entries: Vec<Entry>,
    /// The last one that the cell was told of.
    newest: u64,
    state: Option<GoalState>,
    /// When the cell said something last \[ns\].
    heard: u64,
    /// Servers whose goals have another status now.
    changed: Vec<usize>,
}

/// What is to be told to other nodes.
pub struct Told {
    /// Of a server's goal.
    pub feedback: Vec<(usize, GoalId, Feedback)>,
    /// All goals of a server, where one has another status.
    pub statuses: Vec<(usize, Vec<GoalStatus>)>,
}

fn outcome(error_code: i32, why: impl Into<String>) -> Outcome {
    Outcome { error_code, error_string: why.into(), is_elsewhere: false }
}

impl Goals {
    pub const fn new(offered: Offered) -> Goals {
        Goals { offered, entries: Vec::new(), newest: 0, state: None, heard: 0, changed: Vec::new() }
    }

    /// A request to a server, whose robot is `only` or any; whether it is looked at. What is wrong with it is its result.
    pub fn request(
        &mut self,
        server: usize,
        only: Option<usize>,
        id: GoalId,
        request: &Request,
        [now, since_1970]: [u64; 2],
    ) -> bool {
        let is_known = self.entries.iter().any(|entry| entry.info.goal_id == id);
        let (ended, at_work): (Vec<_>, Vec<_>) =
            (0..self.entries.len()).partition(|&k| self.entries[k].has_ended());
        if is_known || at_work.len() >= MOST {
            return false;
        }
        if ended.len() >= MOST {
            self.entries.remove(ended[0]);
        }
        let asked = self.offered.read(request, only, since_1970);
        let mut entry = Entry {
            server,
            info: GoalInfo { goal_id: id, stamp: Time::from_nanos(since_1970.cast_signed()) },
            status: GoalStatusEnum::Accepted,
            phase: Phase::Waiting,
            number: 0,
            asked: None,
            outcome: None,
            due: 0,
        };
        match asked {
            Ok(asked) => entry.asked = Some(asked),
            Err(why) => entry.end(GoalStatusEnum::Aborted, why, now),
        }
        self.changed.push(server);
        self.entries.push(entry);
        true
    }

    /// A cancellation at a server: of one goal, of all, or of those before a time.
    pub fn cancel(&mut self, server: usize, of: &GoalInfo) -> CancelGoalResponse {
        let is_all = of.goal_id == GoalId::ZERO;
        let before = (of.stamp != Time::ZERO).then_some(of.stamp);
        let mut goals_canceling = Vec::new();
        let mut has_ended = false;
        let ours = self.entries.iter_mut().filter(|entry| entry.server == server);
        for entry in ours {
            let is_it = entry.info.goal_id == of.goal_id
                || before.is_some_and(|before| entry.info.stamp <= before)
                || (is_all && before.is_none());
            if !is_it {
                continue;
            }
            if entry.has_ended() {
                has_ended |= entry.info.goal_id == of.goal_id;
                continue;
            }
            entry.status = GoalStatusEnum::Canceling;
            goals_canceling.push(entry.info.clone());
        }
        self.changed.push(server);
        let return_code = match (goals_canceling.is_empty(), has_ended, is_all) {
            (false, ..) => CancelGoalResponseEnum::None,
            (true, true, _) => CancelGoalResponseEnum::GoalTerminated,
            (true, false, true) => CancelGoalResponseEnum::Rejected,
            (true, false, false) => CancelGoalResponseEnum::UnknownGoal,
        };
        CancelGoalResponse { return_code, goals_canceling }
    }

    /// The result of a goal, if it has ended; `Err` where there is no such goal.
    pub fn result(&self, id: GoalId) -> Result<Option<(GoalStatusEnum, Outcome)>, ()> {
        let entry = self.entries.iter().find(|entry| entry.info.goal_id == id).ok_or(())?;
        Ok(entry.outcome.clone().filter(|_| entry.has_ended()).map(|outcome| (entry.status, outcome)))
    }

    /// What the cell's program says.
    pub fn hear(&mut self, state: GoalState, now: u64) {
        self.state = Some(state);
        self.heard = now;
    }

    /// Whether a cell says at this time of the machine's monotonic clock \[ns\] that its program takes goals.
    pub fn is_heard(&self, now: u64) -> bool {
        self.state.is_some() && now.saturating_sub(self.heard) <= SILENT
    }

    /// What the cell's sensor is to be told.
    pub fn news(&self) -> GoalNews {
        let mut news = GoalNews { newest: self.newest, ..GoalNews::default() };
        // Also one that was given up while the cell was silent, if its robots follow it still.
        let follows = |entry: &Entry| self.state.is_some_and(|state| state.ended(entry.number).is_none());
        let halted = self.entries.iter().filter(|entry| match entry.phase {
            Phase::Working | Phase::Sent { .. } => {
                entry.status == GoalStatusEnum::Canceling || entry.outcome.is_some()
            }
            Phase::Ended(_) => entry.number != 0 && follows(entry),
            Phase::Waiting | Phase::Settling(_) => false,
        });
        for (cancelled, entry) in news.cancelled.iter_mut().take(MOST_ROBOTS).zip(halted) {
            *cancelled = entry.number;
        }
        news
    }

    /// Goes on at a time of the machine's monotonic clock \[ns\], with what is known of each robot of the layout, and the cell's fault.
    pub fn advance(&mut self, now: u64, robots: &[Option<Now>], fault: Option<&str>) -> Told {
        let mut feedback = Vec::new();
        for place in 0..self.entries.len() {
            if self.entries[place].has_ended() {
                continue;
            }
            let status = self.entries[place].status;
            match (fault, now.saturating_sub(self.heard) > SILENT) {
                (Some(fault), _) => self.entries[place].end(
                    GoalStatusEnum::Aborted,
                    outcome(INVALID_GOAL, format!("the cell has stopped: {fault}")),
                    now,
                ),
                (None, true) => self.entries[place].end(
                    GoalStatusEnum::Aborted,
                    outcome(INVALID_GOAL, "no cell is running whose program takes goals now"),
                    now,
                ),
                (None, false) => feedback.extend(self.go_on(place, now, robots)),
            }
            if self.entries[place].status != status {
                self.changed.push(self.entries[place].server);
            }
        }
        let old = |entry: &Entry| matches!(entry.phase, Phase::Ended(at) if now.saturating_sub(at) > KEPT);
        self.entries.retain(|entry| !old(entry));
        self.changed.sort_unstable();
        self.changed.dedup();
        let of = |server: usize| {
            let ours = self.entries.iter().filter(|entry| entry.server == server);
            ours.map(|entry| GoalStatus { goal_info: entry.info.clone(), status: entry.status }).collect()
        };
        let statuses = self.changed.iter().map(|&server| (server, of(server))).collect();
        self.changed.clear();
        Told { feedback, statuses }
    }

    /// Goes on with a goal that has not ended; feedback of it, where that is due.
    fn go_on(&mut self, place: usize, now: u64, robots: &[Option<Now>]) -> Option<(usize, GoalId, Feedback)> {
        let state = self.state?;
        match self.entries[place].phase {
            Phase::Waiting => self.send(place, now, robots),
            Phase::Sent { .. } => self.await_answer(place, now, &state),
            Phase::Working => return self.watch(place, now, &state, robots),
            Phase::Settling(since) => self.settle(place, now, since, robots),
            Phase::Ended(_) => {}
        }
        None
    }

    /// Gives a goal to the cell, one after the other.
    fn send(&mut self, place: usize, now: u64, robots: &[Option<Now>]) {
        if self.entries[place].status == GoalStatusEnum::Canceling {
            let why = outcome(SUCCESSFUL, "cancelled before it began");
            return self.entries[place].end(GoalStatusEnum::Canceled, why, now);
        }
        if self.entries.iter().any(|entry| matches!(entry.phase, Phase::Sent { .. })) {
            return;
        }
        let Some(asked) = &self.entries[place].asked else { return };
        if asked.robots.iter().any(|&robot| robots.get(robot).is_none_or(Option::is_none)) {
            let why = "the cell shows no robots: is it shown at the port of the bridge?";
            return self.entries[place].end(GoalStatusEnum::Aborted, outcome(INVALID_GOAL, why), now);
        }
        let refused = match self.at_rest(asked, robots) {
            Some(at) => self.offered.check(asked, &at).err(),
            None => None,
        };
        let written = match refused {
            Some(why) => Err(why),
            None => GoalFile::write(&asked.goal).map_err(|why| outcome(INVALID_GOAL, why)),
        };
        let entry = &mut self.entries[place];
        match written {
            Ok(file) => {
                entry.number = file.number();
                self.newest = file.number();
                entry.phase = Phase::Sent { _file: file };
            }
            Err(why) => entry.end(GoalStatusEnum::Aborted, why, now),
        }
    }

    /// Where the joints of a goal are, if all its robots rest. Of others the cell itself sees whether they can begin.
    fn at_rest(&self, asked: &Asked, robots: &[Option<Now>]) -> Option<Vec<f64>> {
        let mut at = Vec::new();
        for &robot in &asked.robots {
            let [positions, velocities] = &robots.get(robot)?.as_ref()?.demanded;
            if velocities.iter().any(|velocity| *velocity != 0.0) {
                return None;
            }
            at.extend_from_slice(positions);
        }
        Some(at)
    }

    fn await_answer(&mut self, place: usize, now: u64, state: &GoalState) {
        let entry = &mut self.entries[place];
        if state.taken != entry.number {
            return;
        }
        if state.refusal == 0 {
            entry.phase = Phase::Working;
            if entry.status == GoalStatusEnum::Accepted {
                entry.status = GoalStatusEnum::Executing;
            }
            return;
        }
        let robots = entry.asked.as_ref().map_or(Vec::new(), |asked| asked.robots.clone());
        let is_elsewhere = state.refusal == refusal::START;
        let why = Outcome { is_elsewhere, ..outcome(INVALID_GOAL, self.offered.refusal(state, &robots)) };
        self.entries[place].end(GoalStatusEnum::Aborted, why, now);
    }

    fn watch(
        &mut self,
        place: usize,
        now: u64,
        state: &GoalState,
        robots: &[Option<Now>],
    ) -> Option<(usize, GoalId, Feedback)> {
        let entry = &mut self.entries[place];
        if state.taken < entry.number || state.refusal == refusal::OLD {
            let why = outcome(INVALID_GOAL, "the cell's program has begun anew");
            entry.end(GoalStatusEnum::Aborted, why, now);
            return None;
        }
        let asked = entry.asked.as_ref()?;
        match state.ended(entry.number) {
            None => {
                let joints = Joints::of(asked, robots)?;
                if entry.outcome.is_none()
                    && let Some(why) = joints.beyond(&asked.path)
                {
                    entry.outcome = Some(outcome(PATH_TOLERANCE_VIOLATED, why));
                }
                if now < entry.due {
                    return None;
                }
                entry.due = now + FEEDBACK;
                return Some((entry.server, entry.info.goal_id, joints.feedback(asked)));
            }
            Some(done) => {
                let replaced = !state.goals.contains(&entry.number);
                match (entry.outcome.take(), done) {
                    (Some(why), _) => entry.end(GoalStatusEnum::Aborted, why, now),
                    (None, true) if entry.status != GoalStatusEnum::Canceling => {
                        entry.phase = Phase::Settling(now)
                    }
                    (None, false) if replaced && entry.status != GoalStatusEnum::Canceling => {
                        entry.end(
                            GoalStatusEnum::Aborted,
                            outcome(INVALID_GOAL, "replaced by a newer goal"),
                            now,
                        );
                    }
                    (None, _) if entry.status == GoalStatusEnum::Canceling => {
                        entry.end(
                            GoalStatusEnum::Canceled,
                            outcome(SUCCESSFUL, "cancelled: the robots rest on their path"),
                            now,
                        );
                    }
                    (None, _) => entry.end(
                        GoalStatusEnum::Aborted,
                        outcome(INVALID_GOAL, "the cell's program moves the robots otherwise"),
                        now,
                    ),
                }
            }
        }
        None
    }

    fn settle(&mut self, place: usize, now: u64, since: u64, robots: &[Option<Now>]) {
        let entry = &mut self.entries[place];
        let Some(asked) = &entry.asked else { return };
        let Some(joints) = Joints::of(asked, robots) else { return };
        if entry.status == GoalStatusEnum::Canceling {
            return entry.end(GoalStatusEnum::Canceled, outcome(SUCCESSFUL, "cancelled at its end"), now);
        }
        match joints.beyond(&asked.end) {
            None => entry.end(GoalStatusEnum::Succeeded, outcome(SUCCESSFUL, ""), now),
            Some(why) if now.saturating_sub(since) as f64 * 1e-9 >= asked.time => {
                entry.end(GoalStatusEnum::Aborted, outcome(GOAL_TOLERANCE_VIOLATED, why), now);
            }
            Some(_) => {}
        }
    }
}

impl Entry {
    const fn has_ended(&self) -> bool {
        matches!(self.phase, Phase::Ended(_))
    }

    fn end(&mut self, status: GoalStatusEnum, outcome: Outcome, now: u64) {
        self.status = status;
        self.outcome = Some(outcome);
        self.phase = Phase::Ended(now);
    }
}

/// The joints of a goal now, one robot behind the other.
struct Joints {
    stamp: Stamp,
    demanded: [Vec<f64>; 2],
    measured: [Vec<f64>; 2],
    names: Vec<String>,
}

impl Joints {
    fn of(asked: &Asked, robots: &[Option<Now>]) -> Option<Joints> {
        let mut joints = Joints {
            stamp: Stamp::default(),
            demanded: Default::default(),
            measured: Default::default(),
            names: Vec::new(),
        };
        for &robot in &asked.robots {
            let now = robots.get(robot)?.as_ref()?;
            joints.stamp = joints.stamp.max(now.stamp);
            for k in 0..2 {
                joints.demanded[k].extend_from_slice(&now.demanded[k]);
                joints.measured[k].extend_from_slice(&now.measured[k]);
            }
        }
        joints.names = vec![String::new(); joints.demanded[0].len()];
        for (name, place) in &asked.names {
            joints.names.get_mut(*place)?.clone_from(name);
        }
        Some(joints)
    }

    /// The first joint that is farther from where it is to be than it may.
    fn beyond(&self, bounds: &[Bounds]) -> Option<String> {
        let of = |bounds: &Bounds| [bounds.position, bounds.velocity];
        for (joint, bounds) in bounds.iter().enumerate() {
            for (k, (what, bound)) in ["position", "velocity"].into_iter().zip(of(bounds)).enumerate() {
                let off = self.demanded[k][joint] - self.measured[k][joint];
                if off.abs() > bound {
                    let name = &self.names[joint];
                    return Some(format!(
                        "joint `{name}`: {what} off by {off:.6}, its tolerance is {bound:.6}"
                    ));
                }
            }
        }
        None
    }

    /// In the order in which the joints were named.
    fn feedback(&self, asked: &Asked) -> Feedback {
        let sorted = |values: &[f64]| asked.names.iter().map(|(_, place)| values[*place]).collect::<Vec<_>>();
        let point = |[positions, velocities]: &[Vec<f64>; 2]| Point {
            positions: sorted(positions),
            velocities: sorted(velocities),
            ..Point::default()
        };
        let (desired, actual) = (point(&self.demanded), point(&self.measured));
        let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
        let error = Point {
            positions: less(&desired.positions, &actual.positions),
            velocities: less(&desired.velocities, &actual.velocities),
            ..Point::default()
        };
        Feedback {
            header: Header { stamp: self.stamp, frame_id: String::new() },
            joint_names: asked.names.iter().map(|(name, _)| name.clone()).collect(),
            desired,
            actual,
            error,
            ..Feedback::default()
        }
    }
}
