//! The wrench that a robot measures or estimates by itself, as a sensor.

use core::fmt;

use mrroc::fault::FaultKind;
use mrroc::pose::Wrench;
use mrroc::prelude::*;

use super::{Bias, WristForce, WristOrder};

/// The wrench on a robot's tool that the robot itself tells: a Universal Robots arm of the e-series measures it, a Franka
/// estimates it. The driver gives it to the EDP, [`Driver::wrench`](mrroc::robot::Driver::wrench), and it comes here with each
/// order: this sensor opens no connection.
///
/// The robot subtracts the weight of what it knows that it carries: what is set at its pendant, or what a program told it by a tool of
/// `[tools.NAME]` in `cell.toml` or by `Demand::with_load`. What remains when nothing touches the tool is the bias,
/// [`WristOrder::MeasureBias`].
///
/// Simulated drives tell no wrench. A program that runs with both gives it a simulated sensor,
/// [`or_simulated`](Self::or_simulated).
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_robots::sensors::RobotWrench;
///
/// let wrist = SensorSetup::new("wrist", RobotWrench::new()).of("arm");
/// ```
#[derive(Default)]
pub struct RobotWrench {
    bias: Bias,
    simulated: Option<Box<dyn VirtualSensor<Kind = WristForce>>>,
}

impl RobotWrench {
    /// The wrench that the robot of the sensor tells.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same, which reads this sensor where the robot tells no wrench: one with simulated drives.
    #[must_use]
    pub fn or_simulated(self, sensor: impl VirtualSensor<Kind = WristForce>) -> Self {
        Self { simulated: Some(Box::new(sensor)), ..self }
    }
}

impl fmt::Debug for RobotWrench {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RobotWrench").field("bias", &self.bias).finish_non_exhaustive()
    }
}

impl VirtualSensor for RobotWrench {
    type Kind = WristForce;

    /// # Errors
    /// `Config` when the sensor has no robot, `SensorFailed` when its robot tells no wrench.
    fn aggregate(&mut self, order: &ReadingOrder<WristOrder>) -> Result<Wrench, Fault> {
        let robot = order.robot.ok_or_else(|| {
            let text = "the sensor of a robot's own wrench must know its robot: `SensorSetup::of`";
            Fault::new(FaultKind::Config).text(text)
        })?;
        let Some(told) = robot.wrench else {
            let Some(simulated) = &mut self.simulated else {
                let text = "the robot tells no wrench; for simulated drives: `RobotWrench::or_simulated`";
                return Err(Fault::new(FaultKind::SensorFailed).text(text));
            };
            return simulated.aggregate(order);
        };
        match order.configuration {
            WristOrder::Read => self.bias.read(),
            WristOrder::MeasureBias => self.bias.measure(told),
        }
        Ok(told - self.bias.value)
    }

    fn is_simulated(&self) -> bool {
        self.simulated.as_ref().is_some_and(|sensor| sensor.is_simulated())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::robot::MAX_JOINTS;
    use mrroc::sensor::EffectorState;
    use nalgebra::Vector3;

    fn order(configuration: WristOrder, wrench: Option<Wrench>) -> ReadingOrder<WristOrder> {
        let zeros = [0.0; MAX_JOINTS];
        let robot = EffectorState { joints: zeros, velocity: zeros, pose: Pose::identity(), wrench };
        ReadingOrder { configuration, robot: Some(robot), step: 7 }
    }

    fn wrench(x: f64) -> Wrench {
        Wrench::new(Vector3::new(x, 2.0 * x, 0.0), Vector3::new(0.0, 0.0, 3.0 * x))
    }

    #[test]
    fn the_bias_is_the_mean_of_the_measurements_in_a_row() {
        let mut sensor = RobotWrench::new();
        assert_eq!(sensor.aggregate(&order(WristOrder::Read, Some(wrench(2.0)))), Ok(wrench(2.0)));
        for x in [1.0, 3.0, 5.0] {
            sensor.aggregate(&order(WristOrder::MeasureBias, Some(wrench(x)))).expect("a reading");
        }
        // The mean of 1, 3 and 5 is 3.
        assert_eq!(sensor.aggregate(&order(WristOrder::Read, Some(wrench(8.0)))), Ok(wrench(5.0)));
        // A later measurement begins anew.
        sensor.aggregate(&order(WristOrder::MeasureBias, Some(wrench(1.0)))).expect("a reading");
        assert_eq!(sensor.aggregate(&order(WristOrder::Read, Some(wrench(8.0)))), Ok(wrench(7.0)));
    }

    #[test]
    fn a_robot_that_tells_no_wrench_is_a_fault_unless_a_simulated_sensor_reads_for_it() {
        /// Reads a newton.
        struct Newton;
        impl VirtualSensor for Newton {
            type Kind = WristForce;
            fn aggregate(&mut self, _: &ReadingOrder<WristOrder>) -> Result<Wrench, Fault> {
                Ok(Wrench::new(Vector3::x(), Vector3::zeros()))
            }
            fn is_simulated(&self) -> bool {
                true
            }
        }
        let untold = order(WristOrder::Read, None);
        let fault = RobotWrench::new().aggregate(&untold).expect_err("no wrench");
        assert_eq!(fault.kind(), FaultKind::SensorFailed);
        let mut both = RobotWrench::new().or_simulated(Newton);
        assert!(both.is_simulated() && !RobotWrench::new().is_simulated());
        assert_eq!(both.aggregate(&untold), Ok(Wrench::new(Vector3::x(), Vector3::zeros())));
        assert_eq!(both.aggregate(&order(WristOrder::Read, Some(wrench(2.0)))), Ok(wrench(2.0)));
        let nobody = ReadingOrder { robot: None, ..untold };
        assert_eq!(both.aggregate(&nobody).map_err(|fault| fault.kind()), Err(FaultKind::Config));
    }
}
