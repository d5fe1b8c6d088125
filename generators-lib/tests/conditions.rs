//! Conditions made of conditions: truth tables, steps from equations, and the laws of logic.

use std::time::Duration;

use mrroc::fault::FaultKind;
use mrroc::generator::{AnyRobots, Condition};
use mrroc::prelude::*;
use mrroc::sensor::SensorImage;
use mrroc_generators::conditions::{ConditionExt, all, any, elapsed, elapsed_since, not, separate};
use mrroc_robots::{Irp6, Polycrank, SimulatedIrp6};
use proptest::bool::ANY as BOOL;
use proptest::collection::vec;
use proptest::{prop_assert_eq, proptest};

/// Holds in the steps that are told to it, and never after them.
#[derive(Clone, Debug)]
struct Told(std::collections::VecDeque<bool>);

#[condition(ecp)]
fn told(c: &mut Told) -> bool {
    c.0.pop_front().unwrap_or(false)
}

fn holds(in_steps: &[bool]) -> Told {
    Told(in_steps.iter().copied().collect())
}

const DT: f64 = 2e-3;

fn tick(duration: f64) -> Tick {
    Tick { step: 0, dt: duration, duration }
}

/// Whether a condition that looks at nothing holds in so many steps.
fn asked<C>(mut condition: C, steps: usize) -> Vec<bool>
where
    C: Condition<Robots = AnyRobots, Sensors = (), Order = ()>,
{
    let mut ask = |_| condition.is_met(&Order::new(()), &State::new(()), &Reading::new(()), tick(DT));
    (0..steps).map(|step| ask(step).expect("no fault")).collect()
}

/// The index of the first step of so long in which it holds.
fn first<C>(mut condition: C, duration: f64, most: usize) -> Option<usize>
where
    C: Condition<Robots = AnyRobots, Sensors = (), Order = ()>,
{
    let t = tick(duration);
    let mut ask = || condition.is_met(&Order::new(()), &State::new(()), &Reading::new(()), t);
    (0..most).find(|_| ask().expect("no fault"))
}

#[test]
fn truth_tables_of_two_three_and_four_parts() {
    const NO: bool = false;
    const YES: bool = true;
    let (a, b) = (holds(&[NO, NO, YES, YES]), holds(&[NO, YES, NO, YES]));
    assert_eq!(asked(all((a.clone(), b.clone())), 4), [NO, NO, NO, YES]);
    assert_eq!(asked(any((a.clone(), b.clone())), 4), [NO, YES, YES, YES]);
    assert_eq!(asked(all([a.clone(), b.clone()]), 4), [NO, NO, NO, YES]);
    assert_eq!(asked(any([a.clone(), b]), 4), [NO, YES, YES, YES]);
    assert_eq!(asked(not(a), 4), [YES, YES, NO, NO]);
    // All the rows of four parts: part i holds where bit i of the row is set.
    let part = |i: usize| Told((0..16).map(|row| row >> i & 1 == 1).collect());
    let row = |of: fn(usize) -> bool| (0..16).map(of).collect::<Vec<_>>();
    assert_eq!(asked(all((part(0), part(1), part(2))), 16), row(|row| row & 7 == 7));
    assert_eq!(asked(any((part(0), part(1), part(2))), 16), row(|row| row & 7 != 0));
    assert_eq!(asked(all((part(0), part(1), part(2), part(3))), 16), row(|row| row == 15));
    assert_eq!(asked(any((part(0), part(1), part(2), part(3))), 16), row(|row| row != 0));
    assert_eq!(asked(all::<[Told; 0]>([]), 1), [YES]);
    assert_eq!(asked(any::<[Told; 0]>([]), 1), [NO]);
}

#[test]
fn a_break_starts_held_for_anew() {
    // 3 steps of 2 ms in a row.
    let switch = [true, true, false, true, true, true, true, false, true];
    let held = asked(holds(&switch).held_for(3.0 * DT), switch.len());
    assert_eq!(held, [false, false, false, false, false, true, true, false, false]);
}

#[test]
fn a_sum_of_a_million_steps_misses_none() {
    let steps = 1_000_000;
    for dt in [1e-3, 2e-3, 1.0 / 3e3] {
        let time = steps as f64 * dt;
        assert_eq!(first(elapsed(time), dt, steps + 2), Some(steps), "{dt}");
        assert_eq!(first(not(not(elapsed(0.0))).held_for(time), dt, steps), Some(steps - 1), "{dt}");
    }
}

