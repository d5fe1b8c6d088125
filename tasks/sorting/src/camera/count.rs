//! Whether what a belt's encoder counts can be true: a belt has mass, so its speed does not jump.
//!
//! ```text
//! |speed - speed of the reading before| <= JUMP          a conveyor changes by 0.0002 m/s in a step of 4 ms
//! travel != travel of the readings of the last STANDING    or   |speed| <= JUMP
//! ```
//!
//! An encoder whose count stands while the belt runs fails one of them, whether its speed is taken from the count or not. A count that has
//! stood since the program began passes: nothing is taken then, because no part comes.

use mrroc::fault::Fault;

/// What an encoder said last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Count {
    last: Option<(f64, f64)>,
    /// For how long its readings have been the same \[s\].
    stood: f64,
}

impl Count {
    /// The most by which speed may differ from one reading to the next [m/s]. Parts on a belt that is slower than this lie under closing fingers
    /// less than 10 mm off.
    pub const JUMP: f64 = 0.01;

    /// A reading that is late is the one before once more, but not for so long \[s\].
    pub const STANDING: f64 = 0.02;

    /// Takes the next reading, `dt` \[s\] after the one before: how far the belt has run \[m\], and how fast it runs [m/s].
    ///
    /// # Errors
    /// No belt runs so.
    pub fn take(&mut self, travel: f64, speed: f64, dt: f64) -> Result<(), Fault> {
        let Some((travel_before, before)) = self.last.replace((travel, speed)) else {
            return Ok(());
        };
        let stands = travel == travel_before && speed.abs() > Self::JUMP;
        self.stood = if stands { self.stood + dt } else { 0.0 };
        if self.stood > Self::STANDING || (speed - before).abs() > Self::JUMP {
            return Err(Fault::thrown(&format!(
                "the count of the belt's encoder jumps or stands, {before:.3} m/s then {speed:.3} m/s: see that it turns with the belt"
            )));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A conveyor's acceleration over steps of 4 ms, up to a speed and down again.
    fn belt() -> impl Iterator<Item = (f64, f64)> {
        let (step, acceleration, mut travel, mut speed) = (4e-3, 0.05, 0.0, 0.0);
        (0..1200).map(move |i| {
            speed += if i < 600 { acceleration } else { -acceleration } * step;
            travel += speed * step;
            (travel, speed)
        })
    }

    #[test]
    fn a_belt_that_speeds_up_and_stops_is_believed() {
        let mut count = Count::default();
        assert!(belt().all(|(travel, speed)| count.take(travel, speed, 4e-3).is_ok()));
    }

    #[test]
    fn a_count_that_stands_is_not_believed_whether_its_speed_falls_or_stays() {
        for speed_stays in [false, true] {
            let mut count = Count::default();
            let all: Vec<_> = belt().take(500).collect();
            all.iter().for_each(|(travel, speed)| count.take(*travel, *speed, 4e-3).expect("it runs"));
            let (travel, speed) = all[499];
            // The reading is late by five steps: it is the same for a good reason.
            (0..5).for_each(|_| count.take(travel, speed, 4e-3).expect("the reading is late"));
            let fault =
                count.take(travel, if speed_stays { speed } else { 0.0 }, 4e-3).expect_err("it stands");
            assert!(fault.to_string().contains("see that it turns with the belt"), "{fault}");
        }
    }
}
