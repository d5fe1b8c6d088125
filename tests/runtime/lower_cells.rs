//! Cells of cells: an MP as one robot of a higher MP.

use std::cell::{Cell as Shared, RefCell};
use std::rc::Rc;

use mrroc::cell::{AfterFault, LowerCell};
use mrroc::fault::{FaultKind, ProcessId};
use mrroc::link::memory::{Scheduler, Stuck};
use mrroc::link::{Board, Body, Client, Closed, Host, Link, Nanos, Server, Waiter};
use mrroc::operator::{Latch, Operator};
use mrroc::prelude::*;
use mrroc_doubles::{Gantry, MS, Q, Trace, fault, gantry, peaks};

/// What a cell is told.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Job {
    /// All gantries along x to `end` \[m\] within `seconds` of path time, from where they are.
    Go { end: f64, seconds: f64 },
    /// The same, but in the step of this number the program of the cell throws a fault.
    Trip { end: f64, seconds: f64, step: u64 },
    /// Nothing at all.
    Rest,
}

/// N gantries along x together, by a smoothstep.
struct Together<const N: usize> {
    end: f64,
    seconds: f64,
    trips_at: Option<u64>,
    t: f64,
    from: [f64; N],
}

#[generator(mp, first = together_start)]
fn together<const N: usize>(c: &mut Together<N>, t: Tick) -> Result<Step<[Gantry; N]>, Fault> {
    if c.trips_at == Some(t.step) {
        return Err(Fault::thrown("tripped"));
    }
    if c.t >= c.seconds {
        return Ok(Step::Done);
    }
    c.t = (c.t + t.dt).min(c.seconds);
    let u = c.t / c.seconds;
    let s = u * u * (3.0 - 2.0 * u);
    Ok(Step::Next(c.from.map(|from| Demand::joints(Q::<3>::new(from + (c.end - from) * s, 0.0, 0.0)))))
}

fn together_start<const N: usize>(
    c: &mut Together<N>,
    e: &State<[Gantry; N]>,
    t: Tick,
) -> Result<Step<[Gantry; N]>, Fault> {
    c.from = core::array::from_fn(|i| e[i].demanded().joints[0]);
    together(c, t)
}

/// A cell of N gantries that does such jobs, and the traces of its drives.
pub fn lower<const N: usize>() -> (Cell, Vec<Trace<3>>) {
    let (robots, traces): (Vec<_>, Vec<_>) = (0..N).map(|i| gantry(&format!("g{i}"))).unzip();
    let cell = robots.into_iter().fold(Cell::new(MS), Cell::robot).after_fault(AfterFault::AwaitReset);
    let cell = cell.program(|mp| {
        let mut robots = Vec::new();
        for i in 0..N {
            robots.push(mp.robot::<Gantry>(&format!("g{i}"))?);
        }
        mp.serve_all(|mp, job: Job| {
            let (end, seconds, trips_at) = match job {
                Job::Go { end, seconds } => (end, seconds, None),
                Job::Trip { end, seconds, step } => (end, seconds, Some(step)),
                Job::Rest => return Ok(()),
            };
            let mut handles = robots.iter_mut();
            let list: [_; N] = core::array::from_fn(|_| handles.next().expect("one handle per robot"));
            mp.move_robots(list, (), Together { end, seconds, trips_at, t: 0.0, from: [0.0; N] }).map(drop)
        })
    });
    (cell, traces)
}

/// One job for each cell.
struct Jobs<const N: usize>([Job; N]);

#[generator(mp)]
fn jobs<const N: usize>(c: &mut Jobs<N>) -> Always<[LowerCell; N], Job> {
    Always(c.0)
}

const fn go(end: f64, seconds: f64) -> Job {
    Job::Go { end, seconds }
}

/// Where a gantry was at the end.
fn end(trace: &Trace<3>) -> f64 {
    trace.borrow().last().map_or(f64::NAN, |q| q[0])
}

#[test]
fn a_loose_move_over_two_cells_ends_when_both_have_finished() {
    let ((press, pressed), (paint, painted)) = (lower::<2>(), lower::<1>());
    let at_end = Rc::new(Shared::new(0));
    let seen = Rc::clone(&at_end);
    let report = Cell::new(MS).cell("press", press).cell("paint", paint).program(move |mp| {
        let (mut press, mut paint) = (mp.robot::<LowerCell>("press")?, mp.robot::<LowerCell>("paint")?);
        mp.move_robots([&mut press, &mut paint], (), Jobs([go(0.4, 1.0), go(-0.3, 2.0)]))?;
        seen.set(mp.step());
        mp.move_robots([&mut press, &mut paint], (), Jobs([go(0.0, 1.0), Job::Rest])).map(drop)
    });
    let report = report.run().expect("both cells do their jobs");
    for (trace, end) in [(&pressed[0], 0.0), (&pressed[1], 0.0), (&painted[0], -0.3)] {
        let trace = trace.borrow();
        assert!((trace[trace.len() - 1][0] - end).abs() < 1e-9);
        let (v, a) = peaks(&trace, 1e-3);
        assert!(v <= 1.0 && a <= 10.0 + 1e-6, "{v} m/s, {a} m/s²");
    }
    // 2 s of the slower cell, and a few steps for each START and END.
    assert!((2000..2020).contains(&at_end.get()), "{}", at_end.get());
    assert!((3000..3040).contains(&report.steps), "{}", report.steps);
}

