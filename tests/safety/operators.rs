//! Robots with jerk limits under random operators.

use mrroc::cell::RobotSetup;
use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc::robot::Limits;
use mrroc::testing::{OperatorReport, RandomOperator};
use mrroc_generators::jerk::{JointLimits, JointState, JointTarget, MoveCursor, SynchronisedMove};
use mrroc_tests::{ExactDrive, Gantry, MS, Q};

/// Numbers from 0 to 1 (xorshift).
pub struct Random(u64);

impl Random {
    pub fn of(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Numbers of their own.
    pub fn fork(&mut self) -> Random {
        Random::of((self.next() * (1_u64 << 53) as f64) as u64)
    }
}

/// Two gantries to goals of their own, in the shortest time within a share of their limits.
struct Wander {
    random: Random,
    limits: [JointLimits<Q<3>>; 2],
    moves: [Option<MoveCursor<Q<3>>>; 2],
}

#[generator(mp)]
impl Wander {
    fn first_step(&mut self, e: &State<(Gantry, Gantry)>, t: Tick) -> Result<Step<(Gantry, Gantry)>, Fault> {
        for (i, robot) in [&e.0, &e.1].into_iter().enumerate() {
            let start = JointState::rest(robot.demanded().joints);
            let goal = Q::from_fn(|_, _| 1.6 * self.random.next() - 0.8);
            let motion = SynchronisedMove::new(&start, &JointTarget::rest(goal), &self.limits[i]);
            self.moves[i] = Some(MoveCursor::new(motion.map_err(|error| Fault::thrown(&error.to_string()))?));
        }
        let demanded = (e.0.demanded().joints, e.1.demanded().joints);
        Ok(self.advance(t).map_or(Step::Done, |(a, b)| {
            Step::Next((Demand::joints(a.unwrap_or(demanded.0)), Demand::joints(b.unwrap_or(demanded.1))))
        }))
    }

    fn next_step(&mut self, t: Tick) -> Step<(Gantry, Gantry)> {
        let demand = |q: Option<Q<3>>| q.map_or(Demand::hold(), Demand::joints);
        self.advance(t).map_or(Step::Done, |(a, b)| Step::Next((demand(a), demand(b))))
    }
}

impl Wander {
    /// The positions of both; `None` for one that has arrived, and when both have.
    fn advance(&mut self, t: Tick) -> Option<(Option<Q<3>>, Option<Q<3>>)> {
        let [a, b] = self.moves.each_mut().map(|cursor| {
            cursor.as_mut().and_then(|cursor| cursor.advance(t.dt)).map(|point| point.position)
        });
        (a.is_some() || b.is_some()).then_some((a, b))
    }
}

/// A cell whose robots use this share of their limits, as its seed says.
fn cell(seed: u64, share: f64) -> Cell {
    let mut random = Random::of(seed);
    let step = MS * [2, 4, 5, 10, 20][(random.next() * 5.0) as usize];
    let ts = step.as_secs_f64();
    let mut cell = Cell::new(step).stop_time(std::time::Duration::from_secs(2));
    let mut limits = Vec::new();
    for name in ["left", "right"] {
        let velocity = Q::from_fn(|_, _| 0.2 + 0.8 * random.next());
        let acceleration = Q::from_fn(|i, _| velocity[i] * (2.0 + 8.0 * random.next()));
        // From an acceleration that takes a fifth of a second to one that takes two steps.
        let jerk =
            Q::from_fn(|i, _| acceleration[i] / (2.0 * ts + (0.2 - 2.0 * ts).max(0.0) * random.next()));
        let (lower, upper) = (Q::repeat(-1.6), Q::repeat(1.6));
        let robot = Gantry::with_limits(Limits { lower, upper, velocity, acceleration, jerk: Some(jerk) });
        limits.push(JointLimits {
            velocity: velocity * share,
            acceleration: acceleration * share,
            jerk: jerk * share,
        });
        cell = cell.robot(RobotSetup::new(name, robot, ExactDrive::new(Q::zeros(), step)));
    }
    let limits = [limits[0], limits[1]];
    let mut round = 0;
    cell.program(move |mp| {
        let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
        loop {
            round += 1;
            let wander = Wander { random: Random::of(seed ^ round << 40), limits, moves: [None, None] };
            match mp.move_robots((&mut left, &mut right), (), wander) {
                Err(fault) if fault.kind() == FaultKind::Aborted => {}
                ended => {
                    ended?;
                }
            }
        }
    })
}

fn run(share: f64, runs: u64) -> OperatorReport {
    let report = RandomOperator::new(|seed| cell(seed, share)).runs(runs).steps(1500).run();
    println!("at {share} of the limits: {report}");
    report
}

#[test]
fn fault_80_robots_at_nine_tenths_of_their_limits_keep_them_whatever_an_operator_does() {
    let report = run(0.9, 60);
    assert!(report.is_clean() && report.false_stops().is_empty(), "{report}");
    assert!(report.periods() > 100_000, "{report}");
}

#[test]
fn fault_80_robots_beyond_nine_tenths_of_their_limits_keep_them_and_stop_in_time() {
    let report = run(0.95, 20);
    assert!(report.is_clean(), "{report}");
}

#[test]
#[ignore = "takes minutes: `just sweep-operators`"]
fn random_operators_of_twenty_thousand_cells() {
    let report = run(0.9, 20_000);
    assert!(report.is_clean() && report.false_stops().is_empty(), "{report}");
    let report = run(0.95, 20_000);
    assert!(report.is_clean(), "{report}");
}
