//! A device that speaks Modbus TCP, and how it is reached.

use core::time::Duration;
use std::net::SocketAddr;

use crate::layout::Layout;

/// A device at an address.
#[derive(Clone, Debug, PartialEq)]
pub struct ModbusIoSettings {
    /// Where it, or the gateway before it, listens.
    pub address: SocketAddr,
    /// Its unit there: 1 by default.
    pub unit: u8,
    /// Where its inputs and outputs are.
    pub layout: Layout,
    /// How long its answer to a question may take, 200 ms by default: then the connection counts as lost, and where a gateway is only busy,
    /// after five times as long. The cell does not count this in the time of its stops.
    pub timeout: Duration,
    /// How often the EDP looks at what was exchanged, 2 ms by default; it divides the step, or the step divides it.
    pub period: Duration,
}

impl ModbusIoSettings {
    /// With the defaults.
    #[must_use]
    pub const fn new(address: SocketAddr, layout: Layout) -> ModbusIoSettings {
        ModbusIoSettings {
            address,
            unit: 1,
            layout,
            timeout: Duration::from_millis(200),
            period: Duration::from_millis(2),
        }
    }
}
