//! Two arms that go to and fro, to be looked at and operated: `cargo run --release -p mrroc-examples --example to_and_fro --features
//! panel -- --cell ports/panel/examples/cell.toml --processes --panel`.
//!
//! `--turns` behind a `--` says how often they go, a thousand times by default.

use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc_generators::generators::JointMove;
use mrroc_robots::{Irp6, Six, simulated};

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    Ok(file.cell(&simulated())?.program(to_and_fro))
}

fn to_and_fro(mp: &mut Mp) -> Result<(), Fault> {
    let turns = own_number("turns", 1000_u32)?;
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let to = |column: f64, arm: f64| {
        let mut q = Six::new(column, -1.57 + arm, 0.16 - 0.5 * arm, -0.16, 4.71, 0.8 * column);
        q[3] += 0.3 * arm;
        JointMove::<Irp6>::to(q, Six::repeat(0.4), Six::repeat(0.8))
    };
    for _ in 0..turns {
        mp.move_robots((&mut left, &mut right), (), Each::of((to(0.5, 0.3), to(-0.3, 0.2))))?;
        mp.move_robots((&mut left, &mut right), (), Each::of((to(-0.4, -0.1), to(0.4, 0.3))))?;
    }
    Ok(())
}
