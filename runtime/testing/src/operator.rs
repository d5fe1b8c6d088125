//! Random operators: many runs of a cell whose operator presses what comes to hand, each checked in every servo period.
//!
//! In: a cell for each seed. Out: what its drives should not have got, stops that took longer than the cell says, and
//! stops that nobody asked for.

use core::fmt;
use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use super::motion_monitor::{Bounds, MotionMonitor};
use super::random::Random;
use mrroc_core::cell::{AfterFault, Cell, CellError};
use mrroc_core::fault::{BY_OPERATOR, Fault, FaultKind, Name};
use mrroc_core::link::Nanos;
use mrroc_core::operator::jog::{JogMotion, JogOrder};
use mrroc_core::operator::{Latch, Operator, Renewal};

/// Runs a cell again and again under a random operator, who suspends and resumes it, changes its speed, aborts, stops it and
/// resets it in random steps.
///
/// In every run, all demands of all drives are checked: finite, within the limits of position, velocity, acceleration and
/// jerk, and so continuous. Every protective stop, suspension and abort must be over in the time that the cell says
/// ([`Cell::stop_limit`], [`Cell::path_stop_time`]). A fault that stops the cell by itself is a false stop if nothing is
/// wrong with its programs; it is counted. The same seed gives the same run.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::fault::FaultKind;
/// use mrroc::testing::RandomOperator;
/// use mrroc_robots::{Irp6, SimulatedIrp6};
///
/// /// Turns the column to and fro by 0.1 rad, once in a second.
/// struct Sway { t: f64 }
///
/// #[generator(mp)]
/// fn sway(c: &mut Sway, t: Tick) -> Step<(Irp6,)> {
///     c.t += t.dt;
///     let mut q = Irp6::READY;
///     // (1 - cos u)² / 4 begins without acceleration.
///     let u = core::f64::consts::TAU * c.t;
///     q[0] += 0.025 * (1.0 - u.cos()).powi(2);
///     Step::Next((Demand::joints(q),))
/// }
///
/// let report = RandomOperator::new(|_seed| {
///     let arm = SimulatedIrp6::new(Irp6::nominal(), &Irp6::READY);
///     Cell::new(std::time::Duration::from_millis(2))
///         .robot(RobotSetup::new("irp6", Irp6::nominal(), arm))
///         .program(|mp| {
///             let mut irp6 = mp.robot::<Irp6>("irp6")?;
///             // Ended by an abort: where it is, the robot waits for the operator's stop.
///             match mp.move_robots((&mut irp6,), (), Sway { t: 0.0 }) {
///                 Err(fault) if fault.kind() == FaultKind::Aborted => Ok(()),
///                 ended => ended.map(drop),
///             }
///         })
/// })
/// .runs(3)
/// .steps(400)
/// .run();
/// assert!(report.is_clean() && report.false_stops().is_empty(), "{report}");
/// ```
pub struct RandomOperator<B> {
    cell: B,
    runs: u64,
    seed: u64,
    steps: u64,
    by_hand: Option<Vec<Name>>,
}

impl<B: FnMut(u64) -> Cell> RandomOperator<B> {
    /// For the cell that `cell` makes of a run's seed.
    #[must_use]
    pub const fn new(cell: B) -> Self {
        RandomOperator { cell, runs: 100, seed: 1, steps: 2000, by_hand: None }
    }

    /// The number of runs; 100 if nothing is said.
    #[must_use]
    pub const fn runs(mut self, runs: u64) -> Self {
        self.runs = runs;
        self
    }

    /// The seed of the first run, from which those of the others are counted; 1 if nothing is said.
    #[must_use]
    pub const fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// The step in which the operator ends a run that has not ended before; 2000 if nothing is said.
    #[must_use]
    pub const fn steps(mut self, steps: u64) -> Self {
        self.steps = steps;
        self
    }

