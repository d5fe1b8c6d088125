//! Suspend, anywhere, in paths that use nine tenths of the acceleration limit.

use mrroc::operator::Operator;
use mrroc::prelude::*;
use mrroc_tests::{ExactDrive, Gantry, MS, Q, gantry, peaks, traced};

use crate::runtime::kit::{Phase, x};

/// Along x by a trapezoid of velocity: `up` and `down` \[m/s²\], `speed` \[m/s\], `cruise` \[s\].
#[derive(Clone, Copy)]
struct Trapezoid {
    up: f64,
    down: f64,
    speed: f64,
    cruise: f64,
    t: f64,
}

impl Trapezoid {
    const fn new(up: f64, down: f64) -> Trapezoid {
        Trapezoid { up, down, speed: 0.9, cruise: 0.1, t: 0.0 }
    }

    fn duration(&self) -> f64 {
        self.speed / self.up + self.cruise + self.speed / self.down
    }

    fn length(&self) -> f64 {
        self.speed * self.speed / 2.0 * (1.0 / self.up + 1.0 / self.down) + self.speed * self.cruise
    }

    fn position(&self) -> f64 {
        let up = self.speed / self.up;
        let left = self.duration() - self.t;
        if self.t < up {
            self.up * self.t * self.t / 2.0
        } else if left > self.speed / self.down {
            self.speed * self.speed / (2.0 * self.up) + self.speed * (self.t - up)
        } else {
            self.length() - self.down * left * left / 2.0
        }
    }

    fn advance(&mut self, dt: f64) -> Option<f64> {
        if self.t >= self.duration() {
            return None;
        }
        self.t = (self.t + dt).min(self.duration());
        Some(self.position())
    }
}

#[generator(ecp)]
fn trapezoid(c: &mut Trapezoid, t: Tick) -> Step<Gantry> {
    c.advance(t.dt).map_or(Step::Done, |position| Step::Next(x(position)))
}

#[test]
fn fault_37_a_fast_robot_may_be_resumed_wherever_it_stands() {
    // 2.6 m/s at 10 m/s², as an FR3's joints: a rate that rose by 5 a second would ask for 13 m/s².
    let path = Trapezoid { up: 9.0, down: 9.0, speed: 2.6, cruise: 0.05, t: 0.0 };
    for at in (1..640).step_by(9) {
        let drive = ExactDrive::new(Q::<3>::new(-1.0, 0.0, 0.0), MS);
        let (robot, trace) = traced(RobotSetup::new("g", Gantry::with_velocity(2.6), drive));
        let robot = robot.program(move |ecp| ecp.move_robot((), Shifted(path)).map(drop));
        let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
            if step == at {
                operator.suspend();
            }
            if step == at + 900 {
                operator.resume();
            }
        });
        cell.run().unwrap_or_else(|error| panic!("suspended at {at}: {error}"));
        let trace = trace.borrow();
        assert!((trace.last().expect("recorded")[0] + 1.0 - path.length()).abs() < 1e-9, "suspended at {at}");
        assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6, "suspended at {at}");
    }
}

/// A trapezoid from -1 m.
struct Shifted(Trapezoid);

#[generator(ecp)]
fn shifted(c: &mut Shifted, t: Tick) -> Step<Gantry> {
    c.0.advance(t.dt).map_or(Step::Done, |position| Step::Next(x(position - 1.0)))
}

struct InMp(Trapezoid);

#[generator(mp)]
fn in_mp(c: &mut InMp, t: Tick) -> Step<(Gantry, Gantry)> {
    c.0.advance(t.dt).map_or(Step::Done, |position| Step::Next((x(position), x(-position))))
}

fn run(
    path: Trapezoid,
    act: impl FnMut(u64, &Operator) + 'static,
) -> Result<Vec<Q<3>>, mrroc::cell::CellError> {
    let (robot, trace) = gantry("g");
    let robot = robot.program(move |ecp| ecp.move_robot((), path).map(drop));
    Cell::new(MS).robot(robot).on_step(act).run()?;
    Ok(trace.take())
}

fn suspended_at_every_step(path: Trapezoid) {
    let steps = (path.duration() * 1000.0) as u64 + 3;
    for at in 1..steps {
        let trace = run(path, move |step, operator| {
            if step == at || step == at + 700 {
                operator.suspend();
            }
            // Once at standstill, once while it brakes.
            if step == at + 600 || step == at + 750 {
                operator.resume();
            }
        });
        let trace = trace.unwrap_or_else(|error| panic!("suspended at {at}: {error}"));
        let end = trace.last().expect("recorded")[0];
        assert!((end - path.length()).abs() < 1e-9, "suspended at {at}: ends at {end}");
        let (v, a) = peaks(&trace, 1e-3);
        assert!(v <= 0.9 + 1e-9 && a <= 10.0 + 1e-6, "suspended at {at}: {v} m/s, {a} m/s²");
        let standing = &trace[trace.len().min(at as usize + 550)..trace.len().min(at as usize + 590)];
        assert!(standing.windows(2).all(|pair| pair[0] == pair[1]), "suspended at {at}: it moves");
    }
}

#[test]
fn fault_37_a_trapezoid_of_nine_tenths_may_be_suspended_in_every_step() {
    suspended_at_every_step(Trapezoid::new(9.0, 9.0));
}

