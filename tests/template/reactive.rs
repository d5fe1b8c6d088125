//! The set of behaviours that go by what is felt, as a project: the test that it brings.

extern crate self as task;

#[path = "../../template/src/arm.rs"]
pub mod arm;
#[path = "../../template/sets/reactive/ecp.rs"]
pub mod ecp;
#[path = "../../template/sets/reactive/generators/mod.rs"]
pub mod generators;
#[path = "../../template/sets/reactive/mp.rs"]
pub mod mp;
#[path = "../../template/sets/reactive/orders.rs"]
pub mod orders;
#[path = "../../template/sets/reactive/simulated.rs"]
mod simulated;
#[path = "../../template/sets/reactive/touch.rs"]
pub mod touch;

use mrroc::prelude::*;

/// As `lib.rs` of the set.
///
/// # Errors
/// What is wrong with the cell.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let cell = file.cell(&arm::kinds())?.sensor(file.sensor("touch", touch::Post)?);
    Ok(ecp::programs(cell).program(mp::coordinate))
}