    /// Lets the operator work at reduced speed, where he holds and lets go instead of suspending and resuming: the joints of one of
    /// these robots at a time, which he jogs, or with none of them what the programs do.
    #[must_use]
    pub fn holding(self, jogged: impl IntoIterator<Item = Name>) -> Self {
        RandomOperator { by_hand: Some(jogged.into_iter().collect()), ..self }
    }

    /// Runs all.
    pub fn run(mut self) -> OperatorReport {
        let mut report = OperatorReport::default();
        for seed in self.seed..self.seed.saturating_add(self.runs) {
            report.runs += 1;
            let by_hand = self.by_hand.clone().map(|jogged| ByHand { jogged, held: None });
            run(seed, (self.cell)(seed), (self.steps, by_hand), &mut report);
        }
        report
    }
}

/// What random operators have found. Its display is a few lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OperatorReport {
    runs: u64,
    periods: u64,
    presses: u64,
    stops: u64,
    /// Of each kind of stop, the one that used the largest share of its bound \[steps\].
    worst: [(u64, u64); Pressed::NAMES.len()],
    false_stops: Vec<String>,
    failures: Vec<String>,
}

impl OperatorReport {
    /// Whether no drive got what it should not, and no stop took longer than it may.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.failures.is_empty()
    }

    /// The stops that nobody asked for, with their seeds.
    #[must_use]
    pub fn false_stops(&self) -> &[String] {
        &self.false_stops
    }

    /// What was wrong, with the seeds.
    #[must_use]
    pub fn failures(&self) -> &[String] {
        &self.failures
    }

    /// The servo periods that were checked.
    #[must_use]
    pub const fn periods(&self) -> u64 {
        self.periods
    }
}

impl fmt::Display for OperatorReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let OperatorReport { runs, periods, presses, stops, worst, false_stops, failures } = self;
        writeln!(f, "{runs} runs, {periods} servo periods, {presses} presses, {stops} stops")?;
        for ((steps, bound), what) in worst.iter().zip(Pressed::NAMES) {
            writeln!(f, "longest {what}: {steps} steps, bound {bound}")?;
        }
        writeln!(f, "false stops: {}", false_stops.len())?;
        false_stops.iter().take(10).try_for_each(|text| writeln!(f, "  {text}"))?;
        writeln!(f, "failures: {}", failures.len())?;
        failures.iter().take(10).try_for_each(|text| writeln!(f, "  {text}"))
    }
}

/// What was pressed and is to bring the robots to a standstill.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pressed {
    Stop,
    Suspend,
    Abort,
    LetGo,
}

impl Pressed {
    const NAMES: [&str; 4] = ["stop", "suspension", "abort", "end of a hold"];
}

/// What an operator at reduced speed does.
struct ByHand {
    jogged: Vec<Name>,
    held: Option<(Renewal, Option<(Name, JogOrder)>)>,
}

impl ByHand {
    /// Holds on, lets go or begins another hold; whether he has just let go, or has begun.
    fn hold(&mut self, step: u64, random: &mut Random, operator: &Operator) -> Option<bool> {
        operator.set_reduced(true);
        let Some((renewal, jog)) = self.held else {
            if random.below(60) != 0 {
                return None;
            }
            let of = usize::try_from(random.below(self.jogged.len().max(1) as u64)).unwrap_or(0);
            let speed = (0.1 + 0.9 * random.below(1 << 20) as f64 / f64::from(1 << 20))
                * if random.below(2) == 0 { 1.0 } else { -1.0 };
            let joint = random.below(3) as u8;
            let order = JogOrder { motion: JogMotion::Joint { joint }, speed, distance: None };
            self.held = Some((Renewal::first(step), self.jogged.get(of).map(|name| (*name, order))));
            return Some(false);
        };
        match jog {
            Some((robot, order)) => operator.jog(renewal, robot, order),
            None => operator.renew_hold(renewal),
        }
        let lets_go = random.below(250) == 0;
        if lets_go {
            operator.let_go(renewal.hold());
        }
        self.held = if lets_go { None } else { renewal.next().map(|next| (next, jog)) };
        lets_go.then_some(true)
    }
}

