//! A stylus among walls: a ball without mass on a spring.
//!
//! ```text
//! b      the ball, never within a wall        d = p - b, where p is where it would be without walls
//! F      k d on the tool, against it          k = 2 N/mm
//! along a wall the ball follows p as soon as k times what it lags behind exceeds mu times k times the depth (Coulomb)
//! closed the switch, where k |d| exceeds a threshold that depends on the direction: three legs of a kinematic seat (lobing)
//! ```

use mrroc::fault::FaultKind;
use mrroc::prelude::*;
use nalgebra::Vector2;

use mrroc::random::Random;
use mrroc_map::{Place, Wall, Walls};

/// Stiffness of the spring [N/m].
pub const STIFFNESS: f64 = 2000.0;
/// The switch closes at this force in the mean of all directions \[N\] ..
pub const TRIGGER: f64 = 0.25;
/// .. and by this share more or less by direction.
pub const LOBING: f64 = 0.2;
/// Friction between ball and walls.
pub const FRICTION: f64 = 0.2;
/// Deflected by more, the stylus would break \[m\].
pub const TRAVEL: f64 = 4e-3;
/// The switch bounces for so long after each change \[s\], at least and at most.
pub const BOUNCING: [f64; 2] = [0.5e-3, 2e-3];

/// Ball, spring and switch.
#[derive(Clone, Debug)]
pub struct Stylus {
    radius: f64,
    ball: Option<Place>,
    deflection: Vector2<f64>,
    pressed: bool,
    /// Until when the switch bounces \[s\].
    bouncing: f64,
    chance: Random,
    /// Whether the switch is broken: it no longer closes.
    pub stuck: bool,
    /// The distance that the ball has gone since it was counted from 0, and the largest deflection \[m\].
    pub distance: f64,
    /// See `distance`.
    pub most: f64,
}

impl Stylus {
    /// In the air, with a ball of this radius \[m\].
    #[must_use]
    pub const fn new(radius: f64, seed: u64) -> Self {
        Self {
            radius,
            ball: None,
            deflection: Vector2::new(0.0, 0.0),
            pressed: false,
            bouncing: 0.0,
            chance: Random::seeded(seed),
            stuck: false,
            distance: 0.0,
            most: 0.0,
        }
    }

    /// The ball's radius \[m\].
    #[must_use]
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// Over the walls.
    pub fn lift(&mut self) {
        self.ball = None;
        self.deflection = Vector2::zeros();
        self.pressed = false;
    }

    /// Where the ball is, if it is between walls [m, M].
    #[must_use]
    pub const fn ball(&self) -> Option<Place> {
        self.ball
    }

    /// How far the spring is bent \[m\].
    #[must_use]
    pub const fn deflection(&self) -> Vector2<f64> {
        self.deflection
    }

    /// Checks that it is not bent beyond [`TRAVEL`].
    ///
    /// # Errors
    /// `SensorFailed` with this text.
    pub fn check_travel(&self, text: &str) -> Result<(), Fault> {
        let bent = self.deflection().norm();
        if bent > TRAVEL {
            return Err(Fault::new(FaultKind::SensorFailed).exceeds(bent, TRAVEL, "m").text(text));
        }
        Ok(())
    }

    /// Between the walls, with its seat at `p` [m, M]; at the time `t` \[s\]. What the switch says.
    pub fn move_to(&mut self, p: &Place, walls: &Walls, t: f64) -> bool {
        let before = self.ball.unwrap_or(*p);
        // It follows its seat on its own side of walls, and is kept out of them; two of them meet in a corner.
        let mut ball = *p;
        for _ in 0..4 {
            let Some(at) = walls.near(&before).find_map(|wall| beside(wall, &before, &ball)) else { break };
            ball = at;
        }
        for _ in 0..4 {
            let Some(wall) = walls.near(&ball).find(|wall| wall.distance(&ball) < self.radius - 1e-9) else {
                break;
            };
            let nearest = wall.nearest(&ball);
            ball = nearest + (ball - nearest).try_normalize(1e-12).unwrap_or_default() * self.radius;
        }
        let normal = p - ball;
        let depth = normal.norm();
        if depth > 1e-9 {
            // Stuck by friction: it lags behind along the wall by as much as friction holds.
            let along = Vector2::new(-normal.y, normal.x) / depth;
            let lag = (ball - before).dot(&along);
            let held = lag.clamp(-FRICTION * depth, FRICTION * depth);
            let lagging = ball - along * held;
            if walls.clearance(&lagging) >= self.radius - 1e-6 {
                ball = lagging;
            }
        }
        self.distance += (ball - before).norm();
        self.ball = Some(ball);
        self.deflection = p - ball;
        let bent = self.deflection.norm();
        self.most = self.most.max(bent);
        let lobe = (3.0 * self.deflection.y.atan2(self.deflection.x)).cos();
        let closes = TRIGGER * (1.0 + LOBING * lobe);
        // It opens at half of the force at which it closes.
        let force = STIFFNESS * bent;
        let pressed = force > if self.pressed { 0.5 * closes } else { closes };
        if pressed != self.pressed {
            self.pressed = pressed;
            self.bouncing = t + BOUNCING[0] + (BOUNCING[1] - BOUNCING[0]) * self.chance.unit();
        }
        let closed = if t < self.bouncing { self.chance.unit() < 0.5 } else { self.pressed };
        closed && !self.stuck
    }
}

