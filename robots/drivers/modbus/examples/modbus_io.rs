//! Switches the relays of a device by Modbus TCP one after another, and waits each time until an input has followed:
//! `cargo run -p mrroc-examples --example modbus_io -- --cell robots/drivers/modbus/examples/cell.toml --processes`, where a device is at
//! the address of that file.
//!
//! `--times` behind a `--` says how often, once by default.

use mrroc::generator::RobotHandle;
use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc::robot::{Input, WhenLost};
use mrroc_generators::generators::Tell;
use mrroc_modbus::{Layout, Scale, with_modbus_io};
use mrroc_robots::{IoBlock, simulated};

/// Eight inputs, four relays at coils 16 to 19, and an analog input and output of 0 to 10 V on 12 bits.
const LAYOUT: Layout = Layout {
    digital_inputs: 0..8,
    digital_outputs: 16..20,
    analog_inputs: 0..1,
    analog_outputs: 0..1,
    analog_input: VOLTAGE,
    analog_output: VOLTAGE,
    when_lost: WhenLost::Drop,
};
const VOLTAGE: Scale = Scale { at_zero: 0.0, per_count: 10.0 / 4095.0 };

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    Ok(file.cell(&with_modbus_io(simulated(), LAYOUT))?.program(switch))
}

/// Holds when an input reads as it should.
struct Reads(Input<bool>, bool);

#[condition(mp)]
fn reads(c: &mut Reads, e: &State<(IoBlock,)>) -> bool {
    e.0.value(c.0) == c.1
}

/// Holds when an analog input reads more than this [V].
struct Above(Input<f64>, f64);

#[condition(mp)]
fn above(c: &mut Above, e: &State<(IoBlock,)>) -> bool {
    e.0.value(c.0) > c.1
}

fn switch(mp: &mut Mp) -> Result<(), Fault> {
    let mut cabinet = mp.robot::<IoBlock>("cabinet")?;
    let times = own_number("times", 1)?;
    for _ in 0..times {
        switch_once(mp, &mut cabinet)?;
    }
    let (level, pressure) = (cabinet.output::<f64>("level")?, cabinet.input::<f64>("pressure")?);
    mp.move_robot(&mut cabinet, (), Tell::output(level, 2.5))?;
    mp.wait_at_most((&mut cabinet,), (), Above(pressure, 2.4), 2500)?;
    println!("pressure: {:.3} V", cabinet.value(pressure));
    Ok(())
}

fn switch_once(mp: &mut Mp, cabinet: &mut RobotHandle<IoBlock>) -> Result<(), Fault> {
    for name in ["first", "second"] {
        let (relay, follows) =
            (cabinet.output::<bool>(name)?, cabinet.input::<bool>(&format!("{name}_follows"))?);
        for on in [true, false] {
            mp.move_robot(cabinet, (), Tell::output(relay, on))?;
            mp.wait_at_most((&mut *cabinet,), (), Reads(follows, on), 2500)?;
        }
    }
    Ok(())
}