#[test]
fn a_late_step_counts_for_the_periods_that_it_skipped_and_the_operators_speed_for_nothing() {
    let mut over = elapsed(10.0 * DT);
    let mut ask = |periods: f64| {
        let t = Tick { step: 0, dt: 0.0, duration: periods * DT };
        over.is_met(&Order::new(()), &State::new(()), &Reading::new(()), t).expect("no fault")
    };
    // 4 + 5 periods are not enough, 4 + 5 + 1 are.
    assert_eq!([1.0, 4.0, 5.0, 1.0].map(&mut ask), [false, false, false, true]);
}

#[test]
fn times_that_cannot_pass_are_refused() {
    let t = tick(DT);
    for time in [-1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let (c0, e, v) = (Order::new(()), State::new(()), Reading::new(()));
        let refused = [
            elapsed(time).is_met(&c0, &e, &v, t),
            elapsed_since(holds(&[true]), time).is_met(&c0, &e, &v, t),
            holds(&[true]).held_for(time).is_met(&c0, &e, &v, t),
        ];
        for outcome in refused {
            assert_eq!(outcome.expect_err("refused").kind(), FaultKind::Program, "{time}");
        }
    }
}

/// Throws a fault in its second step.
struct Broken(u32);

#[condition(ecp)]
fn broken(c: &mut Broken) -> Result<bool, Fault> {
    c.0 += 1;
    if c.0 == 2 { Err(Fault::thrown("no part in the feeder")) } else { Ok(true) }
}

#[test]
fn every_part_is_asked_in_every_step() {
    // What the first part says decides the outcome, and yet the timer behind it runs.
    let late = holds(&[false; 5]);
    assert_eq!(first(all((not(late.clone()), elapsed(5.0 * DT))), DT, 9), Some(5));
    assert_eq!(asked(any((holds(&[true; 5]), elapsed(6.0 * DT))), 7)[4..], [true, false, true]);
    for outcome in [false, true] {
        let mut both = (
            all((holds(&[outcome; 2]), Broken(0))),
            any((holds(&[outcome; 2]), Broken(0))),
            elapsed_since(Broken(0), 1.0),
        );
        let (c0, e, v, t) = (Order::new(()), State::new(()), Reading::new(()), tick(DT));
        let mut ask =
            || [both.0.is_met(&c0, &e, &v, t), both.1.is_met(&c0, &e, &v, t), both.2.is_met(&c0, &e, &v, t)];
        assert_eq!(ask(), [Ok(outcome), Ok(true), Ok(false)]);
        assert!(ask().iter().all(|end| end.as_ref().is_err_and(|fault| fault.kind() == FaultKind::Program)));
    }
}

proptest! {
    /// `steps` is what the time takes, rounded up.
    #[test]
    fn times_are_rounded_up_to_whole_steps(steps in 1_usize..20_000, less in 0.0..0.99, dt in 1e-4..0.1) {
        let time = (steps as f64 - less) * dt;
        let always = || not(elapsed(1e9));
        prop_assert_eq!(first(elapsed(time), dt, steps + 2), Some(steps));
        prop_assert_eq!(first(elapsed_since(always(), time), dt, steps + 2), Some(steps));
        // The first of so many steps in a row has the index 0.
        prop_assert_eq!(first(always().held_for(time), dt, steps + 2), Some(steps - 1));
    }

    #[test]
    fn held_for_is_a_run_of_steps(told in vec(BOOL, 0..80), steps in 0_usize..6) {
        let held = asked(holds(&told).held_for(steps as f64 * DT), told.len());
        let runs = |i: usize| told[..=i].iter().rev().take_while(|met| **met).count();
        let expected: Vec<_> = (0..told.len()).map(|i| runs(i) >= steps.max(1)).collect();
        prop_assert_eq!(held, expected);
    }

    #[test]
    fn elapsed_since_counts_from_the_first_time(told in vec(BOOL, 1..80), steps in 0_usize..6) {
        let since = asked(elapsed_since(holds(&told), steps as f64 * DT), told.len());
        let begun = told.iter().position(|met| *met);
        let expected: Vec<_> = (0..told.len()).map(|i| begun.is_some_and(|at| i >= at + steps)).collect();
        prop_assert_eq!(since, expected);
    }

    #[test]
    fn the_laws_of_logic_hold_with_timers_in_the_parts(
        told in vec((BOOL, BOOL, BOOL), 1..60),
        time in 0.0..8.0,
    ) {
        let steps = told.len();
        let part = |of: fn(&(bool, bool, bool)) -> bool| holds(&told.iter().map(of).collect::<Vec<_>>());
        let a = || part(|told| told.0);
        let b = || part(|told| told.1).held_for(time * DT);
        let c = || elapsed_since(part(|told| told.2), time * DT);
        prop_assert_eq!(asked(not(not(b())), steps), asked(b(), steps));
        prop_assert_eq!(asked(not(all((a(), b()))), steps), asked(any((not(a()), not(b()))), steps));
        prop_assert_eq!(asked(not(any((a(), b()))), steps), asked(all((not(a()), not(b()))), steps));
        prop_assert_eq!(
            asked(all((a(), any((b(), c())))), steps),
            asked(any((all((a(), b())), all((a(), c())))), steps)
        );
        prop_assert_eq!(asked(all((a(), b(), c())), steps), asked(all((a(), all((b(), c())))), steps));
        prop_assert_eq!(asked(any((a(), b(), c())), steps), asked(any((any((a(), b())), c())), steps));
        prop_assert_eq!(asked(all((a(), not(a()))), steps), vec![false; steps]);
        prop_assert_eq!(asked(any((c(), not(c()))), steps), vec![true; steps]);
    }
}

