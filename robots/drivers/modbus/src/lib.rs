//! Devices with inputs and outputs for mrroc, by Modbus TCP; and the client that drivers of other devices share.
//!
//! **Never run on a real device.** It was run against servers of pymodbus (`tests/peers/drives`).
//!
//! A thread of its own exchanges messages with the device, as fast as it answers and at most 200 times a second. The servo periods of
//! the EDP hand it what outputs were told and take what was read last; they never wait for it. The protocol is written here, because
//! what is needed of it, seven kinds of messages, is shorter than the asynchronous runtime around a library's client, and every limit
//! on what comes stays in sight.
//!
//! **Outputs** are switched one by one, and only those that a program has told something: what another master switches stays as it
//! is. Each is read back; one that is not as it was told for a while is a fault.
//!
//! ```no_run
//! use mrroc::robot::WhenLost;
//! use mrroc_modbus::{Layout, with_modbus_io};
//!
//! // kind = "modbus-io" in cell.toml, with an address: a device of eight inputs and four relays, whose watchdog switches them off.
//! let layout = Layout { digital_inputs: 0..8, digital_outputs: 16..20, when_lost: WhenLost::Drop, ..Layout::NONE };
//! let kinds = with_modbus_io(mrroc_robots::simulated(), layout);
//! ```

pub mod client;
mod drives;
mod exchange;
mod layout;
pub mod message;
mod settings;

#[cfg(test)]
mod tests;

use mrroc::cell::RobotSetup;
use mrroc::robot::IdealDrives;
use mrroc_launch::cell_file::Kinds;
use mrroc_robots::{IoBlock, NoJoints};

pub use drives::ModbusIo;
pub use layout::{Layout, Scale};
pub use settings::ModbusIoSettings;

/// The port of Modbus TCP.
pub const PORT: u16 = 502;

/// Adds the kind `modbus-io`: an [`IoBlock`] at an `address`, on port 502 unless it says another one. All devices of this kind have one
/// layout; for others put [`ModbusIo`] into a set-up of your own. Simulated inputs and outputs stand in where nothing real may switch.
#[must_use]
pub fn with_modbus_io(kinds: Kinds, layout: Layout) -> Kinds {
    kinds.with("modbus-io", move |entry| {
        let settings = ModbusIoSettings::new(entry.address_and_port(PORT)?, layout.clone());
        let stand_in = IdealDrives::new(&IoBlock::new(), NoJoints::zeros(), settings.period);
        Ok(RobotSetup::new(entry.name(), IoBlock::new(), ModbusIo::new(settings)).stand_in(stand_in))
    })
}