/// The index of the last servo period in which a gantry moved.
fn last_moved(trace: &Trace<3>) -> usize {
    let trace = trace.borrow();
    (1..trace.len()).rev().find(|&i| trace[i] != trace[i - 1]).unwrap_or(0)
}

/// Asserts that all these gantries kept their limits of velocity and acceleration.
fn keep_limits<'a>(traces: impl IntoIterator<Item = &'a Trace<3>>) {
    for trace in traces {
        let (v, a) = peaks(&trace.borrow(), 1e-3);
        assert!(v <= 1.0 + 1e-9 && a <= 10.0 + 1e-6, "{v} m/s, {a} m/s²");
    }
}

/// A plant of two cells, `press` with two gantries and `paint` with one, of which the upper program says this.
struct Two {
    cell: Cell,
    press: Operator,
    paint: Operator,
    pressed: Vec<Trace<3>>,
    painted: Vec<Trace<3>>,
}

type Handle = mrroc::generator::RobotHandle<LowerCell>;

impl Two {
    /// `change` may change the press cell before it becomes a part of the plant.
    fn with(
        change: impl FnOnce(Cell) -> Cell,
        mut program: impl FnMut(&mut Mp, &mut Handle, &mut Handle) -> Result<(), Fault> + 'static,
    ) -> Two {
        let ((press, pressed), (paint, painted)) = (lower::<2>(), lower::<1>());
        let press = change(press);
        let operators = (press.operator(), paint.operator());
        let cell = Cell::new(MS).cell("press", press).cell("paint", paint).program(move |mp| {
            let (mut press, mut paint) = (mp.robot("press")?, mp.robot("paint")?);
            program(mp, &mut press, &mut paint)
        });
        Two { cell, press: operators.0, paint: operators.1, pressed, painted }
    }

    fn of(program: impl FnMut(&mut Mp, &mut Handle, &mut Handle) -> Result<(), Fault> + 'static) -> Two {
        Two::with(|press| press, program)
    }

    /// Both cells do one job each.
    fn doing(press: Job, paint: Job) -> Two {
        Two::of(move |mp, a, b| mp.move_robots([a, b], (), Jobs([press, paint])).map(drop))
    }
}

/// The braking time of a gantry: 1 m/s by 10 m/s², in steps.
const T_B: usize = 100;

/// The steps in which gantries stop on their paths, and some for the order, its answer and the delay of the drives.
fn path_stop() -> usize {
    lower::<1>().0.path_stop_time().as_millis() as usize + 5
}

#[test]
fn fault_160_a_fault_in_a_lower_cell_is_that_of_the_upper_move_and_stops_every_cell() {
    for step in [0, 1, 300, 700] {
        let two = Two::doing(Job::Trip { end: 0.4, seconds: 1.0, step }, go(-0.4, 1.0));
        let cause = fault(two.cell.run());
        assert_eq!((cause.message(), cause.kind()), ("tripped", FaultKind::Program), "{cause}");
        assert_eq!(cause.process().map(|process| process.to_string()).as_deref(), Some("mp press"));
        let met = cause.step().expect("a fault in a step") as usize;
        keep_limits(two.pressed.iter().chain(&two.painted));
        // The cell itself within 1 + T_b; the others hear of it in the upper step after it, and stop in the next one.
        for trace in &two.pressed {
            assert!(last_moved(trace) <= met + 1 + T_B, "{step}");
        }
        assert!(last_moved(&two.painted[0]) <= met + 3 + T_B, "{step}: {}", last_moved(&two.painted[0]));
        assert!(end(&two.painted[0]).abs() < 0.4, "it did not finish");
        assert_eq!(two.press.fault().map(|fault| fault.kind()), Some(FaultKind::Program));
        assert_eq!(two.paint.fault().map(|fault| fault.kind()), Some(FaultKind::StoppedByCell));
    }
}