#[derive(Clone, Copy, Payload)]
struct Parts {
    seen: u64,
}

#[derive(Clone, Copy, Payload)]
struct Load {
    newtons: f64,
}

struct Camera;

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Parts;
    type Configuration = ();
}

struct Scale;

impl Sensor for Scale {
    const KIND: &'static str = "scale";
    type Reading = Load;
    type Configuration = ();
}

#[condition(mp)]
fn part_seen(v: &Reading<(Camera,)>) -> bool {
    v.0.reading().is_some_and(|parts| parts.seen > 0)
}

#[condition(mp)]
fn loaded(v: &Reading<(Scale,)>) -> bool {
    v.0.reading().is_some_and(|load| load.newtons > 2.0)
}

#[condition(mp)]
fn left_up(e: &State<(Irp6,)>) -> bool {
    e.0.measured().pose.translation.z > 1.0
}

#[condition(mp)]
fn right_up(e: &State<(Polycrank,)>) -> bool {
    e.0.measured().pose.translation.z > 1.0
}

/// The lists of a condition as they are written.
fn lists<C: Condition>(_: C) -> (String, String, String) {
    let short = |name: &str| name.replace("mrroc_robots::models::", "");
    let last = |name: &str| {
        let name = short(name);
        let parts = name.split_inclusive(['(', ',', ' ']);
        parts.map(|part| part.rsplit("::").next().unwrap_or(part).to_owned()).collect::<String>()
    };
    let (robots, sensors) = (std::any::type_name::<C::Robots>(), std::any::type_name::<C::Sensors>());
    (last(robots), last(sensors), C::CLASS.to_string())
}

#[test]
fn parts_share_their_lists_and_one_without_any_goes_with_all() {
    let of = |robots: &str, sensors: &str, class: &str| (robots.into(), sensors.into(), class.into());
    assert_eq!(lists(all((part_seen {}, left_up {}))), of("(Irp6,)", "(Camera,)", "MP f*3(c0, e, v)"));
    assert_eq!(lists(any((left_up {}, part_seen {}))), of("(Irp6,)", "(Camera,)", "MP f*3(c0, e, v)"));
    let twice = any((part_seen {}, elapsed(1.0), not(part_seen {}).held_for(0.1)));
    assert_eq!(lists(twice), of("AnyRobots", "(Camera,)", "MP f*1(c0, v)"));
    assert_eq!(lists(elapsed(1.0)), of("AnyRobots", "()", "ECP f*0(c)"));
    assert_eq!(lists(all([left_up {}; 3])), of("(Irp6,)", "()", "MP f*2(c0, e)"));
}

