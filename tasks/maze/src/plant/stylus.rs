//! A stylus among walls: a ball without mass on a spring.
//!
//! ```text
//! b      the ball, never within a wall        d = p - b, where p is where it would be without walls
//! F      k d on the tool, against it          k = 2 N/mm
//! along a wall the ball follows p as soon as k times what it lags behind exceeds mu times k times the depth (Coulomb)
//! closed the switch, where k |d| exceeds a threshold that depends on the direction: three legs of a kinematic seat (lobing)
//! ```

use nalgebra::Vector2;

use mrroc_map::{Chance, Place, Walls};

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
    chance: Chance,
    /// The ball's way since it was counted from 0, and the largest deflection \[m\].
    pub way: f64,
    /// See `way`.
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
            chance: Chance::seeded(seed),
            way: 0.0,
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

    /// Between the walls, with its seat at `p` [m, M]; at the time `t` \[s\]. What the switch says.
    pub fn move_to(&mut self, p: &Place, walls: &Walls, t: f64) -> bool {
        let before = self.ball.unwrap_or(*p);
        // It follows its seat, and is kept out of walls; two of them meet in a corner.
        let mut ball = *p;
        for _ in 0..4 {
            let Some(wall) = walls.near(&ball).find(|wall| wall.distance(&ball) < self.radius - 1e-9) else {
                break;
            };
            let nearest = wall.nearest(&ball);
            let away = ball - nearest;
            ball = if away.norm() > 1e-12 {
                nearest + away.normalize() * self.radius
            } else {
                // The seat is within the wall: out by the side on which the ball was.
                let out = before - wall.nearest(&before);
                let out = if out.norm() > 1e-12 { out.normalize() } else { Vector2::x() };
                let out = if out.x.abs() > out.y.abs() {
                    Vector2::new(out.x.signum(), 0.0)
                } else {
                    Vector2::new(0.0, out.y.signum())
                };
                let side = |out: f64, lower: f64, upper: f64, within: f64| match out {
                    out if out > 0.0 => upper,
                    out if out < 0.0 => lower,
                    _ => within,
                };
                let edge = Place::new(
                    side(out.x, wall.lower.x, wall.upper.x, ball.x),
                    side(out.y, wall.lower.y, wall.upper.y, ball.y),
                );
                edge + out * self.radius
            };
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
        self.way += (ball - before).norm();
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
            self.bouncing = t + BOUNCING[0] + (BOUNCING[1] - BOUNCING[0]) * self.chance.share();
        }
        if t < self.bouncing { self.chance.share() < 0.5 } else { self.pressed }
    }
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
