//! Drives that are made where they are opened, in their EDP, and nowhere else.
//!
//! In: the name and the servo period of hardware, and how to connect to it. Out: a [`Driver`] that connects to nothing before
//! it is opened.

use core::time::Duration;

use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Channels, Driver, Measured, Recovery, Regulators, SimulatedDrives, Stepped};
use crate::model::load::Load;
use crate::model::pace::{Pace, Pulse};
use crate::model::robot::Robot;
use crate::model::signals::{Outputs, Signals};
use crate::model::wrench::Wrench;

/// Drives that are connected as soon as they exist, such as those of a manufacturer's library. A set-up gets this in their
/// place; `connect` makes them when the robot's EDP opens its driver, and again at a reset, if that has failed. A check, a dry
/// run and all other processes of the cell make none.
///
/// ```
/// # use std::time::Duration;
/// # use mrroc_core::robot::{Connecting, DriveFault, Driver, Measured};
/// # struct Vendor;
/// # impl Vendor {
/// #     fn connect(_: &str) -> Result<Vendor, DriveFault> { Err(DriveFault::NoAnswer) }
/// # }
/// let address = "10.0.0.7:30004";
/// let driver =
///     Connecting::to(&format!("udp {address}"), Duration::from_millis(2), move || Vendor::connect(address));
/// ```
#[derive(Debug)]
pub struct Connecting<D, F> {
    hardware: String,
    period: Duration,
    pace: Pace,
    channels: Channels,
    declared: Option<(Outputs, Outputs)>,
    connect: F,
    drives: Option<D>,
}

impl<D, F: FnMut() -> Result<D, DriveFault>> Connecting<D, F> {
    /// Drives of this [hardware](Driver::hardware), with this servo period.
    pub fn to(hardware: &str, period: Duration, connect: F) -> Self {
        Connecting {
            hardware: hardware.to_owned(),
            period,
            pace: Pace::Cell,
            channels: Channels::NONE,
            declared: None,
            connect,
            drives: None,
        }
    }

    /// The same, with these inputs and outputs.
    #[must_use]
    pub fn with_channels(mut self, channels: Channels) -> Self {
        self.channels = channels;
        self
    }

    /// The same, [paced](Pace) as said here.
    #[must_use]
    pub fn paced(mut self, pace: Pace) -> Self {
        self.pace = pace;
        self
    }

    fn connected(&mut self) -> Result<&mut D, DriveFault> {
        self.drives.as_mut().ok_or(DriveFault::Other("the drives are not connected"))
    }
}

// What drives do not say here would be the default of the trait, and not what they do.
#[deny(clippy::missing_trait_methods)]
impl<R: Robot, D: Driver<R>, F: FnMut() -> Result<D, DriveFault>> Driver<R> for Connecting<D, F> {
    fn period(&self) -> Duration {
        self.period
    }

    fn pace(&self) -> Pace {
        self.pace
    }

    fn pulse(&mut self, now: Duration) -> Result<Option<Pulse>, DriveFault> {
        self.connected()?.pulse(now)
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        // Hardware that one connection at a time may have is let go before.
        self.drives = None;
        let mut drives = (self.connect)()?;
        if let Some((named, when_lost)) = &self.declared {
            drives.declare_outputs(named, when_lost);
        }
        drives.open()?;
        if (drives.period(), drives.pace(), drives.channels()) != (self.period, self.pace, self.channels) {
            drives.close();
            return Err(DriveFault::Other(
                "the drives have another servo period, pace or channels than their set-up says",
            ));
        }
        self.drives = Some(drives);
        Ok(())
    }

    fn close(&mut self) {
        if let Some(mut drives) = self.drives.take() {
            drives.close();
        }
    }

    fn held(&self) -> Option<R::Joints> {
        self.drives.as_ref()?.held()
    }

    fn measured(&self) -> Result<Measured<R::Joints>, DriveFault> {
        let drives = self.drives.as_ref();
        drives.ok_or(DriveFault::Other("the drives are not connected"))?.measured()
    }

    fn tick(&mut self, demanded: &R::Joints) -> Result<Measured<R::Joints>, DriveFault> {
        self.connected()?.tick(demanded)
    }

    fn motor_currents(&self) -> Option<R::Joints> {
        self.drives.as_ref()?.motor_currents()
    }

    fn wrench(&self) -> Option<Wrench> {
        self.drives.as_ref()?.wrench()
    }

    fn speed_scaling(&self) -> f64 {
        self.drives.as_ref().map_or(1.0, Driver::speed_scaling)
    }

    fn channels(&self) -> Channels {
        self.channels
    }

    fn signals(&self) -> Signals {
        self.drives.as_ref().map_or(Signals::OFF, Driver::signals)
    }

    fn switch_outputs(&mut self, outputs: &Outputs) {
        self.drives.iter_mut().for_each(|drives| drives.switch_outputs(outputs));
    }