#[test]
fn separate_parts_have_lists_of_their_own_one_after_the_other() {
    let of = |robots: &str, sensors: &str, class: &str| (robots.into(), sensors.into(), class.into());
    let seen_and_loaded = all(separate((part_seen {}, loaded {})));
    assert_eq!(lists(seen_and_loaded), of("AnyRobots", "(Camera, Scale)", "MP f*1(c0, v)"));
    let both_up = all(separate((left_up {}, right_up {})));
    assert_eq!(lists(both_up), of("(Irp6, Polycrank)", "()", "MP f*2(c0, e)"));
    let whole = any(separate((seen_and_loaded, both_up, elapsed(1.0), part_seen {})));
    assert_eq!(lists(whole), of("(Irp6, Polycrank)", "(Camera, Scale, Camera)", "MP f*3(c0, e, v)"));

    // Each reads its own sensor.
    for (seen, newtons, both, one) in
        [(0, 0.0, false, false), (0, 3.0, false, true), (1, 0.0, false, true), (1, 3.0, true, true)]
    {
        let images = (SensorImage::new(Parts { seen }, 0), SensorImage::new(Load { newtons }, 0));
        let v = Reading::<(Camera, Scale)>::new(images);
        let (c0, e, t) = (Order::new(()), State::new(()), tick(DT));
        assert_eq!(all(separate((part_seen {}, loaded {}))).is_met(&c0, &e, &v, t), Ok(both));
        assert_eq!(any(separate((part_seen {}, loaded {}))).is_met(&c0, &e, &v, t), Ok(one));
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Payload)]
enum Phase {
    Approach,
    Grasp,
}

#[condition(ecp)]
fn told_to_grasp(order: &Order<Phase>) -> bool {
    order.value() == Phase::Grasp
}

#[test]
fn the_first_part_reads_the_order_and_the_others_may() {
    let mut told = all((told_to_grasp {}, elapsed(DT), any((told_to_grasp {}, holds(&[false; 3])))));
    let mut ask = |phase| told.is_met(&Order::new(phase), &State::new(()), &Reading::new(()), tick(DT));
    let phases = [Phase::Grasp, Phase::Approach, Phase::Grasp];
    assert_eq!(phases.map(|phase| ask(phase).expect("no fault")), [false, false, true]);
}

#[test]
fn no_step_allocates() {
    let mut condition = any((
        all((not(elapsed(1.0)), elapsed(0.5).held_for(0.1))),
        elapsed_since(elapsed(0.1), 0.5),
        not(all([elapsed(0.1); 3])),
    ));
    let (c0, e, v, t) = (Order::new(()), State::new(()), Reading::new(()), tick(DT));
    let before = mrroc_counting_allocator::bytes();
    for _ in 0..1000 {
        condition.is_met(&c0, &e, &v, t).expect("no fault");
    }
    assert_eq!(mrroc_counting_allocator::bytes(), before);
}

/// Counts the readings that it gave: a part is seen from the hundredth on.
struct Belt(u64);

impl VirtualSensor for Belt {
    type Kind = Camera;
    fn aggregate(&mut self, _: &ReadingOrder<()>) -> Result<Parts, Fault> {
        self.0 += 1;
        Ok(Parts { seen: self.0 / 100 })
    }
}

fn arm() -> RobotSetup<Irp6> {
    let start = Irp6::READY;
    RobotSetup::new("irp6", Irp6::nominal(), SimulatedIrp6::new(Irp6::nominal(), &start))
}

fn camera() -> SensorSetup<Belt> {
    SensorSetup::new("camera", Belt(0))
}

fn cell() -> Cell {
    Cell::new(Duration::from_millis(2))
}

#[test]
fn a_wait_of_the_mp_ends_in_the_step_of_the_equation() {
    let cell = cell().robot(arm()).sensor(camera()).program(|mp| {
        let (mut arm, mut camera) = (mp.robot::<Irp6>("irp6")?, mp.sensor::<Camera>("camera")?);
        let begun = mp.step();
        let grasped = all((part_seen {}.held_for(0.2), not(left_up {})));
        mp.wait_until((&mut arm,), (&mut camera,), any((grasped, elapsed(5.0))))?;
        // A Wait begins in the next step. It sees a part in its hundredth step, and 0.2 s are 100 steps with that one.
        assert_eq!(mp.step() - begun, 1 + 99 + 99);
        let begun = mp.step();
        mp.wait_until((), (), elapsed(0.5))?;
        assert_eq!(mp.step() - begun, 1 + 250);
        Ok(())
    });
    cell.run().expect("nothing is wrong");
}

#[test]
fn a_wait_of_an_ecp_is_suspended_with_its_timers() {
    let run = |suspended: bool| {
        let robot = arm().program(|ecp| {
            let mut camera = ecp.sensor::<Camera>("camera")?;
            let grasped = all((part_seen {}.held_for(0.2), elapsed(0.1)));
            ecp.wait_until((&mut camera,), grasped).map(drop)
        });
        let cell =
            cell().robot(robot).sensor(camera().of("irp6")).on_step(move |step, operator| match step {
                150 if suspended => operator.suspend(),
                450 if suspended => operator.resume(),
                _ => {}
            });
        cell.run().expect("nothing is wrong").steps
    };
    assert_eq!(run(true) - run(false), 300);
}
