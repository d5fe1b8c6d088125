//! The crawl: when each leg swings, and where the trunk is then.
//!
//! ```text
//!        | rh swings | rest | rf swings |  long rest  | lh swings | rest | lf swings |  long rest  |
//! y of T |     left                      \                   right                    \
//! ```
//!
//! One leg swings at a time, from behind to the front on one side, then on the other. The trunk goes ahead at one speed, and sways to the
//! side whose legs both stand: so its centre of mass is within the triangle of the three that stand.

/// A crawl of so many footsteps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gait {
    /// Of the trunk [m/s].
    pub speed: f64,
    /// How long a leg swings \[s\].
    pub swing: f64,
    /// How long all legs stand after the first and after the second leg of a side \[s\].
    pub rests: [f64; 2],
    /// How far the trunk sways to either side \[m\].
    pub sway: f64,
    /// How long it takes to sway from one side to the other \[s\] ..
    pub swaying: f64,
    /// .. and how long before the end of a swing that begins \[s\].
    pub lead: f64,
    /// The trunk's origin over the middle of its feet \[m\].
    pub height: f64,
    /// How far a foot is lifted over the highest ground on its path \[m\].
    pub clearance: f64,
    /// How long it takes to come to the speed, and to a halt \[s\].
    pub ramp: f64,
    /// How many footsteps it has, a multiple of 2.
    pub footsteps: usize,
}

impl Default for Gait {
    fn default() -> Self {
        Self {
            speed: 0.1,
            swing: 0.6,
            rests: [0.12, 0.46],
            sway: 0.06,
            swaying: 0.9,
            lead: 0.2,
            height: 0.4,
            clearance: 0.04,
            ramp: 1.0,
            footsteps: 28,
        }
    }
}

/// A part of a crawl.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The trunk comes to its speed over all four feet.
    SetOff,
    /// A footstep, counted from 0: a leg swings, and all stand for a while.
    Footstep(usize),
    /// The trunk comes to rest over all four feet.
    Halt,
}

/// From 0 to 1 with no velocity and acceleration at its ends: `10 u³ - 15 u⁴ + 6 u⁵`.
#[must_use]
pub fn soft(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

impl Gait {
    /// The legs in the order in which they swing.
    pub const ORDER: [usize; 4] = [3, 1, 2, 0];

    /// The leg of a footstep, counted from 0.
    #[must_use]
    pub const fn leg(footstep: usize) -> usize {
        Self::ORDER[footstep % 4]
    }

    /// When a footstep begins \[s\].
    #[must_use]
    pub fn begins(&self, footstep: usize) -> f64 {
        let pairs = (footstep / 2) as f64;
        let odd = (footstep % 2) as f64;
        pairs * (2.0 * self.swing + self.rests[0] + self.rests[1]) + odd * (self.swing + self.rests[0])
    }

    /// How long a footstep takes, the rest after it counted with it \[s\].
    #[must_use]
    pub const fn lasts(&self, footstep: usize) -> f64 {
        self.swing + self.rests[footstep % 2]
    }

    /// How long a whole cycle of four footsteps takes \[s\].
    #[must_use]
    pub fn cycle(&self) -> f64 {
        self.begins(4)
    }

    /// The share of its time in which a leg stands.
    #[must_use]
    pub fn duty(&self) -> f64 {
        1.0 - self.swing / self.cycle()
    }

    /// How far ahead of its hip a foot lands \[m\]: as far as it is behind when it is lifted.
    #[must_use]
    pub fn ahead(&self) -> f64 {
        0.5 * self.speed * (self.cycle() - self.swing)
    }

    /// How far ahead of its hip a foot is at the start \[m\].
    #[must_use]
    pub fn ahead_at_start(&self, leg: usize) -> f64 {
        let place = Self::ORDER.iter().position(|other| *other == leg).unwrap_or(0);
        self.speed * (self.begins(place) + 0.5 * self.ramp) - self.ahead()
    }

    /// When a part of it begins, and how long it lasts \[s\].
    #[must_use]
    pub fn when(&self, part: Part) -> (f64, f64) {
        match part {
            Part::SetOff => (-self.ramp, self.ramp),
            Part::Footstep(number) => (self.begins(number), self.lasts(number)),
            Part::Halt => (self.begins(self.footsteps), self.ramp),
        }
    }

    /// Its parts, in order.
    pub fn parts(&self) -> impl Iterator<Item = Part> + use<> {
        let footsteps = (0..self.footsteps).map(Part::Footstep);
        core::iter::once(Part::SetOff).chain(footsteps).chain(core::iter::once(Part::Halt))
    }

    /// When it is over \[s\].
    #[must_use]
    pub fn ends(&self) -> f64 {
        self.begins(self.footsteps) + self.ramp
    }

    /// How far the trunk is ahead of its start at a time, < 0 while it sets off \[m, s\].
    #[must_use]
    pub fn advance(&self, time: f64) -> f64 {
        // The velocity rises by 3 u² - 2 u³ of the ramp.
        let risen = |t: f64| {
            let u = (t / self.ramp).clamp(0.0, 1.0);
            self.ramp * u * u * u * (1.0 - 0.5 * u) + (t - self.ramp).max(0.0)
        };
        self.speed * (risen(time + self.ramp) - risen(time - self.begins(self.footsteps)))
    }

    /// How far the trunk is to the left of its path at a time \[m, s\].
    #[must_use]
    pub fn aside(&self, time: f64) -> f64 {
        let pairs = self.footsteps / 2;
        let mut y = self.sway;
        for pair in 1..=pairs {
            let from = self.begins(2 * pair) - self.rests[1] - self.lead;
            let side = if pair % 2 == 1 { -1.0 } else { 1.0 };
            // At last to the middle.
            let far = if pair == pairs { self.sway } else { 2.0 * self.sway };
            y += side * far * soft((time - from) / self.swaying);
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leg_stands_more_than_three_quarters_of_its_time_and_one_swings_at_a_time() {
        let gait = Gait::default();
        assert!(gait.duty() >= 0.75, "{}", gait.duty());
        assert!((gait.cycle() - 3.56).abs() < 1e-12);
        for k in 0..8 {
            assert!((gait.begins(k) + gait.lasts(k) - gait.begins(k + 1)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_trunk_has_its_speed_between_the_ramps_and_no_corner_on_its_path() {
        let gait = Gait { footsteps: 8, ..Gait::default() };
        let h = 1e-4;
        let speed = |t: f64| (gait.advance(t + h) - gait.advance(t - h)) / (2.0 * h);
        assert!(
            (speed(3.0) - 0.1).abs() < 1e-9 && speed(-1.1) == 0.0 && speed(gait.ends() + 1.0).abs() < 1e-9
        );
        // Two cycles at 0.1 m/s, and half of that speed in the ramps.
        assert!((gait.advance(gait.ends()) - 0.812).abs() < 1e-12);
        for i in 0..(gait.ends() / h) as i32 {
            let t = f64::from(i) * h;
            let accelerated = (gait.aside(t + h) - 2.0 * gait.aside(t) + gait.aside(t - h)) / (h * h);
            // 10 / sqrt(3) d / T² of the sway.
            assert!(accelerated.abs() < 5.78 * 2.0 * gait.sway / (gait.swaying * gait.swaying), "{t}");
        }
        assert!(gait.aside(gait.ends()).abs() < 1e-9);
    }
}
