//! Arms whose MP dies or is late: what they do without it, step by step, under the virtual clock.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use nalgebra::{SVector, Translation3, UnitQuaternion, Vector3};

use crate::cell::{Cell, RobotSetup};
use crate::control::mp::Mp;
use crate::generator;
use crate::link::memory::{Scheduler, Stuck};
use crate::link::{Board, Body, Client, Closed, Host, Link, Server, Waiter};
use crate::model::demand::Demand;
use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Driver, Measured};
use crate::model::fault::{Fault, ProcessId};
use crate::model::list::State;
use crate::model::pose::Pose;
use crate::model::robot::{JointKind, Limits, NoInverse, Robot};
use crate::model::step::{Step, Tick};
use crate::model::time::Nanos;
use crate::observe::servo::ServoRecord;
use crate::safety::stopping::together_budget;

pub(super) type Six = SVector<f64, 6>;

const STEP: Duration = Duration::from_millis(1);
const NANOS: Nanos = 1_000_000;

/// Three slides and a wrist, on a base, with the flange 0.4 m from the wrist: its joints' paths are curved when it turns.
#[derive(Clone)]
pub(super) struct Arm {
    base: Pose,
    limits: Limits<Six>,
}

impl Arm {
    pub(super) fn on(base: Pose, acceleration: Six) -> Arm {
        let (upper, velocity) = (slides_and_turns(9.0, 1.4), slides_and_turns(1.0, 2.0));
        Arm { base, limits: Limits { lower: -upper, upper, velocity, acceleration, jerk: None } }
    }

    #[allow(non_snake_case)]
    fn X_HF() -> Pose {
        Pose::translation(0.1, -0.2, 0.35)
    }
}

impl Robot for Arm {
    const KIND: &'static str = "arm";
    type Joints = Six;
    fn joint(&self, i: usize) -> JointKind {
        if i < 3 { JointKind::Prismatic } else { JointKind::Revolute }
    }
    fn limits(&self) -> &Limits<Six> {
        &self.limits
    }
    fn forward(&self, q: &Six) -> Pose {
        let turn = UnitQuaternion::from_euler_angles(q[3], q[4], q[5]);
        self.base * Pose::from_parts(Translation3::new(q[0], q[1], q[2]), turn) * Self::X_HF()
    }
    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _: &Six) -> Result<Six, NoInverse> {
        let hand = self.base.inv_mul(X_WF) * Self::X_HF().inverse();
        let ((a, b, c), p) = (hand.rotation.euler_angles(), hand.translation.vector);
        Ok(Six::new(p.x, p.y, p.z, a, b, c))
    }
}

pub(super) fn slides_and_turns(slides: f64, turns: f64) -> Six {
    Six::from_fn(|i, _| if i < 3 { slides } else { turns })
}

/// Drives that are where they are told to be, once in this period.
pub(super) struct Exact(pub Six, pub Duration);

impl Driver<Arm> for Exact {
    fn period(&self) -> Duration {
        self.1
    }
    fn measured(&self) -> Result<Measured<Six>, DriveFault> {
        Ok(Measured { position: self.0, velocity: Six::zeros() })
    }
    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        self.0 = *demanded;
        self.measured()
    }
}

/// Carries a body in both hands along a twist, 0.5 s, by a fifth-order profile.
struct Carry {
    t: f64,
    from: [Pose; 2],
}

#[generator(mp, first = grasp)]
#[allow(non_snake_case)]
fn carry(c: &mut Carry, t: Tick) -> Step<(Arm, Arm)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    let X = displacement(c.t);
    Step::Next((Demand::pose(X * c.from[0]), Demand::pose(X * c.from[1])))
}

/// By how much the body is displaced at this time \[s\]: a turn of 0.6 rad about an axis that passes beside both arms, and a
/// lift of 0.1 m.
pub(super) fn displacement(time: f64) -> Pose {
    let u = time / DURATION;
    let s = u * u * u * (10.0 - u * (15.0 - 6.0 * u));
    let axis = Pose::translation(0.2, 0.5, 0.0);
    axis * Pose::new(Vector3::z() * 0.1 * s, Vector3::new(0.1, 0.2, 0.5) * s) * axis.inverse()
}

fn grasp(c: &mut Carry, e: &State<(Arm, Arm)>, t: Tick) -> Step<(Arm, Arm)> {
    c.from = [e.0.demanded().pose, e.1.demanded().pose];
    carry(c, t)
}

pub(super) const DURATION: f64 = 0.5;

pub(super) fn program(mp: &mut Mp) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Arm>("left")?, mp.robot::<Arm>("right")?);
    mp.move_robots((&mut left, &mut right), (), Carry { t: 0.0, from: [Pose::identity(); 2] }).map(drop)
}

