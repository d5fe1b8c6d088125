//! The drives against a model of a robot, under a virtual clock.

mod model;
mod real_time;

use std::net::IpAddr;

use mrroc::robot::StopCause;

use self::model::Fixture;
use super::*;
use crate::arm::Fr3;
use crate::link::{FARTHEST, IN_TIME, REASON, STARTED};
use crate::message::testing::{bytes, standing};
use crate::message::{COMMUNICATION, Collision, JOINTS, Stiffness};
use crate::stops::{ENDED, OTHER_VERSION, REFUSED, TOO_FAR, stop};

const START: [f64; JOINTS] = [0.0, 0.25, 0.0, -1.5, 0.0, 1.5, 0.5];

/// The robot has begun to go at 0.1 rad/s, by its own word.
fn begins(state: &mut State) {
    state.q_d = state.q_d.map(|q| q + 1e-4);
    state.dq_d = [0.1; JOINTS];
}

/// A little beside the start, so that a motion is asked for.
fn aside() -> Joints {
    Joints::from(START) + Joints::repeat(1e-6)
}

#[test]
fn a_motion_begins_where_the_robot_is_held_and_every_state_gets_one_answer() {
    let mut fixture = Fixture::moving();
    let held = fixture.drives().held().expect("known");
    assert_eq!(held, Joints::from(START));
    let mut last = held;
    for period in 1..=50 {
        let demanded = aside() + Joints::repeat(1e-8 * f64::from(period));
        fixture.drives().tick(&demanded).expect("told");
        let (told, is_last) = fixture.told().expect("every state is answered");
        assert!(!is_last);
        assert!((told - last).amax() < 1e-6, "a jump of {} rad", (told - last).amax());
        fixture.follows(&told);
        let pulse = fixture.says(|_| {}).expect("it goes on");
        assert_eq!(pulse, Pulse { count: fixture.count(), age: Duration::ZERO });
        last = told;
    }
    let measured = fixture.drives().measured().expect("read");
    assert!((measured.position - last).amax() < 1e-6);
    assert_eq!(fixture.answers().lost, 0);
}

#[test]
fn a_state_is_answered_for_700_us_and_then_counts_as_lost() {
    let mut fixture = Fixture::moving();
    fixture.pass(IN_TIME - Duration::from_nanos(1));
    fixture.drives().tick(&aside()).expect("told");
    let (told, _) = fixture.told().expect("in time");
    fixture.follows(&told);
    fixture.says(|_| {}).expect("it goes on");
    assert_eq!(fixture.answers().lost, 0);
    fixture.pass(IN_TIME);
    fixture.drives().tick(&aside()).expect("too late is no fault");
    assert_eq!(fixture.told(), None);
    fixture.says(|_| {}).expect("it goes on by itself");
    // The robot stands as good as still, so its motion is the same with an answer and without.
    assert_eq!(fixture.answers().lost, 0);
    // By its own motion, which is another one.
    fixture.pass(IN_TIME);
    fixture.drives().tick(&aside()).expect("too late is no fault");
    fixture.says(|state| state.q_d[0] += 1e-3).expect("it goes on by itself");
    assert_eq!((fixture.told(), fixture.answers().lost), (None, 1));
}

#[test]
fn the_wrench_that_the_robot_estimates_is_told_at_its_flange_and_none_where_it_is_none() {
    let mut fixture = Fixture::opened();
    assert_eq!(fixture.drives().wrench(), Some(Wrench::default()));
    // The robot pushes by 4 N along z and 1 N along x, 0.25 m before its flange: (0, 0, 0.25) x (-1, 0, -4) = (0, -0.25, 0).
    fixture
        .says(|state| {
            state.external.F_T_EE[14] = 0.25;
            state.external.K_F_ext_hat_K = [1.0, 0.0, 4.0, 0.0, 0.0, 0.0];
        })
        .expect("it says something");
    let expected = Wrench::new([-1.0, 0.0, -4.0].into(), [0.0, -0.25, 0.0].into());
    assert_eq!(fixture.drives().wrench(), Some(expected));
    fixture.says(|state| state.external.K_F_ext_hat_K[5] = f64::NAN).expect("it says where it is");
    assert_eq!(fixture.drives().wrench(), None);
    fixture.drives().close();
    assert_eq!(fixture.drives().wrench(), None);
}

