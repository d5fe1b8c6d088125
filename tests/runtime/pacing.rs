//! Robots that say themselves when their servo periods begin, on clocks that differ from the cell's and from one another's.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::AfterFault;
use mrroc::fault::FaultKind;
use mrroc::operator::Latch;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, Measured, Pace, Pulse};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault};

use crate::runtime::kit::Smooth;

/// How long the robots may say nothing.
const TIMEOUT: Duration = Duration::from_millis(20);

/// What a controller was told: for each of its periods, and when by the cell's clock that period began [s].
type Told = Rc<RefCell<Vec<(u64, f64, Q<3>)>>>;

/// A robot whose controller counts periods on a clock of its own, and tells each of them over a network with jitter.
struct Controller {
    drives: ExactDrive<3>,
    /// Length of its period by the cell's clock [s], and when its first one begins.
    period: f64,
    first: f64,
    /// Largest delay of the network [s]; it is drawn anew for each message.
    jitter: f64,
    random: u64,
    /// The next message: which period begins, and when it comes [s].
    next: (u64, f64),
    /// Periods of which the message is lost, and the one from which on it says nothing until it is switched on again.
    lost: fn(u64) -> bool,
    silent_from: u64,
    begun: u64,
    told: Told,
}

impl Controller {
    /// A period of so many milliseconds on a clock that is slow by `rate`.
    fn new(millis: u32, rate: f64, jitter: f64) -> (Controller, Told) {
        let told = Told::default();
        let period = f64::from(millis) * 1e-3 * (1.0 + rate);
        let mut controller = Controller {
            drives: ExactDrive::new(Q::zeros(), MS * millis),
            period,
            first: 0.3777e-3,
            jitter,
            random: 0x9e37_79b9_7f4a_7c15,
            next: (0, 0.0),
            lost: |_| false,
            silent_from: u64::MAX,
            begun: 0,
            told: Rc::clone(&told),
        };
        controller.draw(0);
        (controller, told)
    }

    fn begins(&self, count: u64) -> f64 {
        self.first + self.period * count as f64
    }

    fn draw(&mut self, count: u64) {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        let share = (self.random >> 11) as f64 / (1_u64 << 53) as f64;
        self.next = (count, self.begins(count) + self.jitter * share);
    }
}

impl Driver<Gantry> for Controller {
    fn period(&self) -> Duration {
        Driver::<Gantry>::period(&self.drives)
    }

    fn pace(&self) -> Pace {
        Pace::Robot { timeout: TIMEOUT }
    }

    fn pulse(&mut self, now: Duration) -> Result<Option<Pulse>, DriveFault> {
        let mut pulse = None;
        while self.next.1 <= now.as_secs_f64() {
            let (count, came) = self.next;
            if count < self.silent_from && !(self.lost)(count) {
                let age = Duration::from_secs_f64((now.as_secs_f64() - came).max(0.0));
                pulse = Some(Pulse { count, age });
                self.begun = count;
            }
            self.draw(count + 1);
        }
        Ok(pulse)
    }

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drives)
    }

    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        self.told.borrow_mut().push((self.begun, self.begins(self.begun), *demanded));
        Driver::<Gantry>::tick(&mut self.drives, demanded)
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.silent_from = u64::MAX;
        Ok(())
    }
}

/// Both robots go on at one speed.
struct Cruise {
    time: f64,
    seconds: f64,
    /// [m/s], [m]
    speed: f64,
    travelled: f64,
}

#[generator(mp)]
fn cruise(c: &mut Cruise, t: Tick) -> Step<(Gantry, Gantry)> {
    if c.time >= c.seconds {
        return Step::Done;
    }
    c.time += t.dt;
    // It comes to its speed within half a second.
    c.travelled += c.speed * (c.time / 0.5).min(1.0) * t.dt;
    let here = || Demand::joints(Q::<3>::new(c.travelled, 0.0, 0.0));
    Step::Next((here(), here()))
}