    fn declare_outputs(&mut self, named: &Outputs, when_lost: &Outputs) {
        self.declared = Some((*named, *when_lost));
    }

    fn carry(&mut self, load: &Load) {
        self.drives.iter_mut().for_each(|drives| drives.carry(load));
    }

    fn load_time(&self) -> Duration {
        self.drives.as_ref().map_or(Duration::ZERO, Driver::load_time)
    }

    fn hardware(&self) -> Option<String> {
        Some(self.hardware.clone())
    }

    fn has_brakes(&self) -> bool {
        self.drives.as_ref().is_some_and(Driver::has_brakes)
    }

    fn switch_off(&mut self) {
        self.drives.iter_mut().for_each(Driver::switch_off);
    }

    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        self.connected()?.recover()
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.connected()?.switch_on()
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.drives.as_ref().is_some_and(|drives| drives.has_regulator(joint, set))
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.drives.iter_mut().for_each(|drives| drives.choose_regulators(sets));
    }

    /// It is asked for before they are opened: they are made for it, and let go.
    fn calibration(&mut self) -> Result<Option<String>, DriveFault> {
        match &mut self.drives {
            Some(drives) => drives.calibration(),
            None => (self.connect)()?.calibration(),
        }
    }

    // What has to be connected is hardware: no simulation of ours, and no simulator of others, which is told each period by its number.
    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R::Joints>> {
        None
    }

    fn stepped(&mut self) -> Option<&mut dyn Stepped<R::Joints>> {
        None
    }

    fn python(&self) -> Option<String> {
        None
    }
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;
    use std::rc::Rc;

    use super::*;
    use crate::tests::slide::{Exact, One, Slide};

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn drives_are_made_when_they_are_opened_and_again_after_a_refusal_and_let_go_when_closed() {
        let made = Rc::new(Cell::new(0));
        let count = Rc::clone(&made);
        let mut driver = Connecting::to("a controller", MS, move || {
            count.set(count.get() + 1);
            if count.get() == 1 { Err(DriveFault::NoAnswer) } else { Ok(Exact::new(MS)) }
        });
        let driver: &mut dyn Driver<Slide> = &mut driver;
        let is_closed = |driver: &mut dyn Driver<Slide>| {
            let told = "the drives are not connected";
            driver.measured().is_err_and(|fault| fault.what() == told)
                && driver.tick(&One::zeros()).is_err_and(|fault| fault.what() == told)
        };
        assert_eq!((driver.hardware().as_deref(), driver.period()), (Some("a controller"), MS));
        assert!(is_closed(driver) && made.get() == 0);
        assert_eq!(driver.open(), Err(DriveFault::NoAnswer));
        assert!(is_closed(driver));
        driver.open().expect("the second time");
        assert_eq!(driver.tick(&One::new(0.5)).map(|measured| measured.position[0]), Ok(0.5));
        assert_eq!(driver.measured().map(|measured| measured.position[0]), Ok(0.5));
        driver.close();
        assert!(is_closed(driver) && made.get() == 2);
    }

    /// Drives that know their calibration.
    struct Calibrated(Exact, Rc<Cell<u32>>);

    impl Drop for Calibrated {
        fn drop(&mut self) {
            self.1.set(self.1.get() + 1);
        }
    }

    impl Driver<Slide> for Calibrated {
        fn period(&self) -> Duration {
            MS
        }
        fn measured(&self) -> Result<Measured<One>, DriveFault> {
            self.0.measured()
        }
        fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
            self.0.tick(demanded)
        }
        fn calibration(&mut self) -> Result<Option<String>, DriveFault> {
            Ok(Some("of this robot".to_owned()))
        }
    }

    #[test]
    fn a_calibration_is_read_before_drives_are_opened_and_their_connection_let_go() {
        let dropped = Rc::new(Cell::new(0));
        let count = Rc::clone(&dropped);
        let mut driver =
            Connecting::to("a controller", MS, move || Ok(Calibrated(Exact::new(MS), Rc::clone(&count))));
        let driver: &mut dyn Driver<Slide> = &mut driver;
        assert_eq!(driver.calibration(), Ok(Some("of this robot".to_owned())));
        assert_eq!(dropped.get(), 1);
        driver.open().expect("connected");
        assert_eq!((driver.calibration(), dropped.get()), (Ok(Some("of this robot".to_owned())), 1));
        let mut refused = Connecting::to("a controller", MS, || Err::<Exact, _>(DriveFault::NoAnswer));
        assert_eq!(Driver::<Slide>::calibration(&mut refused), Err(DriveFault::NoAnswer));
    }

    #[test]
    fn drives_with_another_servo_period_than_the_set_up_says_are_refused() {
        let mut driver = Connecting::to("a controller", 2 * MS, || Ok(Exact::new(MS)));
        let refused = Driver::<Slide>::open(&mut driver).expect_err("1 ms");
        assert_eq!(
            refused.what(),
            "the drives have another servo period, pace or channels than their set-up says"
        );
    }
}