/// The place next to the face of a wall through which the straight line to `to` enters it, where it does: beside `to`, just outside.
fn beside(wall: &Wall, from: &Place, to: &Place) -> Option<Place> {
    let leg = to - from;
    let (mut enter, mut leave, mut axis) = (f64::NEG_INFINITY, f64::INFINITY, 0);
    for i in 0..2 {
        let (lower, upper) = (wall.lower[i] - from[i], wall.upper[i] - from[i]);
        if leg[i].abs() < 1e-15 {
            if lower > 0.0 || upper < 0.0 {
                return None;
            }
            continue;
        }
        let (near, far) = if leg[i] > 0.0 { (lower, upper) } else { (upper, lower) };
        if near / leg[i] > enter {
            (enter, axis) = (near / leg[i], i);
        }
        leave = leave.min(far / leg[i]);
    }
    (enter <= leave && (0.0..=1.0).contains(&enter)).then(|| {
        let mut at = *to;
        let face = if leg[axis] > 0.0 { wall.lower[axis] } else { wall.upper[axis] };
        at[axis] = face - 1e-6 * leg[axis].signum();
        at
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_map::Layout;

    fn room() -> Walls {
        let maze: Layout = "o---o---o\n| S   G |\no---o---o".parse().expect("a maze");
        Walls::of(&maze, 0.025, 0.002)
    }

    #[test]
    fn against_a_wall_it_is_bent_by_how_far_its_seat_is_beyond() {
        let (walls, mut stylus) = (room(), Stylus::new(0.002, 1));
        for i in 0..=100 {
            stylus.move_to(&Place::new(0.0125, 0.0125 - 1.05e-4 * f64::from(i)), &walls, f64::from(i));
        }
        // The ball stops at 1 mm + 2 mm; the seat is at 2 mm.
        assert!((stylus.deflection() - Vector2::new(0.0, -1e-3)).norm() < 1e-12, "{}", stylus.deflection());
        assert!((stylus.most - 1e-3).abs() < 1e-12);
    }

    #[test]
    fn pressed_through_a_wall_it_stays_on_its_side_bent_by_all_of_it() {
        let (walls, mut stylus) = (room(), Stylus::new(0.002, 1));
        for i in 0..=1000 {
            stylus.move_to(&Place::new(0.0125, 0.0125 - 2e-5 * f64::from(i)), &walls, f64::from(i));
        }
        // The seat is at -7.5 mm, beyond the wall of 1 mm to either side; the ball still at 3 mm.
        assert!((stylus.deflection() - Vector2::new(0.0, -0.0105)).norm() < 1e-9, "{}", stylus.deflection());
    }

    #[test]
    fn the_switch_closes_at_another_force_in_each_direction_within_the_lobing() {
        let walls = room();
        for (direction, lobe) in
            [(Vector2::new(0.0, 1.0), 0.0), (Vector2::new(-1.0, 0.0), -1.0), (Vector2::new(1.0, 0.0), 1.0)]
        {
            let from = Place::new(if direction.x > 0.0 { 0.04 } else { 0.0125 }, 0.0125);
            let mut stylus = Stylus::new(0.002, 1);
            let mut closed = None;
            for i in 0..30_000 {
                // Slowly: the switch is quiet at every place.
                if stylus.move_to(&(from + direction * (5e-7 * f64::from(i))), &walls, f64::from(i))
                    && closed.is_none()
                {
                    closed = Some(STIFFNESS * stylus.deflection().norm());
                }
            }
            let closed = closed.expect("it touches");
            assert!((closed - TRIGGER * (1.0 + LOBING * lobe)).abs() < 3e-3, "{direction} {closed}");
        }
    }

    #[test]
    fn along_a_wall_it_lags_behind_by_what_friction_holds_and_no_more() {
        let (walls, mut stylus) = (room(), Stylus::new(0.002, 1));
        for i in 0..=1000 {
            let x = 0.0125 + 2e-5 * f64::from(i);
            stylus.move_to(&Place::new(x, 0.002), &walls, f64::from(i));
        }
        let bent = stylus.deflection();
        assert!((bent.y + 1e-3).abs() < 1e-12 && (bent.x - FRICTION * 1e-3).abs() < 1e-9, "{bent}");
    }
}