/// Two robots in one motion of so many seconds, on clocks that are 200 ppm apart and have 0.2 ms of jitter.
fn two_robots_go_together_for(seconds: f64) {
    // Gantries have a range of a metre.
    let speed = 0.9 / seconds;
    let (left, left_told) = Controller::new(1, 1e-4, 0.2e-3);
    let (right, right_told) = Controller::new(2, -1e-4, 0.2e-3);
    Cell::new(MS)
        .robot(RobotSetup::new("left", Gantry::default(), left))
        .robot(RobotSetup::new("right", Gantry::default(), right))
        .program(move |mp| {
            let (mut left, mut right) = (mp.robot("left")?, mp.robot("right")?);
            let cruise = Cruise { time: 0.0, seconds, speed, travelled: 0.0 };
            mp.move_robots((&mut left, &mut right), (), cruise).map(drop)
        })
        .run()
        .expect("no fault");

    // Where each controller is told to be when a period ends, as a line over the cell's time, once all is at speed.
    let behind = [(&left_told, 1e-3), (&right_told, 2e-3)].map(|(told, nominal)| {
        let told = told.borrow();
        let steady: Vec<_> =
            told.iter().filter(|(_, began, _)| (2.0..seconds - 0.5).contains(began)).collect();
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for pair in steady.windows(2) {
            let [(before, _, from), (count, began, to)] = [pair[0], pair[1]];
            assert_eq!(count - before, 1, "a period is missed or repeated");
            let step = (to[0] - from[0]) / speed;
            worst = worst.max((step / nominal - 1.0).abs());
            sum += to[0] / speed - began;
        }
        // Each period gets its own position: as far on as a period is long, to a hundredth.
        assert!(worst < 0.01, "a period's displacement differs by {worst}");
        sum / (steady.len() - 1) as f64 - nominal
    });
    // Both are as far behind their demands at the ends of their periods: at equal times they are at equal places.
    assert!((behind[0] - behind[1]).abs() < 10e-6, "{behind:?} s");
}

#[test]
fn two_robots_on_clocks_of_their_own_are_together_at_every_time_and_miss_and_repeat_no_period() {
    two_robots_go_together_for(20.0);
}

#[test]
#[ignore = "takes minutes: `just pacing`"]
fn two_robots_on_clocks_of_their_own_are_together_for_so_many_seconds() {
    let seconds = std::env::var("MRROC_PACING").expect("`just pacing` sets MRROC_PACING");
    two_robots_go_together_for(seconds.parse().expect("MRROC_PACING is a number"));
}

#[test]
fn fault_88_messages_that_are_lost_leave_out_their_periods_and_disturb_no_other_one() {
    let (mut controller, told) = Controller::new(1, 5e-5, 0.0);
    // One, and 19 in a row.
    controller.lost = |count| count == 300 || (400..419).contains(&count);
    Cell::new(MS)
        .robot(
            RobotSetup::new("g", Gantry::default(), controller)
                .program(|ecp| ecp.move_robot((), Smooth::to(0.1, 0.8)).map(drop)),
        )
        .run()
        .expect("no fault");
    let told = told.borrow();
    let counts: Vec<_> = told.iter().map(|(count, _, _)| *count).collect();
    let expected: Vec<_> =
        (0..=*counts.last().expect("some")).filter(|c| *c != 300 && !(400..419).contains(c)).collect();
    assert_eq!(counts, expected);
    // Where they were told to be is one smooth curve over the controller's own time: the acceleration of `Smooth` is at most
    // 6 d / T², and the filtered beginnings of periods shake it by less than a hundredth.
    let most = 6.0 * 0.1 / (0.8 * 0.8);
    for three in told.windows(3) {
        if three[2].0 - three[0].0 != 2 {
            continue;
        }
        let second = three[2].2[0] - 2.0 * three[1].2[0] + three[0].2[0];
        assert!(second.abs() <= 1.01 * most * 1e-6, "{second} at {}", three[1].0);
    }
}

