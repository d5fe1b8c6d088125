//! The drives of a device without joints: nothing moves, and its outputs switch.

use core::time::Duration;

use mrroc::robot::{
    Channel, Channels, DriveFault, Driver, Measured, Outputs, Recovery, Robot, Signals, Value,
};
use mrroc_driver_kit::{Exchange, Network};
use mrroc_robots::NoJoints;

use crate::exchange::{CLOSED, Link, Shared, connect};
use crate::settings::ModbusIoSettings;

const BEYOND: DriveFault =
    DriveFault::Other("an analog output was told a value that its register cannot say: is its scale right?");

/// The drives of any robot without joints, by Modbus TCP.
#[derive(Debug)]
pub struct ModbusIo {
    settings: ModbusIoSettings,
    network: Network,
    link: Option<Link>,
    /// What programs have told outputs so far.
    told: Outputs,
    is_beyond: bool,
    /// Whether the link is one that a reset has begun.
    recovers: bool,
}

impl ModbusIo {
    /// Drives that connect to nothing before they are opened.
    #[must_use]
    pub const fn new(settings: ModbusIoSettings) -> ModbusIo {
        ModbusIo::over(Network::SOCKETS, settings)
    }

    /// The same over another network, such as one of tests.
    #[must_use]
    pub const fn over(network: Network, settings: ModbusIoSettings) -> ModbusIo {
        ModbusIo { settings, network, link: None, told: Outputs::NONE, is_beyond: false, recovers: false }
    }

    fn heard(&self) -> Result<&Shared, DriveFault> {
        self.link.as_ref().ok_or(CLOSED)?.heard()?.ok_or(CLOSED)
    }

    fn measured_now(&self) -> Result<Measured<NoJoints>, DriveFault> {
        self.heard()?;
        Ok(Measured { position: NoJoints::zeros(), velocity: NoJoints::zeros() })
    }
}

/// A link that tells outputs what they were told before.
fn begin(network: &Network, settings: &ModbusIoSettings, told: &Outputs) -> Result<Link, DriveFault> {
    let link = connect(network, settings)?;
    link.shared().tell(told, &settings.layout);
    Ok(link)
}

impl<R: Robot<Joints = NoJoints>> Driver<R> for ModbusIo {
    fn period(&self) -> Duration {
        self.settings.period
    }

    fn hardware(&self) -> Option<String> {
        Some(format!("Modbus device {} unit {}", self.settings.address, self.settings.unit))
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        // A gateway may have room for one connection.
        self.link = None;
        let link = begin(&self.network, &self.settings, &self.told)?;
        link.wait(&self.network)?;
        self.link = Some(link);
        Ok(())
    }

    fn close(&mut self) {
        self.link = None;
    }

    fn held(&self) -> Option<NoJoints> {
        self.link.as_ref().map(|_| NoJoints::zeros())
    }

    fn measured(&self) -> Result<Measured<NoJoints>, DriveFault> {
        self.measured_now()
    }

    fn tick(&mut self, _: &NoJoints) -> Result<Measured<NoJoints>, DriveFault> {
        if core::mem::take(&mut self.is_beyond) {
            return Err(BEYOND);
        }
        self.measured_now()
    }

    fn channels(&self) -> Channels {
        self.settings.layout.channels()
    }

    fn signals(&self) -> Signals {
        self.heard().map_or(Signals::OFF, Shared::signals)
    }

    fn switch_outputs(&mut self, told: &Outputs) {
        let scale = self.settings.layout.analog_output;
        let beyond = |(channel, value)| match (channel, value) {
            (Channel::Analog(_), Value::Analog(value)) => scale.register(value).is_none(),
            _ => false,
        };
        // The others are switched all the same: a stop may be what switches them.
        self.is_beyond |= told.iter().any(beyond);
        self.told = *told;
        if let Some(link) = &self.link {
            link.shared().tell(told, &self.settings.layout);
        }
    }

    /// Connects again, if the exchange has ended. Outputs are then told what they were told last.
    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        let Self { settings, network, link, told, recovers, .. } = self;
        let is_over = Exchange::recall(link, recovers, || begin(network, settings, told))?;
        Ok(if is_over { Recovery::Over } else { Recovery::GoesOn })
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.heard().map(drop)
    }
}
