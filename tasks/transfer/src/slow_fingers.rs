//! The drive of a hand: slower than those of the arms, 250 Hz beside 500 Hz.

use core::time::Duration;

use mrroc::robot::{DriveFault, Driver, Measured, Regulators, SimulatedDrives};
use mrroc_robots::grasp::Fingers;
use mrroc_robots::{Gripper, One};

/// [`Fingers`] that take a demand every 4 ms and go there evenly.
#[derive(Debug)]
pub struct SlowFingers {
    fingers: Fingers,
    demanded: Option<One>,
}

impl SlowFingers {
    /// Servo periods of the fingers in one of the hand.
    const PARTS: u32 = 2;

    /// The slow drive of these fingers.
    #[must_use]
    pub fn new(fingers: Fingers) -> Self {
        SlowFingers { demanded: None, fingers }
    }
}

impl Driver<Gripper> for SlowFingers {
    fn period(&self) -> Duration {
        self.fingers.period() * Self::PARTS
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        self.fingers.measured()
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        let mut measured = self.fingers.measured()?;
        let from = self.demanded.replace(*demanded).unwrap_or(measured.position);
        for part in 1..=Self::PARTS {
            let share = f64::from(part) / f64::from(Self::PARTS);
            measured = self.fingers.tick(&(from + (demanded - from) * share))?;
        }
        Ok(measured)
    }

    fn motor_currents(&self) -> Option<One> {
        self.fingers.motor_currents()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<One>> {
        Some(self)
    }

    fn has_brakes(&self) -> bool {
        self.fingers.has_brakes()
    }

    fn switch_off(&mut self) {
        self.fingers.switch_off();
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.demanded = None;
        self.fingers.switch_on()
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.fingers.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.fingers.choose_regulators(sets);
    }
}

impl SimulatedDrives<One> for SlowFingers {
    fn brake(&mut self) -> Measured<One> {
        for _ in 1..Self::PARTS {
            self.fingers.brake();
        }
        self.fingers.brake()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_robots::grasp::{Body, Grasp, World};
    use mrroc_robots::{Rnt, Simulated, Six};

    fn fingers() -> Fingers {
        let world = World::new(&Body::block(2.0, [0.4, 0.06, 0.06])).expect("a bar");
        let arm =
            Simulated::new(Rnt::new(), &Six::from_row_slice(&[-0.344, 0.615, 0.452, 0.277, 1.059, 1.184]));
        let hand = world.arm(arm, Grasp::new(5e4, 500.0)).expect("a good grasp").hand();
        Fingers::new(Simulated::new(Gripper::new(), &One::new(0.075)), hand, 0.06).expect("a hand")
    }

    #[test]
    fn regulators_are_those_of_the_fingers() {
        let (mut slow, mut chosen, mut left) = (SlowFingers::new(fingers()), fingers(), fingers());
        for set in 0..=255 {
            assert_eq!(slow.has_regulator(0, set), chosen.has_regulator(0, set));
        }
        assert!(slow.has_regulator(0, 1) && !slow.has_regulator(1, 0));
        slow.choose_regulators(&Regulators::uniform(1));
        chosen.choose_regulators(&Regulators::uniform(1));
        // The demand of every 4 ms is one half-way and one at the end for the fingers themselves.
        let (mut from, mut apart) = (chosen.measured().expect("simulated").position, 0.0_f64);
        for i in 1..=200 {
            let to = One::new(0.075 - 4e-5 * f64::from(i));
            let reported = slow.tick(&to).expect("follows").position;
            let mut each = [One::zeros(); 2];
            for demand in [from + (to - from) * 0.5, from + (to - from)] {
                each = [&mut chosen, &mut left].map(|drive| drive.tick(&demand).expect("follows").position);
            }
            assert_eq!(reported, each[0]);
            apart = apart.max((each[0] - each[1]).norm());
            from = to;
        }
        assert!(apart > 0.0, "the other set of parameters is to make a difference");
    }
}
