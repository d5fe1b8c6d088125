//! The MP's and the ECPs' halves of a motion: loose, tight, ended, disagreeing.

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use mrroc_tests::{Gantry, MS, Turntable, fault, gantry, peaks, turntable};

use crate::runtime::kit::{Along, Coast, Counter, Counting, Phase, Smooth, transmit};

#[generator(mp)]
fn separate() -> Always<(Gantry, Gantry), Phase> {
    Always((Phase::Approach, Phase::Retreat))
}

#[test]
fn in_a_loose_motion_each_robot_goes_on_its_own_and_the_early_one_holds() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    let program = |duration: f64| {
        move |ecp: &mut mrroc::program::Ecp<Gantry>| {
            ecp.serve(|ecp, phase: Phase| match phase {
                Phase::Approach => ecp.move_robot((), Smooth::to(0.2, duration)).map(drop),
                Phase::Retreat => ecp.move_robot((), Smooth::to(-0.2, duration)).map(drop),
            })?;
            // The second motion may begin only when the MP has ended the first for both.
            ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.0, duration)).map(drop))
        }
    };
    Cell::new(MS)
        .robot(left.program(program(0.4)))
        .robot(right.program(program(0.8)))
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            mp.move_robots((&mut left, &mut right), (), separate())?;
            assert_eq!((left.demanded().joints[0], right.demanded().joints[0]), (0.2, -0.2));
            mp.move_robots((&mut left, &mut right), (), separate {})?;
            Ok(())
        })
        .run()
        .expect("both keep the limits");
    let (left, right) = (left_trace.borrow(), right_trace.borrow());
    let leaves =
        |trace: &[mrroc_tests::Q<3>], at: f64| trace.iter().rposition(|q| q[0] == at).expect("was there");
    assert!(left.iter().filter(|q| q[0] == 0.2).count() > 395, "the early one did not hold");
    assert!(leaves(&left, 0.2).abs_diff(leaves(&right, -0.2)) <= 1, "the second motions began apart");
}

/// What an arm does by itself, where the MP says how far.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
enum Errand {
    Rest,
    Go { to: f64, duration: f64 },
}

/// One errand for each arm.
struct Errands(Errand, Errand);

#[generator(mp)]
fn errands(c: &mut Errands) -> Always<(Gantry, Gantry), Errand> {
    Always((c.0, c.1))
}

#[test]
fn in_a_loose_motion_the_mp_says_where_and_each_robot_gets_there_on_its_own() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    let program = |ecp: &mut mrroc::program::Ecp<Gantry>| {
        ecp.serve_all(|ecp, errand| match errand {
            Errand::Rest => Ok(()),
            Errand::Go { to, duration } => ecp.move_robot((), Smooth::to(to, duration)).map(drop),
        })
    };
    let far = Errand::Go { to: 0.125, duration: 0.8 };
    let near = Errand::Go { to: -0.125, duration: 0.4 };
    Cell::new(MS)
        .robot(left.program(program))
        .robot(right.program(program))
        .program(move |mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            mp.move_robots((&mut left, &mut right), (), Errands(far, near))?;
            assert_eq!((left.demanded().joints[0], right.demanded().joints[0]), (0.125, -0.125));
            mp.move_robots((&mut left, &mut right), (), Errands(Errand::Rest, far))?;
            assert_eq!((left.demanded().joints[0], right.demanded().joints[0]), (0.125, 0.125));
            Ok(())
        })
        .run()
        .expect("both keep the limits");
    // The right arm came early to -0.125 and stood there until the left one had come, 0.4 s later.
    assert!(right_trace.borrow().iter().filter(|q| q[0] == -0.125).count() > 395);
    assert!(left_trace.borrow().iter().filter(|q| q[0] == 0.125).count() > 795);
}

/// Numbers for a tight motion: a smoothstep along x.
struct Numbers {
    t: f64,
}

#[generator(mp)]
fn numbers(c: &mut Numbers, t: Tick) -> Step<(Gantry, Gantry), Along> {
    if c.t >= 0.4 {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(0.4);
    let u = c.t / 0.4;
    let x = 0.2 * u * u * (3.0 - 2.0 * u);
    Step::Next((Along { x }, Along { x: -x }))
}

#[test]
fn in_a_tight_motion_the_orders_numbers_arrive_in_their_own_step() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    let follow = |ecp: &mut mrroc::program::Ecp<Gantry>| {
        ecp.serve(|ecp, _: Along| ecp.move_robot((), transmit {}).map(drop))
    };
    let report = Cell::new(MS)
        .robot(left.program(follow))
        .robot(right.program(follow))
        .program(|mp| {
            let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
            mp.move_robots((&mut left, &mut right), (), Numbers { t: 0.0 })?;
            assert_eq!(left.demanded().joints[0], 0.2);
            Ok(())
        })
        .run()
        .expect("both keep the limits");
    let (left, right) = (left_trace.borrow(), right_trace.borrow());
    assert!(left.iter().zip(right.iter()).all(|(l, r)| l[0] == -r[0]));
    assert!((400..=403).contains(&report.steps), "{}", report.steps);
}