#[test]
fn fault_37_a_path_may_be_suspended_before_it_brakes_harder_than_it_sped_up() {
    suspended_at_every_step(Trapezoid::new(2.0, 9.0));
}

#[test]
fn two_robots_of_one_motion_stay_together_in_every_suspension() {
    for at in (1..300).step_by(7) {
        let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
        let cell = Cell::new(MS).robot(left).robot(right).on_step(move |step, operator| {
            if step == at {
                operator.suspend();
            }
            if step == at + 500 {
                operator.resume();
            }
        });
        let cell = cell.program(|mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            mp.move_robots((&mut left, &mut right), (), InMp(Trapezoid::new(9.0, 9.0))).map(drop)
        });
        cell.run().unwrap_or_else(|error| panic!("suspended at {at}: {error}"));
        let (left, right) = (left_trace.borrow(), right_trace.borrow());
        assert!(left.iter().zip(right.iter()).all(|(l, r)| l[0] == -r[0]), "suspended at {at}");
        assert!((left.last().expect("recorded")[0] - Trapezoid::new(9.0, 9.0).length()).abs() < 1e-9);
    }
}

struct ShiftedInMp(Trapezoid);

#[generator(mp)]
fn shifted_in_mp(c: &mut ShiftedInMp, t: Tick) -> Step<(Gantry,)> {
    c.0.advance(t.dt).map_or(Step::Done, |position| Step::Next((x(position - 1.0),)))
}

#[test]
fn fault_37_a_fast_robot_with_a_transparent_ecp_may_be_resumed_wherever_it_stands() {
    // As above; its ECP has no path of its own and holds it in the suspension.
    let path = Trapezoid { up: 9.0, down: 9.0, speed: 2.6, cruise: 0.05, t: 0.0 };
    for at in (1..640).step_by(9) {
        let drive = ExactDrive::new(Q::<3>::new(-1.0, 0.0, 0.0), MS);
        let (robot, trace) = traced(RobotSetup::new("g", Gantry::with_velocity(2.6), drive));
        let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
            if step == at {
                operator.suspend();
            }
            if step == at + 900 {
                operator.resume();
            }
        });
        let cell = cell.program(move |mp| {
            let mut g = mp.robot::<Gantry>("g")?;
            mp.move_robots((&mut g,), (), ShiftedInMp(path)).map(drop)
        });
        cell.run().unwrap_or_else(|error| panic!("suspended at {at}: {error}"));
        let trace = trace.borrow();
        assert!((trace.last().expect("recorded")[0] + 1.0 - path.length()).abs() < 1e-9, "suspended at {at}");
        assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6, "suspended at {at}");
    }
}

#[test]
fn a_motion_at_speed_zero_stands_and_goes_on_when_the_speed_is_set() {
    let path = Trapezoid::new(9.0, 9.0);
    let trace = run(path, |step, operator| match step {
        1 => operator.set_speed(0.0).expect("a share"),
        300 => operator.set_speed(0.3).expect("a share"),
        500 => operator.set_speed(1.0).expect("a share"),
        _ => {}
    });
    let trace = trace.expect("keeps the limits");
    assert!(trace[..299].iter().all(|q| q.norm() == 0.0));
    assert!((trace.last().expect("recorded")[0] - path.length()).abs() < 1e-9);
}

#[test]
fn resume_of_a_cell_that_is_not_suspended_changes_nothing() {
    let path = Trapezoid::new(9.0, 9.0);
    let plain = run(path, |_, _| {}).expect("keeps the limits");
    assert_eq!(run(path, |_, operator| operator.resume()).expect("keeps the limits"), plain);
}

struct Triggering(u32);

#[generator(mp)]
fn triggering(c: &mut Triggering) -> Step<(Gantry,), Phase> {
    if c.0 == 0 {
        return Step::Done;
    }
    c.0 -= 1;
    Step::Next((Phase::Approach,))
}

#[generator(mp)]
fn trigger() -> Always<(Gantry,), Phase> {
    Always((Phase::Approach,))
}

#[test]
fn a_suspension_in_a_loose_motions_end_adds_no_deceleration_to_the_ends_own() {
    for ended in [30, 90, 100, 150, 195, 199, 205, 230] {
        for later in [0, 1, 2, 3, 5, 10, 30] {
            let (robot, trace) = gantry("g");
            let robot = robot.program(|ecp| {
                ecp.serve(|ecp, _: Phase| ecp.move_robot((), Trapezoid::new(9.0, 9.0)).map(drop))?;
                ecp.serve(|_, _: Phase| Ok(()))
            });
            let at = u64::from(ended) + later;
            let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
                if step == at {
                    operator.suspend();
                }
                if step == at + 500 {
                    operator.resume();
                }
            });
            let cell = cell.program(move |mp| {
                let mut g = mp.robot::<Gantry>("g")?;
                mp.move_robots((&mut g,), (), Triggering(ended))?;
                mp.move_robots((&mut g,), (), trigger {}).map(drop)
            });
            cell.run().unwrap_or_else(|error| panic!("ended at {ended}, suspended at {at}: {error}"));
            let (_, a) = peaks(&trace.borrow(), 1e-3);
            assert!(a <= 10.0 + 1e-6, "ended at {ended}, suspended at {at}: {a} m/s²");
        }
    }
}