/// What befalls the MP in a step.
#[derive(Clone, Copy)]
enum Upset {
    /// It dies, and the cell is closed a second later.
    Dies(u64),
    /// It begins the next step so late; then again, so many steps later.
    Late { step: u64, by: Nanos, again: u64 },
}

/// The memory link, and what befalls the MP.
struct Upsetting(Scheduler, Upset);

struct Upsets<'w> {
    inner: &'w dyn Waiter,
    upset: Upset,
    close: Box<dyn Fn()>,
}

impl Upsets<'_> {
    fn let_pass(&self, until: Nanos) -> Result<(), Closed> {
        while self.now() < until {
            self.inner.wait(Some(until))?;
        }
        Ok(())
    }
}

impl Waiter for Upsets<'_> {
    fn now(&self) -> Nanos {
        self.inner.now()
    }
    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        let now = self.now() / NANOS;
        match self.upset {
            Upset::Dies(step) if now >= step => {
                self.let_pass((step + 1000) * NANOS)?;
                (self.close)();
                Err(Closed)
            }
            Upset::Late { step, by, again } if now == step || now == step + again => {
                self.let_pass((now + 1) * NANOS + by)
            }
            Upset::Dies(_) | Upset::Late { .. } => self.inner.wait(deadline),
        }
    }
}

impl Link for Upsetting {
    fn place(&mut self, process: ProcessId) -> usize {
        self.0.place(process)
    }
    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>) {
        self.0.port(client, server)
    }
    fn board(&mut self, writer: usize, reader: usize) -> Rc<dyn Board> {
        self.0.board(writer, reader)
    }
    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck> {
        // The MP has the first place.
        let (upset, close) = (if place == 0 { self.1 } else { Upset::Dies(u64::MAX) }, self.0.closer());
        self.0.body(
            place,
            Box::new(move |host| body(Host { waiter: &Upsets { inner: host.waiter, upset, close }, ..host })),
        )
    }
    fn closer(&self) -> Box<dyn Fn()> {
        self.0.closer()
    }
}

/// The poses of both flanges, step by step.
fn run(upset: Upset) -> [Vec<Pose>; 2] {
    run_within(slides_and_turns(10.0, 20.0), upset)
}

/// The same with these acceleration limits.
fn run_within(acceleration: Six, upset: Upset) -> [Vec<Pose>; 2] {
    let traces: [Rc<RefCell<Vec<Pose>>>; 2] = Default::default();
    let turned = Pose::new(Vector3::new(1.0, 0.8, 0.3), Vector3::new(0.3, -0.4, 2.0));
    let mut cell = Cell::new(STEP).program(program);
    for ((name, base), trace) in [("left", Pose::identity()), ("right", turned)].into_iter().zip(&traces) {
        let (arm, trace) = (Arm::on(base, acceleration), Rc::clone(trace));
        let (start, model) = (Six::new(0.1, 0.2, 0.3, 0.1, -0.2, 0.3), arm.clone());
        let keep = move |record: &ServoRecord<Arm>| trace.borrow_mut().push(model.forward(&record.demanded));
        cell = cell.robot(RobotSetup::new(name, arm, Exact(start, STEP)).observe(keep));
    }
    let names = cell.check().expect("nothing is wrong with it");
    let mut link = Upsetting(Scheduler::new(), upset);
    cell.assemble(&names, &mut link).expect("put together");
    link.0.run().expect("runs");
    traces.map(|trace| trace.take())
}

/// Distance \[m\] or angle \[rad\] between poses, the larger one.
pub(super) fn apart(a: &Pose, b: &Pose) -> f64 {
    let by = a.inv_mul(b);
    by.translation.vector.norm().max(2.0 * by.rotation.imag().norm())
}

/// Steps that arms go on for without orders.
fn bridged() -> u64 {
    u64::from(together_budget(STEP))
}

#[test]
fn fault_03_arms_whose_mp_dies_in_any_step_keep_their_relative_pose_until_they_stand() {
    // v / a of the slowest joint to stop, in steps.
    let braking = 100;
    let (mut worst, mut longest) = (0.0_f64, 0);
    for k in 1..=505 {
        let traces = run(Upset::Dies(k));
        let relative = traces[0][0].inv_mul(&traces[1][0]);
        for (a, b) in traces[0].iter().zip(&traces[1]) {
            worst = worst.max(apart(&a.inv_mul(b), &relative));
        }
        for trace in &traces {
            let end = trace[trace.len() - 1];
            let moved = trace.iter().rposition(|pose| *pose != end).unwrap_or(0);
            let after = (moved as u64 + 1).saturating_sub(k);
            longest = longest.max(after);
        }
        assert!(worst <= 1e-6, "dies in step {k}: {worst}");
    }
    println!("worst relative pose error {worst:.1e} m or rad, longest stop {longest} steps");
    // L + 1 + T_b, and a step in which the last demand is followed.
    assert!(longest <= bridged() + 1 + braking + 1, "{longest} steps");
}