#[test]
fn fault_161_a_program_that_goes_on_without_a_cell_moves_the_others_as_if_nothing_were() {
    let undisturbed = Two::doing(go(0.4, 1.0), go(-0.4, 1.0));
    undisturbed.cell.run().expect("nothing is wrong");
    let told = Rc::new(RefCell::new(Vec::new()));
    let tells = Rc::clone(&told);
    let two = Two::with(
        |press| {
            // Its operator comes two seconds later.
            press.on_step(|step, operator| {
                if step > 2000 && operator.latch() == Latch::Latched {
                    operator.acknowledge().expect("latched");
                    operator.reset().expect("acknowledged");
                }
            })
        },
        move |mp, press, paint| {
            mp.go_on_without(press)?;
            let trip = Job::Trip { end: 0.4, seconds: 1.0, step: 300 };
            mp.move_robots([&mut *press, &mut *paint], (), Jobs([trip, go(-0.4, 1.0)]))?;
            tells.borrow_mut().push((mp.step(), mp.left_out(press).map(|fault| fault.message().to_owned())));
            // While it is latched, a Move goes on without it from the beginning.
            mp.move_robots([&mut *press, &mut *paint], (), Jobs([go(0.1, 1.0), go(-0.2, 0.5)]))?;
            tells.borrow_mut().push((mp.step(), mp.left_out(press).map(|fault| fault.message().to_owned())));
            assert!(press.is_latched() && !press.is_ready());
            mp.wait_until((&mut *press,), (), IsBack {})?;
            assert!(press.is_ready());
            tells.borrow_mut().push((mp.step(), None));
            mp.move_robots([&mut *press, &mut *paint], (), Jobs([go(0.2, 1.0), go(0.0, 0.5)]))?;
            tells.borrow_mut().push((mp.step(), mp.left_out(press).map(|fault| fault.message().to_owned())));
            Ok(())
        },
    );
    two.cell.run().expect("the program goes on");
    let told = told.take();
    let texts: Vec<_> = told.iter().map(|(_, text)| text.as_deref()).collect();
    assert_eq!(texts, [Some("tripped"), Some("tripped"), None, None]);
    // The Wait ended when the reset was over.
    assert!((2001..2030).contains(&told[2].0), "{told:?}");
    let (same, painted) = (undisturbed.painted[0].borrow(), two.painted[0].borrow());
    assert_eq!(same[..1000], painted[..1000], "not a bit of the other cell's path is another");
    assert!((painted[painted.len() - 1][0]).abs() < 1e-9);
    assert!((end(&two.pressed[0]) - 0.2).abs() < 1e-9 && (end(&two.pressed[1]) - 0.2).abs() < 1e-9);
    keep_limits(&two.pressed);
}

/// Waits for a cell that serves again.
struct IsBack;

#[condition(mp)]
fn is_back(_: &mut IsBack, e: &State<(LowerCell,)>) -> bool {
    e.0.is_ready()
}

#[test]
fn fault_163_suspend_from_above_stops_every_cell_on_its_path_and_resume_goes_on_to_the_same_end() {
    let calm = Two::doing(go(0.4, 1.0), go(-0.4, 1.5));
    calm.cell.run().expect("nothing is wrong");
    for at in [1, 5, 250, 900] {
        let mut two = Two::doing(go(0.4, 1.0), go(-0.4, 1.5));
        two.cell = two.cell.on_step(move |step, operator| match step {
            _ if step == at => operator.suspend(),
            _ if step == at + 1000 => operator.resume(),
            _ => {}
        });
        two.cell.run().expect("it goes on");
        for (trace, other) in
            two.pressed.iter().chain(&two.painted).zip(calm.pressed.iter().chain(&calm.painted))
        {
            assert!((end(trace) - end(other)).abs() < 1e-9, "suspended in step {at}");
            let stood = &trace.borrow()[at as usize + path_stop()..at as usize + 1000];
            assert!(stood.windows(2).all(|w| w[0] == w[1]), "suspended in step {at}");
        }
        keep_limits(two.pressed.iter().chain(&two.painted));
    }
}

#[test]
fn the_rates_of_the_upper_cell_and_of_a_lower_one_multiply() {
    let steps = |upper: f64, own: f64| {
        let took = Rc::new(Shared::new(0));
        let takes = Rc::clone(&took);
        let two = Two::of(move |mp, press, _| {
            mp.move_robots([press], (), Jobs([go(0.4, 1.0)]))?;
            takes.set(mp.step());
            Ok(())
        });
        two.cell.operator().set_speed(upper).expect("a speed");
        two.press.set_speed(own).expect("a speed");
        two.cell.run().expect("it is only slow");
        assert!((end(&two.pressed[0]) - 0.4).abs() < 1e-9);
        took.get()
    };
    for (upper, own, seconds) in [(1.0, 1.0, 1), (0.5, 1.0, 2), (1.0, 0.5, 2), (0.5, 0.5, 4)] {
        let took = steps(upper, own);
        assert!((seconds * 1000..seconds * 1000 + 20).contains(&took), "{upper} by {own}: {took}");
    }
}