#[test]
fn fault_96_a_robot_of_another_version_or_none_at_all_is_told_and_nothing_moves() {
    let open = |version, change: fn(&mut model::Simulation)| {
        let mut fixture = Fixture::new(version, |settings| settings);
        change(&mut fixture.simulation.borrow_mut());
        let opened = fixture.drives().open();
        assert_eq!((fixture.told(), fixture.request()), (None, None));
        (opened, fixture.now())
    };
    let took = Duration::from_millis(3);
    assert_eq!(open(Some(5), |_| {}), (Err(OTHER_VERSION), took));
    assert_eq!(open(None, |_| {}), (Err(ABSENT), Duration::ZERO));
    assert_eq!(open(Some(10), |_| {}), (Ok(()), took + PERIOD));
    // It takes the connection and answers nothing, or says nothing then, for 2 s.
    assert_eq!(open(Some(10), |simulation| simulation.answers_after = None), (Err(ABSENT), TIMEOUT));
    assert_eq!(open(Some(10), |simulation| simulation.says_after = None), (Err(ABSENT), TIMEOUT));
    assert_eq!(open(Some(10), |simulation| simulation.says_after = Some(TIMEOUT)), (Err(ABSENT), TIMEOUT));
    // What it says last is in time.
    let late = |simulation: &mut model::Simulation| simulation.answers_after = Some(TIMEOUT - 2 * PERIOD);
    assert_eq!(open(Some(10), late), (Ok(()), TIMEOUT - PERIOD));
}

#[test]
fn fault_96_a_reset_connects_again_after_a_silence_of_more_than_20_ms_and_not_before() {
    let mut fixture = Fixture::opened();
    let silence = FciSettings::new(model::ROBOT.ip()).silence;
    assert_eq!(
        (silence, fixture.drives().pace()),
        (Duration::from_millis(20), Pace::Robot { timeout: silence })
    );
    fixture.pass(silence);
    assert_eq!((fixture.drives().switch_on(), fixture.connections()), (Ok(()), 1));
    fixture.pass(Duration::from_nanos(1));
    assert_eq!((fixture.drives().switch_on(), fixture.connections()), (Ok(()), 2));
    // It has closed the connection.
    fixture.simulation.borrow_mut().cut();
    assert_eq!(fixture.drives().pulse(Duration::ZERO), Err(CUT_OFF));
    assert_eq!((fixture.drives().switch_on(), fixture.connections()), (Ok(()), 3));
    // It is not there any more.
    fixture.simulation.borrow_mut().cut();
    fixture.simulation.borrow_mut().version = None;
    assert_eq!(fixture.drives().switch_on(), Err(ABSENT));
    assert_eq!(fixture.drives().switch_on(), Err(CLOSED));
}

#[test]
fn a_motion_that_the_robot_ends_by_itself_is_told_with_its_reason_or_5_states_later_without() {
    // Before it has begun it is refused; later it has ended.
    for (runs, fault) in [(false, REFUSED), (true, ENDED)] {
        let mut fixture = Fixture::opened();
        fixture.says(|_| {}).expect("it says something");
        fixture.drives().tick(&aside()).expect("asked");
        let asked = fixture.request().expect("a request");
        if runs {
            fixture.answer(&asked, &[STARTED]);
            let moves = |state: &mut State| (state.mode, state.follows_positions) = (Mode::Move, true);
            fixture.says(moves).expect("it moves");
        }
        fixture.answer(&asked, &[2]);
        let before = fixture.count();
        let told: Vec<_> = (0..REASON).map(|_| fixture.says(|_| {}).map(|pulse| pulse.count)).collect();
        let goes_on = (1..REASON).map(|state| Ok(before + state));
        assert_eq!(told, goes_on.chain([Err(fault)]).collect::<Vec<_>>());
    }
    let mut fixture = Fixture::opened();
    fixture.says(|_| {}).expect("it says something");
    fixture.drives().tick(&aside()).expect("asked");
    let asked = fixture.request().expect("a request");
    fixture.answer(&asked, &[2]);
    fixture.says(|_| {}).expect("it goes on");
    let reflex = |state: &mut State| (state.mode, state.reason) = (Mode::Reflex, Some("cartesian_reflex"));
    assert_eq!(fixture.says(reflex), Err(stop(StopCause::Reflex, "cartesian_reflex")));
}