#[test]
fn finishing_a_tight_motion_early_is_a_fault() {
    let ((left, _), (right, _)) = (gantry("left"), gantry("right"));
    let follow = |ecp: &mut mrroc::program::Ecp<Gantry>| {
        ecp.serve(|ecp, _: Along| ecp.move_robot((), transmit {}).map(drop))
    };
    let give_up = |ecp: &mut mrroc::program::Ecp<Gantry>| ecp.serve(|_, _: Along| Ok(()));
    let fault = fault(
        Cell::new(MS)
            .robot(left.program(follow))
            .robot(right.program(give_up))
            .program(|mp| {
                let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
                mp.move_robots((&mut left, &mut right), (), Numbers { t: 0.0 }).map(drop)
            })
            .run(),
    );
    assert_eq!(fault.kind(), FaultKind::FinishedEarly);
    assert_eq!(fault.robot().expect("named").as_str(), "right");
}

#[test]
fn halves_that_disagree_about_the_payload_are_refused_before_anything_moves() {
    let ((left, left_trace), (right, right_trace)) = (gantry("left"), gantry("right"));
    let loose = |ecp: &mut mrroc::program::Ecp<Gantry>| {
        ecp.serve(|ecp, _: Phase| ecp.move_robot((), Smooth::to(0.2, 0.4)).map(drop))
    };
    let tight = |ecp: &mut mrroc::program::Ecp<Gantry>| {
        ecp.serve(|ecp, _: Along| ecp.move_robot((), transmit {}).map(drop))
    };
    let fault = fault(
        Cell::new(MS)
            .robot(left.program(loose))
            .robot(right.program(tight))
            .program(|mp| {
                let (mut left, mut right) = (mp.robot::<Gantry>("left")?, mp.robot::<Gantry>("right")?);
                mp.move_robots((&mut left, &mut right), (), separate {}).map(drop)
            })
            .run(),
    );
    assert_eq!(fault.kind(), FaultKind::PayloadMismatch);
    assert!(fault.to_string().contains("`Along`") && fault.to_string().contains("`Phase`"), "{fault}");
    assert!(left_trace.borrow().iter().chain(right_trace.borrow().iter()).all(|q| q.norm() == 0.0));
}

#[condition(mp)]
fn counted(v: &Reading<(Counter,)>) -> bool {
    v.0.reading().is_some_and(|reading| reading.count >= 150)
}

#[generator(mp, until = stop_counting, sensors = (Counter,))]
fn for_a_while(_c: &mut ForAWhile) -> Always<(Gantry,), Phase> {
    Always((Phase::Approach,))
}

struct ForAWhile;

fn stop_counting(v: &Reading<(Counter,)>) -> bool {
    counted(v)
}

#[test]
fn a_loose_motion_that_the_mp_ends_brakes_on_its_own_path_and_skips_what_would_follow() {
    let (robot, trace) = gantry("g");
    let robot = robot.program(|ecp| {
        ecp.serve(|ecp, _: Phase| {
            ecp.move_robot((), Smooth::to(0.8, 1.6))?;
            let next = ecp.move_robot((), Smooth::to(0.0, 1.6)).expect_err("the motion was ended");
            assert_eq!(next.kind(), FaultKind::InstructionEnded);
            Err(next)
        })
    });
    Cell::new(MS)
        .robot(robot)
        .sensor(SensorSetup::new("counter", Counting::default()))
        .program(|mp| {
            let (mut g, mut counter) = (mp.robot::<Gantry>("g")?, mp.sensor::<Counter>("counter")?);
            mp.move_robots((&mut g,), (&mut counter,), ForAWhile)?;
            // What one step may take away: a T.
            assert!(g.demanded().velocity.norm() <= 0.01, "not at standstill");
            Ok(())
        })
        .run()
        .expect("braking keeps the limits");
    let trace = trace.borrow();
    assert!(peaks(&trace, 1e-3).1 <= 10.0 + 1e-6);
    let end = trace.last().expect("recorded")[0];
    assert!(end > 0.05 && end < 0.4, "{end}");
}

