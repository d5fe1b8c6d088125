//! Inputs and outputs of robots by their names, as programs read and switch them, and what stops make of them.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use mrroc::cell::{CellError, InputSetup, OutputSetup, WrongSignal};
use mrroc::fault::FaultKind;
use mrroc::nalgebra::{Matrix3, Vector3};
use mrroc::prelude::*;
use mrroc::robot::{
    Channel, Channels, DriveFault, Driver, IdealDrives, Input, Load, Measured, Output, Outputs, Signals,
    Tool, Value, Values, WhenLost,
};
use mrroc_generators::generators::Tell;
use mrroc_robots::{IoBlock, NoJoints};
use mrroc_tests::{ExactDrive, Gantry, MS, Q, fault, gantry};

use crate::runtime::kit::Smooth;

/// What drives were told beside positions, in order.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Told {
    Outputs(Values),
    Carry(f64),
}

/// An exact drive with outputs, which writes down what it is told.
struct Switched {
    drive: ExactDrive<3>,
    told: Rc<RefCell<Vec<Told>>>,
    channels: Channels,
    outputs: Values,
}

impl Driver<Gantry> for Switched {
    fn period(&self) -> Duration {
        MS
    }
    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::measured(&self.drive)
    }
    fn tick(&mut self, demanded: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        Driver::<Gantry>::tick(&mut self.drive, demanded)
    }
    fn channels(&self) -> Channels {
        self.channels
    }
    fn signals(&self) -> Signals {
        Signals { outputs: self.outputs, ..Signals::OFF }
    }
    fn switch_outputs(&mut self, outputs: &Outputs) {
        self.outputs = outputs.onto(&self.outputs);
        self.told.borrow_mut().push(Told::Outputs(self.outputs));
    }
    fn carry(&mut self, load: &Load) {
        self.told.borrow_mut().push(Told::Carry(load.mass));
    }
}

const VACUUM: Channel = Channel::Digital(0);
const SPINDLE: Channel = Channel::Digital(1);
const BOTH: Values = Values::new(0b11, [0.0; 4]);
const HELD: Values = Values::new(0b01, [0.0; 4]);

/// A gantry with a vacuum, which holds, and a spindle, which a stop switches off.
fn switched() -> (RobotSetup<Gantry>, Rc<RefCell<Vec<Told>>>) {
    let told = Rc::<RefCell<Vec<Told>>>::default();
    let drive = Switched {
        drive: ExactDrive::at_origin(),
        told: Rc::clone(&told),
        channels: Channels::ALL,
        outputs: Values::OFF,
    };
    let setup = RobotSetup::new("g", Gantry::default(), drive)
        .output(OutputSetup::new("vacuum", VACUUM).holds_body())
        .output(OutputSetup::new("spindle", SPINDLE).turns_tool().on_stop(Value::Digital(false)));
    (setup, told)
}

/// Switches both on, and then does the rest.
fn with_both_on(
    cell: Cell,
    mut rest: impl FnMut(&mut Mp, &mut mrroc::generator::RobotHandle<Gantry>) -> Result<(), Fault> + 'static,
) -> Cell {
    cell.program(move |mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        let (vacuum, spindle) = (g.output::<bool>("vacuum")?, g.output::<bool>("spindle")?);
        mp.move_robot(&mut g, (), Tell::output(vacuum, true).and(spindle, true))?;
        assert!(g.value(vacuum) && g.value(spindle), "switched when the Move is over");
        rest(mp, &mut g)
    })
}

/// The input reads on.
struct On(Input<bool>);

#[condition(mp)]
fn on(c: &mut On, e: &State<(Gantry,)>) -> bool {
    e.0.value(c.0)
}

#[test]
fn a_program_switches_an_output_by_its_name_and_waits_for_an_input() {
    let (robot, _) = gantry("g");
    let robot = robot
        .output(OutputSetup::new("vacuum", VACUUM).holds_body())
        .input(InputSetup::new("sucked", Channel::Digital(3)).follows("vacuum", 50 * MS));
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        let (vacuum, sucked) = (g.output::<bool>("vacuum")?, g.input::<bool>("sucked")?);
        assert!(!g.value(vacuum) && !g.value(sucked));
        mp.move_robot(&mut g, (), Tell::output(vacuum, true))?;
        let told = mp.step();
        mp.wait_until((&mut g,), (), On(sucked))?;
        // Simulated, the input is 50 ms behind; the Wait sees it in the step after that.
        assert!((49..=52).contains(&(mp.step() - told)), "{} steps", mp.step() - told);
        assert!(g.value(vacuum) && g.value(sucked));
        mp.move_robot(&mut g, (), Tell::output(vacuum, false)).map(drop)
    });
    cell.run().expect("the names are there");
}