#[test]
fn fault_88_a_robot_that_says_nothing_for_too_long_stops_its_cell_and_is_heard_again_after_a_reset() {
    let cell = |controller: Controller| {
        Cell::new(MS).robot(
            RobotSetup::new("g", Gantry::default(), controller)
                .program(|ecp| ecp.move_robot((), Smooth::to(0.1, 0.8)).map(drop)),
        )
    };
    let (mut controller, told) = Controller::new(2, 0.0, 0.1e-3);
    controller.silent_from = 200;
    let lost = fault(cell(controller).run());
    assert_eq!(
        (lost.kind(), lost.message()),
        (FaultKind::RobotStopped, "communication lost: the robot has said nothing for 20 ms")
    );
    assert_eq!(lost.robot().map(|name| name.to_string()).as_deref(), Some("g"));
    assert_eq!(told.borrow().last().map(|(count, ..)| *count), Some(199));

    let (mut controller, told) = Controller::new(2, 0.0, 0.1e-3);
    controller.silent_from = 200;
    let resets = cell(controller).after_fault(AfterFault::AwaitReset).on_step(|_, operator| {
        if operator.latch() != Latch::Clear {
            let _ = operator.acknowledge();
            let _ = operator.reset();
        }
    });
    resets.run().expect("the program runs again, and ends");
    let last = told.borrow().last().map(|(_, _, q)| q[0]).expect("it moved");
    assert!((last - 0.1).abs() < 1e-12, "{last}");
}

#[test]
fn a_robot_that_paces_itself_may_have_periods_of_any_length() {
    let run = |millis| {
        let (controller, told) = Controller::new(millis, 0.0, 0.0);
        let setup = RobotSetup::new("g", Gantry::default(), controller)
            .program(|ecp| ecp.move_robot((), Smooth::to(0.1, 0.8)).map(drop));
        Cell::new(MS * 2).robot(setup).run().expect("no fault");
        told.take().last().map(|(_, _, q)| q[0]).expect("it moved")
    };
    for millis in [1, 3, 4, 5, 12] {
        assert!((run(millis) - 0.1).abs() < 1e-12, "{millis} ms");
    }
    let setup = RobotSetup::new("g", Gantry::default(), ExactDrive::new(Q::zeros(), MS * 3));
    let refused = Cell::new(MS * 2).robot(setup).run().expect_err("3 ms and 2 ms");
    assert!(refused.to_string().contains("must be multiples of one another"), "{refused}");
}

#[test]
fn fault_88_a_cell_whose_robots_could_not_stop_in_time_after_a_silence_is_refused() {
    let cell = |stop| {
        let (controller, _) = Controller::new(2, 0.0, 0.0);
        let setup = RobotSetup::new("g", Gantry::default(), controller).program(|_| Ok(()));
        Cell::new(MS * 2).robot(setup).stop_time(stop)
    };
    // At 1 m/s and 10 m/s² braking takes 100 ms; a lost peer is noticed after 22 ms, a silent robot after 20 ms.
    assert!(cell(MS * 122).check().is_ok());
    // With a robot that may say nothing for 200 ms, any robot of the cell may stop so much later.
    let waiting = |stop| {
        let (controller, _) = Controller::new(2, 0.0, 0.0);
        let setup = RobotSetup::new("p", Gantry::default(), Waits(controller)).program(|_| Ok(()));
        cell(stop).robot(setup)
    };
    assert!(waiting(MS * 301).check().is_ok());
    let refused = waiting(MS * 299).check().expect_err("too late").to_string();
    assert!(refused.contains("robot `g` joint 1: a stop may take 0.300 s, at most 0.299 s"), "{refused}");
}

/// A controller that may say nothing for 200 ms.
struct Waits(Controller);

impl Driver<Gantry> for Waits {
    fn period(&self) -> Duration {
        self.0.period()
    }

    fn pace(&self) -> Pace {
        Pace::Robot { timeout: MS * 200 }
    }

    fn pulse(&mut self, now: Duration) -> Result<Option<Pulse>, DriveFault> {
        self.0.pulse(now)
    }

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        self.0.measured()
    }

    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        self.0.tick(demanded)
    }
}
