//! Plans that are recorded: a replay follows them and does not plan again.

use std::sync::OnceLock;
use std::time::Duration;

use mrroc::prelude::*;
use mrroc::program::Recorded;
use mrroc_planning::{FollowPlan, Here, Plan, Planner};
use mrroc_recording::{CutOff, Replay};
use mrroc_robots::clearance::Outline;
use mrroc_robots::{Serial, Simulated};
use proptest::prelude::*;

use super::cells::{around_a_box, six_axes, stopping};
use super::plans::{A, B};

fn bits(plan: &Plan, time: f64) -> Vec<u64> {
    plan.at(time).into_iter().map(f64::to_bits).collect()
}

/// Around the box, from `start` to `B`.
fn plan_of_an_arm(start: &[f64], seed: u64) -> Plan {
    let clearance = around_a_box().build(stopping()).expect("a clearance");
    let mut planner = Planner::new(clearance).expect("a planner").with_seed(seed);
    planner.plan(start, &[B.to_vec()]).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_plan_of_words_is_the_same_plan_to_the_bit_and_other_words_are_refused() {
    let plan = plan_of_an_arm(&A, 3);
    let words = plan.to_words();
    let again = Plan::from_words(&words).expect("the words of a plan");
    assert_eq!(again.to_words(), words);
    assert_eq!((again.duration(), again.length()), (plan.duration(), plan.length()));
    for k in 0..=300 {
        let time = plan.duration() * f64::from(k) / 290.0;
        assert_eq!(bits(&again, time), bits(&plan, time), "at {time}");
    }
    // It is of the same robots.
    assert!(again.motion::<Serial<6>>("arm").is_ok() && again.motion::<Serial<6>>("other").is_err());
    for length in 0..words.len() {
        assert!(Plan::from_words(&words[..length]).is_none(), "{length} of {} words", words.len());
    }
    assert!(Plan::from_words(&[&words[..], &[0]].concat()).is_none());
    println!("{} words of {:.3} s", words.len(), plan.duration());
}

proptest! {
    #[test]
    fn words_of_a_plan_that_were_changed_are_refused_or_are_a_plan(place in 0_usize..100_000, word: u64) {
        static WORDS: OnceLock<Vec<u64>> = OnceLock::new();
        let mut words = WORDS.get_or_init(|| plan_of_an_arm(&A, 3).to_words()).clone();
        let place = place % words.len();
        words[place] = word;
        if let Some(plan) = Plan::from_words(&words) {
            let _ = (plan.at(0.0), plan.to_words());
        }
    }
}

const STEP: Duration = Duration::from_millis(2);

/// An arm that stands at `A` and moves to `B` as `plan` says, in the MP's program or in its own.
fn cell(in_ecp: bool, plan: impl Fn(&[f64]) -> Plan + Clone + 'static) -> Cell {
    let outline = six_axes(Pose::identity());
    let robot = outline.robot().clone();
    let drives = Simulated::new(robot.clone(), &nalgebra::SVector::from_column_slice(&A));
    let setup = RobotSetup::new("arm", robot, drives);
    if in_ecp {
        return Cell::new(STEP).robot(setup.program(move |ecp| {
            let here = ecp.wait_until((), Here::<Serial<6>>::default())?.joints();
            let plan = ecp.recorded("plan", || Ok(plan(&here)))?;
            let follow: FollowPlan<Serial<6>> = plan.motion("arm")?;
            ecp.move_robot((), follow).map(drop)
        }));
    }
    Cell::new(STEP).robot(setup).program(move |mp| {
        let mut arm = mp.robot::<Serial<6>>("arm")?;
        let here =
            mp.wait_until((&mut arm,), (), mrroc_planning::HereAll::<(Serial<6>,)>::default())?.joints();
        let plan = mp.recorded("plan", || Ok(plan(&here)))?;
        mp.move_robot(&mut arm, (), plan.motion::<Serial<6>>("arm")?).map(drop)
    })
}

#[test]
fn a_replay_follows_the_recorded_plan_to_the_bit_and_does_not_plan_again() {
    for in_ecp in [false, true] {
        let file = std::env::temp_dir().join(format!("mrroc-plan-{in_ecp}-{}.mcap", std::process::id()));
        let recorded = cell(in_ecp, |here| plan_of_an_arm(here, 3)).record(mrroc_recording::to(&file));
        recorded.run().unwrap_or_else(|error| panic!("{error}"));
        let replay = cell(in_ecp, |_| panic!("a replay does not plan")).replay(&file, CutOff::Refused);
        let compared = replay.unwrap_or_else(|error| panic!("{error}"));
        assert!(compared.is_identical(), "{compared:?}");
        assert!(compared.steps > 500 && compared.end == Some(None), "{compared:?}");
        // Another plan would have been told apart: the comparison is to the bit.
        assert_ne!(plan_of_an_arm(&A, 3).to_words(), plan_of_an_arm(&A, 4).to_words());
        std::fs::remove_file(&file).expect("it is there");
    }
}
