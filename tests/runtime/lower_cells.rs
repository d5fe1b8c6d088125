//! Cells of cells: an MP as one robot of a higher MP.

use std::cell::{Cell as Shared, RefCell};
use std::rc::Rc;

use mrroc::cell::{AfterFault, CellError, LowerCell, RunReport};
use mrroc::fault::FaultKind;
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
        mp.obey_all(|mp, job: Job| {
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