#[test]
fn a_lower_cell_that_its_own_operator_suspends_makes_the_others_wait_at_the_end_only() {
    let took = Rc::new(Shared::new(0));
    let takes = Rc::clone(&took);
    let two = Two::with(
        |press| {
            press.on_step(|step, operator| match step {
                300 => operator.suspend(),
                2300 => operator.resume(),
                _ => {}
            })
        },
        move |mp, press, paint| {
            mp.move_robots([press, paint], (), Jobs([go(0.4, 1.0), go(-0.4, 1.0)]))?;
            takes.set(mp.step());
            Ok(())
        },
    );
    two.cell.run().expect("it goes on");
    assert!((end(&two.pressed[0]) - 0.4).abs() < 1e-9);
    assert!(last_moved(&two.painted[0]) < 1010, "the other cell is not slowed");
    assert!((2980..3030).contains(&took.get()), "{}", took.get());
}

/// A Move that the upper MP ends after so many steps.
struct For {
    steps: u64,
    job: Job,
}

#[generator(mp)]
fn for_steps(c: &mut For, t: Tick) -> Step<[LowerCell; 1], Job> {
    if t.step < c.steps { Step::Next([c.job]) } else { Step::Done }
}

#[test]
fn fault_168_a_move_that_the_upper_mp_ends_early_ends_on_the_path_of_the_cell_and_the_next_one_goes_on_from_there()
 {
    for steps in [1, 2, 300, 999] {
        let two = Two::of(move |mp, press, _| {
            mp.move_robots([&mut *press], (), For { steps, job: go(0.4, 1.0) })?;
            mp.move_robots([press], (), Jobs([go(-0.1, 1.0)])).map(drop)
        });
        two.cell.run().expect("the end of an instruction is no fault");
        keep_limits(&two.pressed);
        assert!((end(&two.pressed[0]) + 0.1).abs() < 1e-9, "{steps}");
        assert_eq!(*two.pressed[0].borrow(), *two.pressed[1].borrow(), "both gantries stay on one path");
    }
}

#[test]
fn fault_168_an_abort_from_above_stops_every_cell_on_its_path_and_the_upper_program_may_go_on() {
    for at in [2, 250, 900] {
        let mut two = Two::of(move |mp, press, paint| {
            let aborted = mp.move_robots([&mut *press, &mut *paint], (), Jobs([go(0.4, 1.0), go(-0.4, 1.5)]));
            assert_eq!(aborted.map(drop).map_err(|fault| fault.kind()), Err(FaultKind::Aborted));
            mp.move_robots([press, paint], (), Jobs([go(0.1, 1.0), go(-0.1, 1.0)])).map(drop)
        });
        two.cell = two.cell.on_step(move |step, operator| {
            if step == at {
                operator.abort();
            }
        });
        two.cell.run().expect("the program goes on");
        assert!((end(&two.pressed[1]) - 0.1).abs() < 1e-9 && (end(&two.painted[0]) + 0.1).abs() < 1e-9);
        keep_limits(two.pressed.iter().chain(&two.painted));
    }
}

/// Acknowledges and resets as soon as the robots of a cell stand.
fn attend(operator: &Operator) {
    if operator.latch() == Latch::Latched {
        operator.acknowledge().expect("latched");
        operator.reset().expect("acknowledged");
    }
}

#[test]
fn fault_164_a_protective_stop_from_above_stops_on_the_paths_and_its_reset_is_that_of_all_cells() {
    let runs = Rc::new(Shared::new(0));
    let count = Rc::clone(&runs);
    let mut two = Two::of(move |mp, press, paint| {
        count.set(count.get() + 1);
        mp.move_robots([press, paint], (), Jobs([go(0.4, 1.0), go(-0.4, 1.5)])).map(drop)
    });
    two.cell = two.cell.after_fault(AfterFault::AwaitReset).on_step(|step, operator| {
        if step == 300 {
            operator.protective_stop();
        }
        if step > 1500 {
            attend(operator);
        }
    });
    two.cell.run().expect("after the reset the program starts again");
    assert_eq!(runs.get(), 2);
    for trace in two.pressed.iter().chain(&two.painted) {
        let trace = trace.borrow();
        assert!(trace[300 + path_stop()..1500].windows(2).all(|w| w[0] == w[1]));
    }
    assert!((end(&two.pressed[0]) - 0.4).abs() < 1e-9 && (end(&two.painted[0]) + 0.4).abs() < 1e-9);
    assert_eq!((two.press.latch(), two.paint.latch()), (Latch::Clear, Latch::Clear));
    keep_limits(two.pressed.iter().chain(&two.painted));
}