/// The input of a device without joints reads on.
struct Lit(Input<bool>);

#[condition(mp)]
fn lit(c: &mut Lit, e: &State<(IoBlock,)>) -> bool {
    e.0.value(c.0)
}

#[test]
fn a_device_without_joints_has_signals_beside_a_robot_that_moves_and_takes_no_position() {
    let block = IdealDrives::new(&IoBlock::new(), NoJoints::zeros(), 2 * MS);
    let block = RobotSetup::new("block", IoBlock::new(), block)
        .output(OutputSetup::new("lamp", VACUUM).on_stop(Value::Digital(false)))
        .input(InputSetup::new("lit", Channel::Digital(3)).follows("lamp", 50 * MS));
    let (robot, _) = gantry("g");
    let cell = Cell::new(MS).robot(robot).robot(block).program(|mp| {
        let (mut g, mut block) = (mp.robot::<Gantry>("g")?, mp.robot::<IoBlock>("block")?);
        let (lamp, lit) = (block.output::<bool>("lamp")?, block.input::<bool>("lit")?);
        mp.move_robot(&mut g, (), Smooth::to(0.1, 0.5))?;
        mp.move_robot(&mut block, (), Tell::output(lamp, true))?;
        let told = mp.step();
        mp.wait_until((&mut block,), (), Lit(lit))?;
        assert!((48..=53).contains(&(mp.step() - told)), "{} steps", mp.step() - told);
        mp.move_robot(&mut g, (), Smooth::to(0.0, 0.5))?;
        assert!(block.value(lamp), "what nobody switches stays");
        // It has one place.
        let aside = Demand::pose(Pose::translation(0.1, 0.0, 0.0));
        let refused = mp.move_robot(&mut block, (), Once(Some(aside)));
        Err(refused.map(drop).expect_err("there is nothing that could move"))
    });
    let refused = fault(cell.run());
    assert_eq!(refused.kind(), FaultKind::NoInverseKinematics, "{refused}");
}

/// One demand.
struct Once(Option<Demand<IoBlock>>);

#[generator(ecp)]
fn once(c: &mut Once) -> Step<IoBlock> {
    match c.0.take() {
        Some(demand) => Step::Next(demand),
        None => Step::Done,
    }
}

#[test]
fn the_program_of_an_ecp_has_the_same_names_and_a_demand_of_a_motion_switches() {
    struct Along(u32, Output<bool>);

    #[generator(ecp)]
    fn along(c: &mut Along) -> Step<Gantry> {
        c.0 += 1;
        match c.0 {
            5 => Step::Next(Demand::hold().with_output(c.1, true)),
            20 => Step::Done,
            _ => Step::Next(Demand::hold()),
        }
    }

    let (robot, told) = switched();
    let robot = robot.program(|ecp| {
        let vacuum = ecp.output::<bool>("vacuum")?;
        ecp.move_robot((), Along(0, vacuum))?;
        assert!(ecp.image().value(vacuum));
        let none = ecp.output::<bool>("vacum").expect_err("misspelt");
        assert!(none.to_string().contains("did you mean `vacuum`?"), "{none}");
        Ok(())
    });
    Cell::new(MS).robot(robot).run().expect("its names are there");
    // At the end a spindle that nobody has switched on is switched off all the same.
    assert_eq!(told.take(), [Told::Outputs(HELD); 2]);
}