/// One operator.
struct Pressing {
    random: Random,
    last_step: u64,
    by_hand: Option<ByHand>,
    /// What was pressed in which step, and is not over.
    pending: [Option<u64>; Pressed::NAMES.len()],
    /// Their bounds \[steps\].
    bounds: [u64; Pressed::NAMES.len()],
    presses: u64,
    worst: [(u64, u64); Pressed::NAMES.len()],
    late: Option<String>,
}

impl Pressing {
    fn press(&mut self, step: u64, operator: &Operator) {
        if step == self.last_step {
            operator.give_up();
            operator.protective_stop();
            return;
        }
        if operator.latch() != Latch::Clear {
            self.by_hand.iter_mut().for_each(|by_hand| by_hand.held = None);
            if self.random.below(10) == 0 {
                // Both may be refused: too early, or something persists.
                let _ = operator.acknowledge();
                let _ = operator.reset();
            }
            return;
        }
        if let Some(by_hand) = &mut self.by_hand
            && let Some(lets_go) = by_hand.hold(step, &mut self.random, operator)
        {
            self.presses += 1;
            self.pending[Pressed::LetGo as usize] = lets_go.then_some(step);
        }
        if self.random.below(50) != 0 {
            return;
        }
        self.presses += 1;
        match self.random.below(12) {
            0..=6 if self.by_hand.is_some() => {}
            0..=2 => {
                operator.suspend();
                self.pending[Pressed::Suspend as usize].get_or_insert(step);
            }
            3..=6 => {
                operator.resume();
                self.pending[Pressed::Suspend as usize] = None;
            }
            7..=9 => {
                // Full speed as often as all others: a rate that changes has least room there.
                let share = self.random.below(1 << 21) as f64 / f64::from(1 << 20);
                let _ = operator.set_speed(0.1 + 0.9 * share.min(1.0));
            }
            10 => {
                operator.abort();
                if operator.is_aborting() {
                    self.pending[Pressed::Abort as usize].get_or_insert(step);
                }
            }
            _ => {
                operator.protective_stop();
                self.pending[Pressed::Stop as usize].get_or_insert(step);
            }
        }
    }

    /// Checks what is under way; `moved` is the last step in which a robot moved.
    fn check(&mut self, step: u64, operator: &Operator, moved: u64) {
        let latched = operator.latch() != Latch::Clear;
        for pressed in [Pressed::Stop, Pressed::Suspend, Pressed::Abort, Pressed::LetGo] {
            let place = pressed as usize;
            let Some(began) = self.pending[place] else { continue };
            let is_over = match pressed {
                Pressed::Stop => latched,
                Pressed::Suspend | Pressed::LetGo => latched || step > began + self.bounds[place],
                Pressed::Abort => latched || !operator.is_aborting(),
            };
            let bound = self.bounds[place];
            // While it lasts the robots move, and after it they do not.
            let steps = match pressed {
                Pressed::Suspend | Pressed::LetGo => moved.saturating_sub(began),
                Pressed::Stop | Pressed::Abort => step - began,
            };
            if steps > bound && self.late.is_none() {
                let name = Pressed::NAMES[place];
                self.late = Some(format!("{name} of step {began} is not over after {bound} steps"));
            }
            if steps * self.worst[place].1.max(1) > self.worst[place].0 * bound && steps <= bound {
                self.worst[place] = (steps, bound);
            }
            if is_over || steps > bound {
                self.pending[place] = None;
            }
        }
    }
}