#[test]
fn fault_165_a_reset_from_above_does_not_reset_a_cell_that_stopped_for_a_cause_of_its_own() {
    let runs = Rc::new(Shared::new(0));
    let count = Rc::clone(&runs);
    let failed = Rc::new(Shared::new(0));
    let fails = Rc::clone(&failed);
    let refused = Rc::new(Shared::new(false));
    let refuses = Rc::clone(&refused);
    let mut two = Two::with(
        // Its operator comes after three seconds. Once he has reset it, the upper cell stops it in the next step, and only that
        // one's operator can reset it.
        |press| {
            press.on_step(move |step, operator| {
                let from_above = |fault: Fault| fault.kind() == FaultKind::StoppedByCell;
                let persists = operator.persisting().is_some_and(from_above);
                let looks = step > 3000 && step % 70 == 0;
                if looks && matches!(operator.latch(), Latch::Latched | Latch::Acknowledged) {
                    operator.acknowledge().expect("latched");
                    let reset = operator.reset();
                    assert!(reset.is_err() || !persists, "{step}");
                    refuses.set(refuses.get() || reset.is_err());
                }
            })
        },
        move |mp, press, paint| {
            count.set(count.get() + 1);
            let step = if count.get() == 1 { 300 } else { u64::MAX };
            let trip = Job::Trip { end: 0.4, seconds: 1.0, step };
            mp.move_robots([press, paint], (), Jobs([trip, go(-0.4, 1.0)])).map(drop)
        },
    );
    // The upper one tries again and again.
    two.cell = two.cell.after_fault(AfterFault::AwaitReset).on_step(move |step, operator| {
        if step > 20_000 {
            // It would never end.
            operator.give_up();
        }
        if step % 100 == 0 {
            fails.set(fails.get() + u64::from(operator.persisting().is_some()));
            attend(operator);
        }
    });
    let report = two.cell.run().expect("after both resets the program starts again");
    assert!(failed.get() > 10 && report.steps > 3000, "{} {}", failed.get(), report.steps);
    assert!(refused.get(), "the upper cell has stopped it meanwhile");
    assert_eq!(runs.get(), 2);
    assert!((end(&two.pressed[0]) - 0.4).abs() < 1e-9 && (end(&two.painted[0]) + 0.4).abs() < 1e-9);
    let stood = &two.pressed[0].borrow()[600..3000];
    assert!(stood.windows(2).all(|w| w[0] == w[1]), "nothing moves before its own operator has reset it");
}

#[test]
fn fault_167_orders_that_no_cell_takes_are_refused_before_anything_moves() {
    #[derive(Clone, Copy, Debug, PartialEq, Payload)]
    struct Along {
        x: f64,
    }
    #[derive(Clone, Copy, Debug, PartialEq, Payload)]
    enum Other {
        Thing,
    }
    #[generator(mp)]
    fn tight() -> Always<[LowerCell; 2], Along> {
        Always([Along { x: 0.1 }; 2])
    }
    #[generator(mp)]
    fn other() -> Always<[LowerCell; 2], Other> {
        Always([Other::Thing; 2])
    }
    let two = Two::of(|mp, press, paint| mp.move_robots([press, paint], (), tight {}).map(drop));
    let cause = fault(two.cell.run());
    assert_eq!(cause.kind(), FaultKind::PayloadMismatch, "{cause}");
    assert_eq!(
        cause.message(),
        "cell `press` takes loose orders, an `enum`; `Along` is a struct of tight ones"
    );
    let two = Two::of(|mp, press, paint| mp.move_robots([press, paint], (), other {}).map(drop));
    let cause = fault(two.cell.run());
    assert_eq!(cause.kind(), FaultKind::PayloadMismatch, "{cause}");
    assert_eq!(cause.message(), "this cell serves orders of type `Job`, the MP orders `Other`");
    assert_eq!((last_moved(&two.pressed[0]), last_moved(&two.painted[0])), (0, 0));
    // A robot of the plant that is none: another kind.
    let two = Two::of(|mp, _, _| mp.robot::<Gantry>("press").map(drop));
    let cause = fault(two.cell.run());
    assert_eq!(cause.kind(), FaultKind::Config, "{cause}");
}

/// The memory link, on which one process stands still from a time on, for ever or until another time \[ns\].
struct Frozen {
    scheduler: Scheduler,
    process: String,
    from: Nanos,
    until: Nanos,
    /// When the run is over, whatever goes on.
    over: Nanos,
    places: Vec<String>,
}

impl Frozen {
    fn new(process: &str, from: u64, until: u64, over: u64) -> Frozen {
        let [from, until, over] = [from, until, over].map(|step| step * 1_000_000 + 1);
        Frozen {
            scheduler: Scheduler::new(),
            process: process.to_owned(),
            from,
            until,
            over,
            places: Vec::new(),
        }
    }

    /// Runs a cell on it.
    fn run(mut self, cell: Cell) -> Result<(), Fault> {
        let assembly = cell.put_on(&mut self).expect("nothing is wrong with the cell");
        self.scheduler.run().expect("somebody waits for a time");
        let outcomes = assembly.outcomes.take();
        outcomes
            .into_iter()
            .find(|(process, _)| *process == ProcessId::MP)
            .map_or(Ok(()), |(_, outcome)| outcome)
    }
}