#[test]
fn fault_104_outputs_take_their_values_for_a_stop_or_hold_at_a_fault_a_stop_an_abort_and_the_end() {
    let after = |told: &Rc<RefCell<Vec<Told>>>| told.take();
    // The end of the program.
    let (robot, told) = switched();
    with_both_on(Cell::new(MS).robot(robot), |_, _| Ok(())).run().expect("ends");
    assert_eq!(after(&told), [Told::Outputs(BOTH), Told::Outputs(HELD)], "the end");
    // A fault of the program.
    let (robot, told) = switched();
    let failing = with_both_on(Cell::new(MS).robot(robot), |mp, g| mp.move_robot(g, (), Failing).map(drop));
    assert_eq!(fault(failing.run()).kind(), FaultKind::Program);
    assert_eq!(after(&told), [Told::Outputs(BOTH), Told::Outputs(HELD)], "a fault");
    // A protective stop, and an abort, of an operator while it moves.
    for (name, press) in [
        ("a protective stop", mrroc::operator::Operator::protective_stop as fn(&mrroc::operator::Operator)),
        ("an abort", mrroc::operator::Operator::abort),
    ] {
        let (robot, told) = switched();
        let while_told = Rc::clone(&told);
        let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| {
            if step == 200 {
                press(operator);
            }
        });
        let cell = with_both_on(cell, move |mp, g| {
            let ended = mp.move_robot(g, (), Smooth::to(0.2, 1.0)).map(drop);
            assert_eq!(
                while_told.borrow().last(),
                Some(&Told::Outputs(HELD)),
                "when the instruction is over"
            );
            ended
        });
        let ended = fault(cell.run());
        assert!(matches!(ended.kind(), FaultKind::ProtectiveStop | FaultKind::Aborted), "{ended}");
        assert_eq!(after(&told), [Told::Outputs(BOTH), Told::Outputs(HELD)], "{name}");
    }
    // A suspension is none.
    let (robot, told) = switched();
    let seen = Rc::clone(&told);
    let cell = Cell::new(MS).robot(robot).on_step(move |step, operator| match step {
        200 => operator.suspend(),
        600 => operator.resume(),
        _ => {}
    });
    let cell = with_both_on(cell, move |mp, g| {
        mp.move_robot(g, (), Smooth::to(0.2, 1.0))?;
        assert_eq!(seen.borrow().len(), 1, "nothing is switched in a suspension");
        Ok(())
    });
    cell.run().expect("goes on");
    assert_eq!(after(&told).len(), 2, "at the end alone");
}

struct Failing;

#[generator(ecp)]
fn failing(_: &mut Failing) -> Result<Step<Gantry>, Fault> {
    Err(Fault::thrown("the drill is blunt"))
}

#[test]
fn fault_105_an_output_that_holds_a_body_or_drives_a_tool_must_fit_a_stop() {
    let wrong = |output: OutputSetup| {
        let (robot, _) = gantry("g");
        match Cell::new(MS).robot(robot.output(output)).program(|_| Ok(())).run() {
            Err(CellError::Signal { signal, wrong, .. }) if signal == "out" => wrong,
            other => panic!("{other:?}"),
        }
    };
    let out = |channel| OutputSetup::new("out", channel);
    let off = Value::Digital(false);
    assert_eq!(wrong(out(VACUUM).holds_body().on_stop(off)), WrongSignal::WouldLetGo);
    assert_eq!(wrong(out(VACUUM).turns_tool()), WrongSignal::WouldTurnOn);
    assert_eq!(
        wrong(out(Channel::Analog(0)).on_stop(off)),
        WrongSignal::Value(Channel::Analog(0), "off".to_owned())
    );
    let nan = Value::Analog(f64::NAN);
    assert_eq!(
        wrong(out(Channel::Analog(0)).on_stop(nan)),
        WrongSignal::Value(Channel::Analog(0), "NaN".to_owned())
    );
    assert_eq!(wrong(out(Channel::Digital(32))), WrongSignal::Channel(Channel::Digital(32), 32));
}

#[test]
fn names_and_channels_of_signals_must_be_there_and_single() {
    let (robot, _) = gantry("g");
    let robot = robot
        .output(OutputSetup::new("lamp", VACUUM))
        .output(OutputSetup::new("horn", VACUUM))
        .input(InputSetup::new("lamp", VACUUM))
        .input(InputSetup::new("no name", VACUUM))
        .input(InputSetup::new("sucked", VACUUM).follows("vacuum", MS));
    let error = Cell::new(MS).robot(robot).program(|_| Ok(())).run().expect_err("five mistakes").to_string();
    for told in [
        "signal `horn`: its channel, digital 0, is that of `lamp`",
        "signal `lamp`: another signal of the robot has this name",
        "signal `no name`:",
        "signal `sucked`: it follows `vacuum`, which is no output of the robot of its type",
    ] {
        assert!(error.contains(told), "{told}: {error}");
    }
    // Real drives have the channels that they say.
    let told = Rc::default();
    let channels = Channels { digital_outputs: 2, when_lost: WhenLost::Drop, ..Channels::NONE };
    let drive = Switched { drive: ExactDrive::at_origin(), told, channels, outputs: Values::OFF };
    let robot = RobotSetup::new("g", Gantry::default(), drive)
        .output(OutputSetup::new("horn", Channel::Digital(2)))
        .input(InputSetup::new("door", Channel::Digital(0)));
    let error = Cell::new(MS).robot(robot).program(|_| Ok(())).run().expect_err("two mistakes").to_string();
    assert!(
        error.contains("its drives have no channel digital 2\n help: write digital 0 to digital 1"),
        "{error}"
    );
    assert!(error.contains("have no digital channel of that direction"), "{error}");
}