#[test]
fn drives_that_are_closed_bring_the_robot_to_rest_and_end_its_motion_first() {
    let mut fixture = Fixture::moving();
    fixture.says(begins).expect("it goes on");
    fixture.simulation.borrow_mut().play();
    fixture.drives().close();
    let simulation = fixture.simulation.borrow();
    assert_eq!((simulation.state.mode, simulation.state.follows_positions), (Mode::Idle, false));
    assert!(simulation.now < TIMEOUT, "{:?}", simulation.now);
    drop(simulation);
    // One that says nothing any more is let go after 2 s.
    let mut fixture = Fixture::moving();
    let before = fixture.now();
    fixture.drives().close();
    assert_eq!(fixture.now() - before, TIMEOUT);
    assert_eq!(fixture.drives().measured(), Err(CLOSED));
}

#[test]
fn fault_97_a_reflex_is_told_by_its_name_and_a_reset_recovers_without_a_motion() {
    let mut fixture = Fixture::moving();
    let reflex = |state: &mut State| {
        (state.mode, state.follows_positions) = (Mode::Reflex, false);
        state.reason = Some("cartesian_reflex");
    };
    assert_eq!(fixture.says(reflex).map(|_| ()), Err(stop(StopCause::Reflex, "cartesian_reflex")));
    assert_eq!(fixture.drives().recover(), Ok(Recovery::GoesOn));
    let asked = fixture.request().expect("a request");
    assert_eq!((asked[0], asked.len()), (10, 12));
    assert_eq!(fixture.drives().recover(), Ok(Recovery::GoesOn));
    assert!(fixture.drives().switch_on().is_err(), "the reflex holds still");
    // It has recovered. Its answer comes before the state that shows it.
    fixture.answer(&asked, &[0]);
    let recovered = fixture.says(|state| (state.mode, state.reason) = (Mode::Idle, None));
    assert!(recovered.is_ok());
    assert_eq!(fixture.drives().recover(), Ok(Recovery::Over));
    assert_eq!(fixture.drives().switch_on(), Ok(()));
    fixture.drives().tick(&Joints::from(START)).expect("held");
    assert_eq!((fixture.told(), fixture.request()), (None, None), "a reset moves nothing");
}

#[test]
fn fault_97_stops_at_the_robot_are_told_and_who_may_clear_them() {
    use mrroc::robot::ClearedBy;

    for (mode, reason, cause, cleared_by) in [
        (Mode::Reflex, Some(COMMUNICATION), StopCause::CommunicationLost, ClearedBy::Operator),
        (Mode::UserStopped, None, StopCause::Safeguard, ClearedBy::PersonAtRobot),
        (Mode::Guiding, None, StopCause::HandGuiding, ClearedBy::PersonAtRobot),
        (Mode::Other, None, StopCause::PowerOff, ClearedBy::Pendant),
    ] {
        let mut fixture = Fixture::moving();
        let said = fixture.says(|state| (state.mode, state.reason) = (mode, reason));
        let Err(DriveFault::Stopped(stop)) = said else { panic!("{mode:?}: {said:?}") };
        assert_eq!((stop.cause(), stop.cleared_by()), (cause, cleared_by));
        // Only a reflex is what a reset may clear.
        assert_eq!(
            fixture.drives().recover().is_ok_and(|recovery| recovery == Recovery::GoesOn),
            mode == Mode::Reflex
        );
        assert!(fixture.drives().switch_on().is_err(), "{mode:?}");
    }
}