#[test]
fn robots_of_different_kinds_go_together_and_handles_are_unique() {
    let ((g, _), (t, _)) = (gantry("g"), turntable("t"));
    Cell::new(MS)
        .robot(g)
        .robot(t)
        .program(|mp| {
            let mut g = mp.robot::<Gantry>("g")?;
            assert_eq!(mp.robot::<Gantry>("g").expect_err("taken").kind(), FaultKind::Config);
            let wrong = mp.robot::<Gantry>("t").expect_err("of another kind");
            assert!(wrong.to_string().contains("another kind"), "{wrong}");
            let missing = mp.robot::<Gantry>("gg").expect_err("not there").to_string();
            assert!(missing.contains("`gg`") && missing.contains("g, t"), "{missing}");
            let mut t = mp.robot::<Turntable>("t")?;
            mp.move_robots((&mut g, &mut t), (), Mixed { steps: 100 })?;
            Ok(())
        })
        .run()
        .expect("nothing is wrong");
}

struct Mixed {
    steps: u32,
}

#[generator(mp)]
fn mixed(c: &mut Mixed) -> Step<(Gantry, Turntable)> {
    if c.steps == 0 {
        return Step::Done;
    }
    c.steps -= 1;
    Step::Next((mrroc::generator::Demand::hold(), mrroc::generator::Demand::hold()))
}

#[test]
fn an_ecp_that_moves_outside_serve_is_told_what_to_write() {
    let (g, _) = gantry("g");
    let g = g.program(|ecp| ecp.move_robot((), Coast::new(0.0, 1)).map(drop));
    let fault = fault(
        Cell::new(MS)
            .robot(g)
            .program(|mp| {
                let mut g = mp.robot::<Gantry>("g")?;
                mp.move_robots((&mut g,), (), one_robot {}).map(drop)
            })
            .run(),
    );
    assert!(fault.to_string().contains("ecp.serve"), "{fault}");
}

#[generator(mp)]
fn one_robot() -> Always<(Gantry,), Phase> {
    Always((Phase::Retreat,))
}

#[test]
fn an_ecp_that_waits_for_an_instruction_that_never_comes_is_reported() {
    let (g, _) = gantry("g");
    let g = g.program(|ecp| ecp.serve(|_, _: Phase| Ok(())));
    let fault = fault(Cell::new(MS).robot(g).program(|_| Ok(())).run());
    assert_eq!(fault.robot().expect("named").as_str(), "g");
    assert!(fault.message().contains("MP's program is over"), "{fault}");
}

#[test]
fn an_ecp_serves_all_instructions_until_the_mps_program_is_over() {
    let (robot, trace) = gantry("g");
    let served = std::rc::Rc::new(std::cell::Cell::new(0));
    let count = std::rc::Rc::clone(&served);
    let robot = robot.program(move |ecp| {
        ecp.serve_all(|ecp, phase: Phase| {
            count.set(count.get() + 1);
            let goal = if phase == Phase::Approach { 0.1 } else { 0.0 };
            ecp.move_robot((), Smooth::to(goal, 0.3)).map(drop)
        })
    });
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        for phase in [Phase::Approach, Phase::Retreat, Phase::Approach] {
            mp.move_robots((&mut g,), (), Ask(phase))?;
        }
        Ok(())
    });
    cell.run().expect("the end of the MP's program is no fault");
    assert_eq!(served.get(), 3);
    assert_eq!(trace.borrow().last().expect("recorded")[0], 0.1);
}

struct Ask(Phase);

#[generator(mp)]
fn ask(c: &mut Ask) -> Always<(Gantry,), Phase> {
    Always((c.0,))
}

#[test]
fn an_ecp_that_serves_all_still_ends_with_the_fault_of_the_cell_or_its_own() {
    for thrown_by_mp in [true, false] {
        let (robot, _) = gantry("g");
        let robot = robot.program(move |ecp| {
            ecp.serve_all(|ecp, _: Phase| {
                ecp.move_robot((), Smooth::to(0.1, 0.3))?;
                if thrown_by_mp { Ok(()) } else { Err(mrroc::fault::Fault::thrown("of the arm")) }
            })
        });
        let cell = Cell::new(MS).robot(robot).program(|mp| {
            let mut g = mp.robot::<Gantry>("g")?;
            mp.move_robots((&mut g,), (), Ask(Phase::Approach))?;
            Err(mrroc::fault::Fault::thrown("of the coordinator"))
        });
        let told = fault(cell.run()).message().to_owned();
        assert_eq!(told, if thrown_by_mp { "of the coordinator" } else { "of the arm" });
    }
}