impl Link for Frozen {
    fn place(&mut self, process: ProcessId) -> usize {
        self.places.push(process.to_string());
        self.scheduler.place(process)
    }

    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>) {
        self.scheduler.port(client, server)
    }

    fn board(&mut self, writer: usize, reader: usize) -> Rc<dyn Board> {
        self.scheduler.board(writer, reader)
    }

    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck> {
        if self.places[place] != self.process {
            return self.scheduler.body(place, body);
        }
        let (from, until, over, close) = (self.from, self.until, self.over, self.scheduler.closer());
        let run = move |host: Host<'_>| {
            let waiter = Freezes { inner: host.waiter, from, until, over, close: &*close };
            body(Host { waiter: &waiter, ..host });
        };
        self.scheduler.body(place, Box::new(run))
    }

    fn closer(&self) -> Box<dyn Fn()> {
        self.scheduler.closer()
    }
}

struct Freezes<'w> {
    inner: &'w dyn Waiter,
    from: Nanos,
    until: Nanos,
    over: Nanos,
    close: &'w dyn Fn(),
}

impl Waiter for Freezes<'_> {
    fn now(&self) -> Nanos {
        self.inner.now()
    }

    /// Nobody counts the time for which it stands still as its own.
    fn stands_still(&self) -> bool {
        true
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        let waited = self.inner.wait(deadline);
        let until = self.until.min(self.over);
        while self.from <= self.inner.now() && self.inner.now() < until {
            self.inner.wait(Some(until))?;
        }
        if self.inner.now() >= self.over {
            (self.close)();
            return Err(Closed);
        }
        waited
    }
}

/// `2 (L + 1) + 1` steps in which the loss of the upper MP is noticed, `L` = 20.
const SILENCE: usize = 43;

#[test]
fn fault_162_lower_cells_whose_upper_mp_is_killed_stop_on_their_paths_and_say_so() {
    for at in [2, 100, 333, 500, 900] {
        let two = Two::doing(go(0.4, 1.0), go(-0.4, 1.5));
        let (press, paint) = (two.press.clone(), two.paint.clone());
        Frozen::new("mp", at, u64::MAX / 2_000_000, 3000).run(two.cell).expect_err("closed");
        for trace in two.pressed.iter().chain(&two.painted) {
            assert!(last_moved(trace) <= at as usize + SILENCE + path_stop(), "{at}: {}", last_moved(trace));
        }
        assert_eq!(*two.pressed[0].borrow(), *two.pressed[1].borrow(), "they stay on one path");
        keep_limits(two.pressed.iter().chain(&two.painted));
        for operator in [press, paint] {
            let cause = operator.fault().expect("latched");
            assert_eq!(cause.kind(), FaultKind::PeerLost, "{cause}");
            assert_eq!(cause.message(), "no orders from the upper MP: robots stop on their paths");
        }
    }
}

#[test]
fn fault_162_an_upper_mp_that_says_nothing_for_less_than_that_stops_no_cell() {
    for steps in [1, 10, 20, 42] {
        let two = Two::doing(go(0.4, 1.0), go(-0.4, 1.5));
        // Its own robots are none; it has only missed its steps.
        Frozen::new("mp", 300, 300 + steps, 3000).run(two.cell).expect("it goes on");
        assert!((end(&two.pressed[0]) - 0.4).abs() < 1e-9 && (end(&two.painted[0]) + 0.4).abs() < 1e-9);
    }
}

#[test]
fn fault_169_an_upper_mp_that_comes_back_moves_no_cell_that_has_stopped_for_its_silence() {
    for stall in [60, 200, 1000] {
        let two = Two::doing(go(0.4, 1.0), go(-0.4, 1.5));
        let cause =
            Frozen::new("mp", 300, 300 + stall, 5000).run(two.cell).expect_err("the cells have stopped");
        assert_eq!(cause.kind(), FaultKind::PeerLost, "{cause}");
        for trace in two.pressed.iter().chain(&two.painted) {
            let back = 300 + SILENCE + path_stop();
            let trace = trace.borrow();
            assert!(trace[back.min(trace.len() - 1)..].windows(2).all(|w| w[0] == w[1]), "{stall}");
        }
        keep_limits(two.pressed.iter().chain(&two.painted));
    }
}

#[test]
fn fault_166_a_lower_mp_that_is_killed_is_lost_and_stops_every_cell() {
    for at in [100, 333, 900] {
        let two = Two::doing(go(0.4, 1.0), go(-0.4, 1.5));
        let cause = Frozen::new("mp press", at, u64::MAX / 2_000_000, 4000).run(two.cell).expect_err("lost");
        assert_eq!(
            (cause.kind(), cause.process().map(|p| p.to_string())),
            (FaultKind::PeerLost, Some("mp press".to_owned()))
        );
        // The upper MP notices it after L + 1; the robots of the cell itself by faults 1 and 3.
        assert!(
            last_moved(&two.painted[0]) <= at as usize + 21 + 3 + T_B,
            "{at}: {}",
            last_moved(&two.painted[0])
        );
        // As arms that one Move leads by poses do, or else L.
        for trace in &two.pressed {
            assert!(last_moved(trace) <= at as usize + 20 + 3 + T_B * 10 / 8, "{at}: {}", last_moved(trace));
        }
        keep_limits(two.pressed.iter().chain(&two.painted));
    }
}

