//! Switches outputs of a robot that stands, and tells it which tool it has.

use mrroc::prelude::*;
use mrroc::robot::{Level, Output, Tool, Value};

/// Holds the robot for one step, and tells it values for its outputs, its tool, or both. The Move is over when the outputs have
/// been switched; what they make happen, such as a gripper that closes, takes longer: wait for its switch.
///
/// A demand of any other generator can say the same during its motion:
/// [`Demand::with_output`](mrroc::generator::Demand::with_output).
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc::robot::{Channel, Output};
/// use mrroc_generators::generators::Tell;
/// use mrroc_generators::rehearsal::rehearse;
/// use mrroc_robots::Irp6;
///
/// # let output = |number| Output::<bool>::of(Channel::Digital(number)).ok_or_else(|| Fault::thrown("not digital"));
/// // In a program: `let (vacuum, lamp) = (arm.output("vacuum")?, arm.output("lamp")?)`.
/// let (vacuum, lamp) = (output(0)?, output(1)?);
/// let demands = rehearse(Tell::output(vacuum, true).and(lamp, false), &Irp6::nominal(), Irp6::READY, 0.002)?;
/// assert_eq!(demands, vec![Demand::hold().with_output(vacuum, true).with_output(lamp, false)]);
/// # Ok::<(), Fault>(())
/// ```
pub struct Tell<R: Robot> {
    demand: Option<Demand<R>>,
    is_finite: bool,
}

impl<R: Robot> Tell<R> {
    /// This value for this output.
    #[must_use]
    pub fn output<T: Level>(output: Output<T>, value: T) -> Self {
        Tell { demand: Some(Demand::hold()), is_finite: true }.and(output, value)
    }

    /// This tool: its frame is that of all demands from now on, and the drives are told what the robot carries with it.
    #[must_use]
    pub fn tool(tool: Tool) -> Self {
        let demand = Demand::hold().with_tool(tool.frame).with_load(tool.load);
        Tell { demand: Some(demand), is_finite: true }
    }

    /// The same, and this value for this output.
    #[must_use]
    pub fn and<T: Level>(self, output: Output<T>, value: T) -> Self {
        let is_number = !matches!(value.value(), Value::Analog(value) if !value.is_finite());
        let demand = self.demand.map(|demand| demand.with_output(output, value));
        Tell { demand, is_finite: self.is_finite && is_number }
    }
}

#[generator(ecp)]
impl<R: Robot> Tell<R> {
    fn next_step(&mut self) -> Result<Step<R>, Fault> {
        if !self.is_finite {
            return Err(Fault::thrown("the value of an analog output must be finite"));
        }
        match self.demand.take() {
            Some(demand) => Ok(Step::Next(demand)),
            None => Ok(Step::Done),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use mrroc::nalgebra::Vector3;
    use mrroc::robot::{Channel, Load};
    use mrroc_robots::Irp6;

    #[test]
    fn it_tells_a_tool_with_its_load_once() {
        let output = Output::<f64>::of(Channel::Analog(1)).expect("an analog one");
        let pen =
            Tool { frame: Pose::translation(0.0, 0.0, 0.1), load: Load::point(0.3, Vector3::z() * 0.04) };
        let mut tell = Tell::<Irp6>::tool(pen).and(output, 0.5);
        let told = Demand::hold().with_tool(pen.frame).with_load(pen.load).with_output(output, 0.5);
        assert_eq!(tell.next_step(), Ok(Step::Next(told)));
        assert_eq!(tell.next_step(), Ok(Step::Done));
    }
}
