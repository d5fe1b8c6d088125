//! Mistakes of someone who fills in a task project, met at run time: what the terminal shows of each.
//!
//! A cell is made as a task project makes it, of a file's text and kinds; the snapshot is the error and its help. What
//! the compiler finds is in `tests/macros`.

mod kinds;
mod motions;
mod sensing;

use mrroc::prelude::*;
use mrroc_robots::Irp6;

use kinds::{Slides, kinds};
use motions::{Ask, Circle, Elsewhere, Endless, Glide, Numbers, Ordered, Phase, Plan, Shift};
use sensing::{Table, Touch, touched, unwrapped};

const ONE: &str = r#"
step_ms = 2
[robots.arm]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
"#;

const TWO: &str = r#"
step_ms = 2
[robots.left]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
[robots.right]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
base = { xyz = [0.0, 1.5, 0.0] }
"#;

const OWN: &str = "step_ms = 2\n[robots.arm]\nkind = \"slides\"\nstart = [0.6, 0.0, 0.3]\n";

/// What the terminal shows of a cell that `fill_in` makes of a file.
fn shown(text: &str, fill_in: impl FnOnce(Cell, &CellFile) -> Result<Cell, CellError>) -> String {
    let cell = CellFile::parse("cell.toml", text).map_err(CellError::from).and_then(|file| {
        let cell = file.cell(&kinds())?;
        fill_in(cell, &file)
    });
    match cell.and_then(Cell::run) {
        Ok(report) => format!("ran {} steps", report.steps),
        Err(CellError::Fault(fault)) => match fault.help() {
            Some(help) => format!("error: {fault}\n help: {help}"),
            None => format!("error: {fault}"),
        },
        Err(error) => format!("error: {error}"),
    }
}

/// The same for a coordinator alone.
fn coordinated(text: &str, program: impl FnMut(&mut Mp) -> Result<(), Fault> + 'static) -> String {
    shown(text, |cell, _| Ok(cell.program(program)))
}

/// The same for one robot's program alone.
fn alone(program: impl FnMut(&mut Ecp<Irp6>) -> Result<(), Fault> + 'static) -> String {
    shown(ONE, |cell, _| Ok(cell.ecp("arm", program)))
}

/// The same for one motion of the arm.
fn moved(
    motion: impl FnMut(&mrroc::robot::State<Irp6>, f64) -> mrroc::generator::Demand<Irp6> + 'static,
) -> String {
    let mut motion = Some(motion);
    alone(move |ecp| ecp.move_robot((), Shift::new(motion.take().expect("one run"))).map(drop))
}