fn run(seed: u64, mut cell: Cell, (last_step, by_hand): (u64, Option<ByHand>), report: &mut OperatorReport) {
    let failed =
        |report: &mut OperatorReport, what: &str| report.failures.push(format!("seed {seed}: {what}"));
    if let Err(error) = cell.check() {
        return failed(report, &error.to_string());
    }
    let step = cell.step_length();
    let nanos = step.as_nanos() as Nanos;
    let layout = cell.layout();
    let slowest = layout.robots.iter().map(|robot| robot.servo).max().unwrap_or_default();
    // What drives lag behind their demands, and two steps for the order and its answer.
    let more = steps(2 * step + 2 * slowest, step) + 2;
    let on_path = steps(cell.path_stop_time(), step) + more;
    let stop = steps(cell.stop_limit(), step).max(cell.stop_steps()) + more;
    let monitors: Rc<[RefCell<MotionMonitor>]> = layout
        .robots
        .iter()
        .map(|robot| RefCell::new(MotionMonitor::new(&robot.name, Bounds::of(robot).with_jerk(robot, step))))
        .collect();
    let seeing = Rc::clone(&monitors);
    let pressing = Rc::new(RefCell::new(Pressing {
        random: Random::new(seed),
        last_step,
        by_hand,
        pending: [None; 4],
        bounds: [stop, on_path, on_path, on_path],
        presses: 0,
        worst: [(0, 1); 4],
        late: None,
    }));
    let pressed = Rc::clone(&pressing);
    let stood = Rc::clone(&monitors);
    let causes: Rc<RefCell<Vec<Fault>>> = Rc::default();
    let latching = Rc::clone(&causes);
    let mut was_told = false;
    let outcome = cell
        .watch(move |seen| {
            let end = (seen.time * 1e9).round() as Nanos;
            let of_robot = seeing.iter().find(|monitor| monitor.borrow().name == seen.robot);
            of_robot.into_iter().for_each(|monitor| monitor.borrow_mut().see(end, seen.demanded));
        })
        .also_on_step(move |step, operator| {
            let moved = stood.iter().map(|monitor| monitor.borrow().stood()).max().unwrap_or(0);
            let mut pressing = pressed.borrow_mut();
            pressing.check(step, operator, moved.div_ceil(nanos));
            // It is told once the robots stand.
            let cause = operator.fault();
            let is_told = cause.is_some();
            if !was_told {
                latching.borrow_mut().extend(cause);
            }
            was_told = is_told;
            pressing.press(step, operator);
        })
        .after_fault(AfterFault::AwaitReset)
        .run();
    let pressing = pressing.borrow();
    report.presses += pressing.presses;
    for (worst, own) in report.worst.iter_mut().zip(pressing.worst) {
        if own.0 * worst.1.max(1) > worst.0 * own.1 {
            *worst = own;
        }
    }
    for monitor in monitors.iter() {
        let monitor = monitor.borrow();
        report.periods += monitor.ticks();
        if let Some(wrong) = &monitor.wrong {
            failed(report, wrong);
        }
    }
    if let Some(late) = &pressing.late {
        failed(report, late);
    }
    let mut causes = causes.borrow().clone();
    match outcome {
        Ok(_) => {}
        Err(CellError::Fault(fault)) => causes.push(fault),
        Err(error) => failed(report, &error.to_string()),
    }
    report.stops += causes.len() as u64;
    causes.retain(|fault| {
        // Where no program goes on after an abort, the run is over.
        fault.kind() != FaultKind::Aborted
            && !(fault.kind() == FaultKind::ProtectiveStop && fault.message().starts_with(BY_OPERATOR))
    });
    // What ends the run has been told when it was latched.
    causes.dedup();
    report.false_stops.extend(causes.iter().map(|fault| format!("seed {seed}: {fault}")));
}

/// Steps of this length in a time, rounded up.
fn steps(time: Duration, step: Duration) -> u64 {
    u64::try_from(time.as_nanos().div_ceil(step.as_nanos().max(1))).unwrap_or(u64::MAX)
}