#[test]
fn fault_98_where_nobody_demands_anything_the_robot_is_brought_to_rest_and_held_and_its_motion_ends() {
    let mut fixture = Fixture::moving();
    fixture.drives().switch_off();
    fixture.says(begins).expect("it goes on");
    let (mut last, mut states) = (Joints::from(START) + Joints::repeat(1e-4), 1);
    loop {
        let (position, is_last) = fixture.told().expect("every state is answered, from the first on");
        assert!((position - last).amax() < 2e-4, "a jump");
        if is_last {
            assert_eq!(position, last, "it ends at rest");
            break;
        }
        fixture.follows(&position);
        last = position;
        fixture.says(|_| {}).expect("it goes on");
        states += 1;
    }
    assert!(
        last.iter().zip(START).all(|(last, start)| *last > start + 2e-4),
        "it has braked on its path: {last}"
    );
    // 0.1 rad/s at 7.5 rad/s² take 14 states at least; by the drives' law of critical damping it takes longer.
    assert!((14..1000).contains(&states), "{states}");
    fixture.says(|state| (state.mode, state.follows_positions) = (Mode::Idle, false)).expect("it stands");
    assert_eq!((fixture.told(), fixture.drives().switch_on()), (None, Ok(())));
}

#[test]
fn fault_99_a_demand_that_the_robot_would_not_take_is_refused_and_the_robot_is_held() {
    for demanded in [Joints::from(START) + Joints::repeat(2.0 * FARTHEST), Joints::repeat(f64::NAN)] {
        let mut fixture = Fixture::moving();
        let refused = fixture.drives().tick(&demanded);
        assert!(refused.is_err(), "{refused:?}");
        if demanded[0].is_finite() {
            assert_eq!(refused, Err(TOO_FAR));
        }
        // It is told to stay, not where it cannot go.
        let (told, is_last) = fixture.told().expect("the state is answered");
        assert!((told - Joints::from(START)).amax() < 1e-6 && is_last, "{told}");
    }
    let mut fixture = Fixture::moving();
    fixture.simulation.borrow_mut().cut();
    assert_eq!(fixture.says(|_| {}), Err(CUT_OFF), "by the next look");
}

const COLLISION: Collision = Collision {
    contact_torques: [10.0; JOINTS],
    collision_torques: [20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0],
    contact_forces: [5.0; 6],
    collision_forces: [25.0; 6],
};
const USUAL: Stiffness = [3000.0, 3000.0, 3000.0, 2500.0, 2500.0, 2000.0, 2000.0];
const SOFT: Stiffness = [300.0; JOINTS];

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().expect("eight"))).collect()
}

#[test]
fn fault_111_thresholds_and_stiffness_are_told_while_the_robot_stands_and_other_sets_when_it_comes_to_rest() {
    let mut fixture = Fixture::opened_with(|settings| FciSettings {
        collision: Some(COLLISION),
        stiffness: [Some(USUAL), Some(SOFT), None],
        ..settings
    });
    assert!(fixture.drives().has_regulator(0, 1) && !fixture.drives().has_regulator(0, 2));
    let start = Joints::from(START);
    // The request in the robot's next state.
    let next = |fixture: &mut Fixture, demanded: &Joints| {
        fixture.says(|_| {}).expect("it goes on");
        fixture.drives().tick(demanded).expect("told");
        fixture.request().expect("a request")
    };
    // Something is demanded already; it waits.
    let asked = next(&mut fixture, &aside());
    assert_eq!((asked[0], asked.len()), (3, 428));
    let told = doubles(&asked[12..]);
    assert_eq!(
        (&told[..7], &told[7..14]),
        (&COLLISION.contact_torques[..], &COLLISION.collision_torques[..])
    );
    assert_eq!((&told[14..28], told[28], told[34]), (&told[..14], 5.0, 25.0));
    fixture.says(|_| {}).expect("it goes on");
    fixture.drives().tick(&aside()).expect("told");
    assert_eq!(fixture.request(), None, "until it has answered");
    fixture.answer(&asked, &[0]);
    let asked = next(&mut fixture, &aside());
    assert_eq!((asked[0], doubles(&asked[12..])), (4, USUAL.to_vec()));
    fixture.answer(&asked, &[0]);
    let asked = next(&mut fixture, &aside());
    assert_eq!(asked[0], 1, "now it moves");
    fixture.says(|state| (state.mode, state.follows_positions) = (Mode::Move, true)).expect("it moves");
    fixture.answer(&asked, &[STARTED]);
    fixture.says(|_| {}).expect("it moves");
    fixture.forget_told();
    // Joint 4 alone is softer. The motion, which is at rest, ends.
    fixture.drives().choose_regulators(&Regulators::uniform(0).with(3, 1));
    let held = fixture.drives().held().expect("known");
    fixture.drives().tick(&held).expect("held");
    assert_eq!(fixture.told(), None, "the state was answered before");
    fixture.says(|_| {}).expect("it goes on");
    assert_eq!(fixture.told().map(|(_, is_last)| is_last), Some(true));
    fixture.says(|state| (state.mode, state.follows_positions) = (Mode::Idle, false)).expect("it stands");
    fixture.drives().tick(&start).expect("told");
    let asked = fixture.request().expect("a request");
    let mut softer = USUAL;
    softer[3] = SOFT[3];
    assert_eq!((asked[0], doubles(&asked[12..])), (4, softer.to_vec()));
    // It refuses that.
    fixture.answer(&asked, &[2]);
    let refused = fixture.says(|_| {}).expect_err("it refuses");
    assert!(refused.to_string().contains("the robot refuses the stiffness"), "{refused}");
}