#[test]
fn fault_166_a_program_goes_on_without_a_cell_whose_mp_is_killed() {
    let left_out = Rc::new(RefCell::new(None));
    let leaves = Rc::clone(&left_out);
    let two = Two::of(move |mp, press, paint| {
        mp.go_on_without(press)?;
        mp.move_robots([&mut *press, &mut *paint], (), Jobs([go(0.4, 1.0), go(-0.4, 1.5)]))?;
        *leaves.borrow_mut() = mp.left_out(press);
        mp.move_robots([paint], (), Jobs([go(0.0, 1.0)])).map(drop)
    });
    Frozen::new("mp press", 300, u64::MAX / 2_000_000, 6000).run(two.cell).expect("it goes on");
    assert_eq!(left_out.take().map(|fault| fault.kind()), Some(FaultKind::PeerLost));
    assert!(end(&two.painted[0]).abs() < 1e-9);
    keep_limits(two.pressed.iter().chain(&two.painted));
}

#[test]
fn sixteen_cells_of_four_robots_run_under_one_clock_and_twice_the_same_to_the_bit() {
    const CELLS: usize = 16;
    let run = || {
        let (cells, traces): (Vec<_>, Vec<_>) = (0..CELLS).map(|_| lower::<4>()).unzip();
        let plant = cells
            .into_iter()
            .enumerate()
            .fold(Cell::new(MS), |plant, (i, cell)| plant.cell(&format!("c{i}"), cell));
        let plant = plant.on_step(|step, operator| match step {
            400 => operator.suspend(),
            800 => operator.resume(),
            _ => {}
        });
        let report = plant
            .program(|mp| {
                let mut cells = Vec::new();
                for i in 0..CELLS {
                    cells.push(mp.robot::<LowerCell>(&format!("c{i}"))?);
                }
                for turn in 0..2 {
                    let mut handles = cells.iter_mut();
                    let list: [_; CELLS] =
                        core::array::from_fn(|_| handles.next().expect("a handle for each"));
                    let job = |i: usize| go(0.02 * i as f64 * f64::from(1 - 2 * turn), 1.0 + 0.02 * i as f64);
                    mp.move_robots(list, (), Jobs(core::array::from_fn(job)))?;
                }
                Ok(())
            })
            .run()
            .expect("all cells do their jobs");
        (report, traces.into_iter().flatten().map(|trace| trace.take()).collect::<Vec<_>>())
    };
    let ((report, first), (again, second)) = (run(), run());
    assert_eq!((first.len(), report), (64, again));
    assert!(first == second, "not a bit is another");
    for (i, trace) in first.iter().enumerate() {
        let cell = i / 4;
        assert!((trace[trace.len() - 1][0] + 0.02 * cell as f64).abs() < 1e-9, "gantry {i}");
        let (v, a) = peaks(trace, 1e-3);
        assert!(v <= 1.0 && a <= 10.0 + 1e-6);
    }
}

/// A small plant for sweeps: one cell of two gantries, one of a gantry, and there and back.
pub fn plant() -> Cell {
    let two = Two::of(|mp, press, paint| {
        mp.move_robots([&mut *press, &mut *paint], (), Jobs([go(0.1, 0.5), go(-0.1, 0.6)]))?;
        mp.move_robots([press, paint], (), Jobs([go(0.0, 0.5), go(0.0, 0.5)])).map(drop)
    });
    two.cell
}

#[test]
fn fault_167_a_move_of_a_lower_cell_outside_of_an_order_is_refused() {
    let (robot, trace) = gantry("g");
    let eager = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.move_robots(
            [&mut g],
            (),
            Together { end: 0.4, seconds: 1.0, trips_at: None, t: 0.0, from: [0.0; 1] },
        )
        .map(drop)
    });
    let cause = fault(Cell::new(MS).cell("eager", eager).program(|_| Ok(())).run());
    assert_eq!(
        cause.message(),
        "Move or Wait outside serve: write `mp.serve(|mp, order: YourOrder| ..)` around it"
    );
    assert_eq!(last_moved(&trace), 0);
    // And an MP that nobody orders anything has nothing to serve.
    let (robot, _) = gantry("g");
    let cause = fault(Cell::new(MS).robot(robot).program(|mp| mp.serve(|_, _: Job| Ok(()))).run());
    assert_eq!(cause.kind(), FaultKind::Config, "{cause}");
}

