//! The task: what the processes of the cell run.

pub mod arm; // the kind of robot that everything here is written for{% if levels != "mp" %}
pub mod ecp; // the programs of the robots{% endif %}
pub mod generators; // motions, a file each{% if levels != "ecp" %}
pub mod mp; // the program of the coordinator{% endif %}{% if levels == "both" %}
pub mod orders; // what the coordinator tells the robots{% endif %}{% if sensor == "touch" %}
pub mod touch; // a virtual sensor{% endif %}

use mrroc::prelude::*;

/// Puts the cell of `cell.toml` together.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let cell = file.cell(&arm::kinds())?; // its robots{% if sensor == "touch" %}
    let cell = cell.sensor(file.sensor("touch", touch::Table)?); // its sensors{% endif %}{% if levels != "mp" %}
    let cell = ecp::programs(cell); // what each robot does{% endif %}{% if levels != "ecp" %}
    let cell = cell.program(mp::coordinate); // what the coordinator does{% endif %}
    Ok(cell)
}