#[test]
fn a_signal_that_a_robot_does_not_have_or_of_the_other_type_is_told_with_what_to_write() {
    let (robot, _) = gantry("g");
    let (other, _) = gantry("h");
    let robot = robot
        .output(OutputSetup::new("vacuum", VACUUM))
        .input(InputSetup::new("pressure", Channel::Analog(0)));
    let cell = Cell::new(MS).robot(robot).robot(other).program(|mp| {
        let (g, h) = (mp.robot::<Gantry>("g")?, mp.robot::<Gantry>("h")?);
        let told = |fault: Fault, expected: &str| {
            assert_eq!(fault.kind(), FaultKind::Config);
            assert!(fault.message().contains(expected), "{fault}");
        };
        told(g.output::<bool>("vacum").expect_err("misspelt"), "did you mean `vacuum`? it has: vacuum");
        told(g.input::<bool>("pressure").expect_err("analog"), "ask for it by `input::<f64>(\"pressure\")`");
        told(
            h.output::<bool>("lamp").expect_err("none"),
            "[robots.h.outputs] of cell.toml, lamp = \"digital 0\"",
        );
        Ok(())
    });
    cell.run().expect("nothing is asked of the robots");
}

#[test]
fn fault_106_an_output_of_another_robot_is_refused_and_nothing_is_switched() {
    let (robot, told) = switched();
    let cell = Cell::new(MS).robot(robot).program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        let strange = Output::<f64>::of(Channel::Analog(3)).expect("an analog one");
        mp.move_robot(&mut g, (), Tell::output(strange, 1.0)).map(drop)
    });
    let refused = fault(cell.run());
    assert_eq!(refused.kind(), FaultKind::NoOutput);
    assert!(refused.to_string().contains("no output is named for analog 3"), "{refused}");
    let stopped = told.take();
    assert!(stopped.iter().all(|told| *told == Told::Outputs(Values::OFF)), "{stopped:?}");
}

#[test]
fn drives_are_told_the_load_of_the_first_tool_and_of_another_one() {
    let pen = Tool {
        frame: Pose::translation(0.0, 0.0, 0.1),
        load: Load { mass: 0.3, centre: Vector3::z() * 0.04, inertia: Matrix3::identity() * 1e-4 },
    };
    let drill = Tool { load: Load { mass: 2.0, ..pen.load }, ..pen };
    let (robot, told) = switched();
    let cell = Cell::new(MS)
        .robot(robot.tool(pen.frame).load(pen.load))
        .tool("drill", drill)
        .frame("table", Pose::translation(0.4, 0.0, 0.1));
    let cell = cell.program(|mp| {
        let mut g = mp.robot::<Gantry>("g")?;
        assert_eq!(mp.frame("table")?, Pose::translation(0.4, 0.0, 0.1));
        assert!(mp.frame("tabel").expect_err("misspelt").message().contains("did you mean `table`?"));
        let tool = mp.tool("drill")?;
        mp.move_robot(&mut g, (), Tell::tool(tool)).map(drop)
    });
    cell.run().expect("its names are there");
    let told: Vec<_> = told.take().into_iter().filter(|told| matches!(told, Told::Carry(_))).collect();
    assert_eq!(told, [Told::Carry(0.3), Told::Carry(2.0)]);
    let (robot, _) = gantry("g");
    let heavy = Tool { load: Load { mass: -1.0, ..Load::NONE }, ..pen };
    let error =
        Cell::new(MS).robot(robot).tool("drill", heavy).program(|_| Ok(())).run().expect_err("no body");
    assert_eq!(error.to_string(), "tool `drill`: its mass is negative, or no number");
}