#[test]
fn fault_111_a_robot_that_does_not_answer_what_it_is_told_is_told_after_2_s() {
    let mut fixture = Fixture::opened_with(|settings| FciSettings { collision: Some(COLLISION), ..settings });
    let goes_on = (0..).take_while(|_| {
        fixture.says(|_| {}).expect("it says something");
        fixture.drives().tick(&Joints::from(START)).is_ok()
    });
    // It was asked in the first of these states; they are a millisecond apart.
    assert_eq!(goes_on.count(), 2001);
    let told = fixture.drives().tick(&Joints::from(START)).expect_err("it goes on").to_string();
    assert!(told.contains("the robot does not answer"), "{told}");
}

#[test]
fn fault_117_a_load_is_told_while_the_robot_stands_and_one_that_it_refuses_is_a_fault() {
    let mut fixture = Fixture::opened();
    let start = Joints::from(START);
    // Nothing was said of it: the robot is told nothing.
    fixture.says(|_| {}).expect("it says something");
    fixture.drives().tick(&start).expect("held");
    assert_eq!(fixture.request(), None);
    // kg, m in the flange, kg m² about the centre; a matrix that is told column by column.
    let mut inertia = nalgebra::Matrix3::from_diagonal(&[1e-3, 2e-3, 3e-3].into());
    (inertia[(0, 1)], inertia[(1, 0)]) = (1e-4, 1e-4);
    let load = Load { mass: 1.5, centre: [0.01, 0.02, 0.03].into(), inertia };
    fixture.drives().carry(&load);
    fixture.drives().tick(&start).expect("told");
    let asked = fixture.request().expect("a request");
    // 12 bytes of a header and 13 numbers of 64 bits: libfranka's `SetLoad`.
    assert_eq!((asked[0], asked.len()), (9, 116));
    let told = doubles(&asked[12..]);
    assert_eq!(told, [1.5, 0.01, 0.02, 0.03, 1e-3, 1e-4, 0.0, 1e-4, 2e-3, 0.0, 0.0, 0.0, 3e-3]);
    fixture.answer(&asked, &[0]);
    for _ in 0..3 {
        fixture.says(|_| {}).expect("it goes on");
        fixture.drives().tick(&start).expect("held");
    }
    assert_eq!(fixture.request(), None, "it knows that now");
    // An end effector of Desk, which the robot adds by itself: half a kilogram at the origin of the flange.
    fixture.says(|state| state.end_effector = Load::point(0.5, [0.0; 3].into())).expect("it goes on");
    fixture.drives().carry(&Load::point(1.5, [0.0, 0.0, 0.03].into()));
    fixture.drives().tick(&start).expect("told");
    let asked = fixture.request().expect("a request");
    assert_eq!(doubles(&asked[12..])[..4], [1.0, 0.0, 0.0, 0.045], "1.5 times 0.03 is 1.0 times 0.045");
    fixture.answer(&asked, &[0]);
    fixture.says(|state| state.end_effector = Load::NONE).expect("it goes on");
    fixture.drives().carry(&Load { mass: 30.0, ..load });
    fixture.drives().tick(&start).expect("told");
    let asked = fixture.request().expect("a request");
    assert_eq!(doubles(&asked[12..])[0], 30.0);
    fixture.answer(&asked, &[2]);
    let refused = fixture.says(|_| {}).expect_err("it refuses");
    assert!(refused.to_string().contains("the robot refuses the load"), "{refused}");
}