#[test]
fn fault_168_a_program_that_ignores_the_end_of_its_order_is_ended() {
    let (robot, trace) = gantry("g");
    let stubborn = Cell::new(MS).robot(robot).after_fault(AfterFault::AwaitReset).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        mp.serve_all(|mp, _: Job| {
            loop {
                let there = Together { end: 0.4, seconds: 1.0, trips_at: None, t: 0.0, from: [0.0; 1] };
                let _ = mp.move_robots([&mut g], (), there);
            }
        })
    });
    let cause = fault(
        Cell::new(MS)
            .cell("stubborn", stubborn)
            .program(|mp| {
                let mut cell = mp.robot::<LowerCell>("stubborn")?;
                mp.move_robots([&mut cell], (), For { steps: 300, job: Job::Rest }).map(drop)
            })
            .run(),
    );
    assert_eq!(cause.process().map(|process| process.to_string()).as_deref(), Some("mp stubborn"), "{cause}");
    assert!(last_moved(&trace) <= 300 + path_stop(), "its robots stand all the same");
}

#[test]
fn three_levels_of_cells_with_steps_of_their_own_slow_down_and_go_on_together() {
    let (press, pressed) = lower::<2>();
    // A line of one press, at a step of 4 ms, which has a gantry of its own.
    let (robot, moved) = gantry("own");
    let line = Cell::new(4 * MS).robot(robot).cell("press", press).program(|mp| {
        let (mut press, mut own) = (mp.robot::<LowerCell>("press")?, mp.robot::<Gantry>("own")?);
        mp.serve_all(|mp, job: Job| {
            mp.move_robots([&mut press], (), Jobs([job]))?;
            let there = Together { end: 0.2, seconds: 1.0, trips_at: None, t: 0.0, from: [0.0; 1] };
            mp.move_robots([&mut own], (), there).map(drop)
        })
    });
    let plant = Cell::new(2 * MS).cell("line", line).program(|mp| {
        let mut line = mp.robot::<LowerCell>("line")?;
        mp.move_robots([&mut line], (), Jobs([go(0.4, 1.0)])).map(drop)
    });
    let plant = plant.on_step(|step, operator| match step {
        150 => operator.suspend(),
        650 => operator.resume(),
        _ => {}
    });
    let report = plant.run().expect("nothing is wrong");
    // Two motions of a second each, and a second of suspension.
    assert!((2.95..3.1).contains(&report.time.as_secs_f64()), "{:?}", report.time);
    assert!((end(&pressed[0]) - 0.4).abs() < 1e-9 && (end(&moved) - 0.2).abs() < 1e-9);
    let stood = &pressed[0].borrow()[300 + path_stop() + 10..1290];
    assert!(stood.windows(2).all(|w| w[0] == w[1]));
    keep_limits(pressed.iter().chain([&moved]));
}

#[test]
fn a_cell_works_in_the_background_of_moves_of_other_cells() {
    let two = Two::of(|mp, press, paint| {
        mp.start_robots([&mut *press], Jobs([go(0.4, 2.0)]))?;
        mp.move_robots([&mut *paint], (), Jobs([go(-0.4, 1.0)]))?;
        mp.move_robots([paint], (), Jobs([go(0.0, 0.8)]))?;
        // Taken over: ended on its path first.
        mp.move_robots([press], (), Jobs([go(0.1, 1.0)])).map(drop)
    });
    two.cell.run().expect("nothing is wrong");
    assert!((end(&two.pressed[0]) - 0.1).abs() < 1e-9 && end(&two.painted[0]).abs() < 1e-9);
    keep_limits(two.pressed.iter().chain(&two.painted));
}

#[test]
fn what_is_wrong_with_a_lower_cell_is_told_with_its_name_before_anything_runs() {
    let (robot, _) = gantry("g");
    let (twice, _) = gantry("g");
    let wrong = Cell::new(MS).robot(robot).robot(twice);
    let plant = Cell::new(MS).cell("press", wrong).cell("press", lower::<1>().0).program(|_| Ok(()));
    let said = plant.run().expect_err("two robots and two cells of one name, no program").to_string();
    for part in ["cell `press`: the cell has two of the name `g`", "the cell has two of the name `press`"] {
        assert!(said.contains(part), "{said}");
    }
    let (robot, _) = gantry("g");
    let plant = Cell::new(MS).cell("press", Cell::new(MS).robot(robot)).program(|_| Ok(()));
    let said = plant.run().expect_err("no program").to_string();
    assert!(said.starts_with("cell `press`: ") && said.contains("program"), "{said}");
    let plant = Cell::new(MS).cell("a-name-of-20-bytes-xx", lower::<1>().0).program(|_| Ok(()));
    assert!(plant.run().is_ok(), "24 bytes with `.g0`");
    let plant = Cell::new(MS).cell("a-name-of-22-bytes-xxx", lower::<1>().0).program(|_| Ok(()));
    assert!(plant.run().is_err(), "more than 24 bytes with `.g0`");
}