macro_rules! mistakes {
    ($($(#[$attribute:meta])* $name:ident: $shown:expr;)*) => {$(
        #[test]
        $(#[$attribute])*
        fn $name() {
            insta::assert_snapshot!($shown);
        }
    )*};
}

// Names.
mistakes! {
    a_robot_that_is_not_in_the_file: coordinated(TWO, |mp| mp.robot::<Irp6>("lefft").map(drop));
    a_robot_of_another_kind: coordinated(TWO, |mp| mp.robot::<Slides>("left").map(drop));
    two_handles_for_one_robot: coordinated(TWO, |mp| {
        let _left = mp.robot::<Irp6>("left")?;
        mp.robot::<Irp6>("left").map(drop)
    });
    a_program_for_a_robot_that_is_not_there: shown(TWO, |cell, _| Ok(cell.ecp::<Irp6>("lefft", |_| Ok(()))));
    a_program_for_another_kind_of_robot: shown(TWO, |cell, _| Ok(cell.ecp::<Slides>("left", |_| Ok(()))));
    a_kind_misspelt: coordinated(&ONE.replace("irp6", "irp-6"), |_| Ok(()));
    too_few_joints: coordinated(&ONE.replace("4.71, ", ""), |_| Ok(()));
    a_start_beyond_a_limit: coordinated(&ONE.replace("-1.57", "1.57"), |_| Ok(()));
    a_step_that_does_not_fit_the_drives: coordinated(&ONE.replace("step_ms = 2", "step_ms = 3"), |_| Ok(()));
    no_program: shown(ONE, |cell, _| Ok(cell));
}

// Sensors.
const TOUCH: &str = "[sensors.touch]\nof = \"arm\"\n";
mistakes! {
    a_sensor_that_is_not_in_the_file: shown(ONE, |cell, file| {
        Ok(cell.sensor(file.sensor("touch", Table)?).ecp::<Irp6>("arm", |_| Ok(())))
    });
    a_sensor_without_a_vsp: shown(&format!("{ONE}{TOUCH}"), |cell, _| {
        Ok(cell.ecp::<Irp6>("arm", |_| Ok(())))
    });
    a_sensor_that_the_program_misspells: shown(&format!("{ONE}{TOUCH}"), |cell, file| {
        Ok(cell.sensor(file.sensor("touch", Table)?).program(|mp| mp.sensor::<Touch>("tuch").map(drop)))
    });
    a_sensor_of_no_robot_in_an_ecp: shown(&format!("{ONE}[sensors.touch]\n"), |cell, file| {
        let cell = cell.sensor(file.sensor("touch", Table)?);
        Ok(cell.ecp::<Irp6>("arm", |ecp| ecp.sensor::<Touch>("touch").map(drop)))
    });
    a_sensor_of_a_robot_that_is_not_there: coordinated(&format!("{ONE}[sensors.touch]\nof = \"amr\"\n"), |_| Ok(()));
    a_sensor_that_answers_too_late: shown(&format!("{ONE}{TOUCH}latency_ms = 30\n"), |cell, file| {
        let cell = cell.sensor(file.sensor("touch", Table)?);
        Ok(cell.ecp::<Irp6>("arm", |ecp| {
            let mut touch = ecp.sensor::<Touch>("touch")?;
            ecp.wait_until((&mut touch,), touched {}).map(drop)
        }))
    });
    a_reading_that_is_not_there_yet: shown(&format!("{ONE}{TOUCH}mode = \"with delay\"\nlatency_ms = 5\n"), |cell, file| {
        let cell = cell.sensor(file.sensor("touch", Table)?);
        Ok(cell.ecp::<Irp6>("arm", |ecp| {
            let mut touch = ecp.sensor::<Touch>("touch")?;
            ecp.wait_until((&mut touch,), unwrapped {}).map(drop)
        }))
    });
}

// Demands.
mistakes! {
    a_motion_that_begins_elsewhere: moved(|_, _| mrroc::generator::Demand::joints(nalgebra::zero()));
    a_motion_that_begins_at_the_base: moved(|_, _| mrroc::generator::Demand::pose(mrroc::pose::Pose::identity()));
    too_fast: moved(motions::turn(|t| t * t));
    too_much_acceleration_in_between: moved(motions::turn(|t| 10.0 * t * t * t));
    too_fast_at_the_start: moved(motions::turn(|t| 0.1 * t));
    beyond_a_joint_limit: moved(motions::turn(|t| 0.3 * t * t * t / (1.0 + t * t)));
    too_high: moved(motions::lift(|t| 0.1 * t * t * t / (0.3 + t * t)));
    out_of_reach: moved(|_, t| {
        if t < 0.01 { mrroc::generator::Demand::hold() } else { mrroc::generator::Demand::pose(mrroc::pose::Pose::translation(5.0, 0.0, 1.0)) }
    });
    too_much_jerk: shown(OWN, |_, file| {
        let cell = file.cell(&kinds::with(Slides::with_jerk, true))?;
        Ok(cell.ecp::<Slides>("arm", |ecp| ecp.move_robot((), Glide::default()).map(drop)))
    });
    a_division_by_zero: moved(motions::turn(|t| 0.0 / (t - t)));
    a_rotation_that_is_not_normalised: moved(|e, _| {
        let mut pose = e.demanded().pose;
        pose.rotation = nalgebra::UnitQuaternion::new_unchecked(pose.rotation.into_inner() * 1.1);
        mrroc::generator::Demand::pose(pose)
    });
    a_panic_in_a_step: moved(|_, t| if t < 0.01 { mrroc::generator::Demand::hold() } else { panic!("not written yet") });
}

// Models and drives of one's own.
mistakes! {
    kinematics_that_disagree: shown(OWN, |_, file| {
        let cell = file.cell(&kinds::with(Slides::inverted, true))?;
        Ok(cell.ecp::<Slides>("arm", |ecp| ecp.move_robot((), Glide::default()).map(drop)))
    });
    drives_that_do_not_follow: shown(OWN, |_, file| {
        let cell = file.cell(&kinds::with(Slides::new, false))?;
        Ok(cell.ecp::<Slides>("arm", |ecp| ecp.move_robot((), Glide::default()).map(drop)))
    });
    a_limit_of_zero: shown(OWN, |_, file| {
        Ok(file.cell(&kinds::with(Slides::without_speed, true))?.ecp::<Slides>("arm", |_| Ok(())))
    });
    a_joint_that_stops_too_slowly: shown(OWN, |_, file| {
        Ok(file.cell(&kinds::with(Slides::with_weak_brakes, true))?.ecp::<Slides>("arm", |_| Ok(())))
    });
}

// Two levels.
mistakes! {
    a_struct_order_where_the_ecp_serves_an_enum: shown(ONE, |cell, _| {
        let cell = cell.ecp::<Irp6>("arm", |ecp| ecp.serve_all(|_, _: Phase| Ok(())));
        Ok(cell.program(|mp| {
            let mut arm = mp.robot::<Irp6>("arm")?;
            mp.move_robots((&mut arm,), (), Numbers).map(drop)
        }))
    });
    demands_where_the_ecp_serves_orders: shown(ONE, |cell, _| {
        let cell = cell.ecp::<Irp6>("arm", |ecp| ecp.serve_all(|_, _: Phase| Ok(())));
        Ok(cell.program(|mp| {
            let mut arm = mp.robot::<Irp6>("arm")?;
            mp.move_robots((&mut arm,), (), Circle).map(drop)
        }))
    });
    a_tight_motion_that_the_ecp_finishes: shown(ONE, |cell, _| {
        let cell = cell.ecp::<Irp6>("arm", |ecp| ecp.serve_all(|_, _: Plan| Ok(())));
        Ok(cell.program(|mp| {
            let mut arm = mp.robot::<Irp6>("arm")?;
            mp.move_robots((&mut arm,), (), Numbers).map(drop)
        }))
    });
    an_order_that_the_motion_does_not_read: shown(ONE, |cell, _| {
        let cell = cell.ecp::<Irp6>("arm", |ecp| {
            ecp.serve_all(|ecp, _: Phase| ecp.move_robot((), Ordered).map(drop))
        });
        Ok(cell.program(|mp| {
            let mut arm = mp.robot::<Irp6>("arm")?;
            mp.move_robots((&mut arm,), (), Ask(Phase::Out)).map(drop)
        }))
    });
    an_ecp_that_moves_without_an_order: shown(ONE, |cell, _| {
        let cell = cell.ecp::<Irp6>("arm", |ecp| ecp.move_robot((), Endless).map(drop));
        Ok(cell.program(|mp| {
            let mut arm = mp.robot::<Irp6>("arm")?;
            mp.move_robots((&mut arm,), (), Ask(Phase::Out)).map(drop)
        }))
    });
    an_ecp_that_serves_once_too_often: shown(ONE, |cell, _| {
        let cell = cell.ecp::<Irp6>("arm", |ecp| {
            ecp.serve(|_, _: Phase| Ok(()))?;
            ecp.serve(|_, _: Phase| Ok(()))
        });
        Ok(cell.program(|mp| {
            let mut arm = mp.robot::<Irp6>("arm")?;
            mp.move_robots((&mut arm,), (), Ask(Phase::Out)).map(drop)
        }))
    });
    a_motion_of_the_mp_that_begins_elsewhere: coordinated(TWO, |mp| {
        let mut left = mp.robot::<Irp6>("left")?;
        mp.move_robots((&mut left,), (), Elsewhere::default()).map(drop)
    });
    nothing_is_moved: coordinated(ONE, |_| Ok(()));
}

#[test]
fn a_motion_without_an_end_is_the_operators_to_end() {
    let file = CellFile::parse("cell.toml", ONE).expect("well-formed");
    let cell = file.cell(&kinds()).expect("kinds are known");
    let cell = cell.ecp::<Irp6>("arm", |ecp| ecp.move_robot((), Endless).map(drop));
    let error = cell.on_step(|step, operator| {
        if step == 5000 {
            operator.abort();
        }
    });
    let error = error.run().expect_err("aborted").to_string();
    assert!(error.contains("aborted by the operator"), "{error}");
}