#[test]
fn fault_03_arms_whose_mp_dies_begin_to_brake_when_they_have_gone_on_for_the_bridged_steps() {
    for k in [100, 180, 250, 320, 400] {
        let calm = run(Upset::Dies(u64::MAX));
        let traces = run(Upset::Dies(k));
        for (trace, calm) in traces.iter().zip(&calm) {
            let moved = |step: usize| apart(&trace[step - 1], &trace[step]);
            let bend = |step: usize| moved(step + 1) - moved(step);
            let first = (1..trace.len()).find(|&i| trace[i] != calm[i]).expect("the path ends");
            assert!((k as usize - 3..k as usize + 3).contains(&first), "dies in step {k}: {first}");
            // The path changes its speed by another amount in each step; without demands that is the last one, for so many steps.
            let n = bridged() as usize;
            for bridged in first..first + n {
                let change = bend(bridged - 1) - bend(bridged - 2);
                assert!(change.abs() < 1e-11, "dies in step {k}: {change} m in step {bridged}");
            }
            // The slowest joint brakes with 8 m/s² or 16 rad/s²: by 8e-6 m in a step, whatever the path does.
            assert!(
                moved(first + n) < moved(first + n - 1) - 1e-6,
                "dies in step {k}: no braking after {n} bridged steps"
            );
        }
    }
}

#[test]
fn fault_06_arms_whose_mp_stalls_for_the_steps_that_they_bridge_keep_their_relative_pose_and_go_on() {
    let calm = run(Upset::Dies(u64::MAX));
    let relative = calm[0][0].inv_mul(&calm[1][0]);
    let mut worst = 0.0_f64;
    // So many steps and a half: demands of one step more are missing.
    for stall in 1..bridged() - 1 {
        for step in (2 + stall..480).step_by(23) {
            let traces = run(Upset::Late { step, by: stall * NANOS + NANOS / 2, again: 0 });
            for (a, b) in traces[0].iter().zip(&traces[1]) {
                worst = worst.max(apart(&a.inv_mul(b), &relative));
            }
            assert!(worst <= 1e-6, "stalls for {stall} steps in step {step}: {worst}");
            for (trace, calm) in traces.iter().zip(&calm) {
                let off = apart(&trace[trace.len() - 1], &calm[calm.len() - 1]);
                assert!(off < 1e-12, "stalls for {stall} steps in step {step}: ends {off} off");
            }
        }
    }
    println!("worst relative pose error {worst:.1e} m or rad");
}

#[test]
fn fault_06_arms_whose_mp_is_late_keep_their_relative_pose_and_come_back_onto_their_path() {
    // The path takes up to 5.43 m/s² and 11.1 rad/s² of them: nine tenths.
    let limits = slides_and_turns(6.04, 12.34);
    let calm = run_within(limits, Upset::Dies(u64::MAX));
    let relative = calm[0][0].inv_mul(&calm[1][0]);
    let (mut worst, mut farthest) = (0.0_f64, 0.0_f64);
    // A START that is late puts all off.
    for step in 2..=499 {
        // Once, and again on the return: in its first steps, in its midst, and after it.
        let again = [0, 2, 3, 20, 70][step as usize % 5];
        // It leaves a step out; or it does not, and the arms miss the demand of that step all the same.
        let by = if step % 2 == 0 { NANOS + NANOS / 10 } else { NANOS * 9 / 10 };
        let traces = run_within(limits, Upset::Late { step, by, again });
        for (a, b) in traces[0].iter().zip(&traces[1]) {
            worst = worst.max(apart(&a.inv_mul(b), &relative));
        }
        for (trace, calm) in traces.iter().zip(&calm) {
            let off = trace.iter().zip(calm).map(|(a, b)| apart(a, b)).fold(0.0, f64::max);
            assert!(off > 1e-9, "late in step {step}: no demand is missed");
            farthest = farthest.max(off);
            let (end, there) = (trace[trace.len() - 1], calm[calm.len() - 1]);
            assert!(apart(&end, &there) < 1e-12, "late in step {step}, {again}: {} off", apart(&end, &there));
        }
        assert!(worst <= 1e-6, "late in step {step}, {again}: {worst}");
    }
    println!("worst relative pose error {worst:.1e} m or rad, {farthest:.1e} off the path");
    // By the cubic, 4/27 of 50 steps at what the path's acceleration changes by in a step (`60/T³` of 0.55 rad and of 0.1 m, in the
    // flange by less than √3 times as much), and the offset that it begins with; twice, where it is late again.
    let third_difference = 3.0_f64.sqrt() * 60.0 * 0.55 * (1e-3 / DURATION).powi(3);
    let bound = 2.0 * (4.0 / 27.0 * 50.0 + 3.0) * third_difference;
    assert!(farthest > 1e-6 && farthest < bound, "{farthest}, bound {bound}");
}
