//! How the positions that the robot is told go on from where it is, and come to those that are demanded.
//!
//! In: the position, velocity and acceleration that the robot's regulators follow now, and the position demanded for the end
//! of the period. Out: the position to tell it. Where the robot is on its path and the path bends gently, that is the demanded
//! position, exactly. It is another one while the robot comes back after answers were lost, after a demand that jumps,
//! and where the path's acceleration jumps. The jerk is
//!
//! ```text
//! j = bounded(j_p, ±PATH_JERK) - w³ (q - p) - 3 w² (dq - dp) - 3 w (ddq - ddp)
//! ```
//!
//! with the path p and its jerk `j_p` from the differences of the demands, as the robot takes them from what it is told:
//! `ddq_k = ddq_(k-1) + j T`, `dq_k = dq_(k-1) + ddq_k T`, `q_k = q_(k-1) + dq_k T`. All three roots of the return are at `-w`,
//! so it does not swing. w is the largest one, up to [`FASTEST`], that keeps [`JERK`] and [`BACK_ACCELERATION`]; it is one for
//! all joints, so the robot comes back along one line.
//!
//! An answer that comes late is one that the robot may have taken or not, and the next one goes on from either. Both differ by
//! `j T³` in position, `j T²` in velocity and `j T` in acceleration. Told from the wrong one, the jerk is `4 j` at most, and the
//! acceleration `2 j T` more. So all jerks are a quarter of what an FR3 takes, and accelerations as much less.

use nalgebra::SVector;

use crate::message::JOINTS;

/// Joint positions \[rad\].
pub type Joints = SVector<f64, JOINTS>;

/// A period of the robot \[s\].
pub const PERIOD: f64 = 1e-3;

/// Largest jerk [rad/s³]: a quarter of the 5000 rad/s³ that an FR3 takes, less the last bits of the positions that it tells.
pub const JERK: f64 = 1240.0;

/// Largest jerk that the path's own is followed with [rad/s³]. A path that asks for more is rounded: by 20 µrad where its
/// acceleration jumps by 3 rad/s².
pub const PATH_JERK: f64 = 500.0;

/// Largest acceleration in all [rad/s²]: of the 10 rad/s² that an FR3 takes, less `2 JERK T`.
pub const ACCELERATION: f64 = 7.5;

/// Largest acceleration of the return [rad/s²].
pub const BACK_ACCELERATION: f64 = 3.5;

/// How fast the return is at most [1/s].
pub const FASTEST: f64 = 150.0;

/// A path whose jerk is larger jumps [rad/s³]: 20 µrad in a period. An acceleration that goes from one end of its limits to the
/// other makes half of it.
const JUMP: f64 = 20_000.0;

/// So many jumps in a row are no jumps but another velocity.
const JUMPS: u8 = 4;

/// Periods without a demand after which nothing is known of the path.
const FORGOTTEN: u64 = 32;

/// A position and its first two differences: rad, rad/s, rad/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint {
    pub q: Joints,
    pub dq: Joints,
    pub ddq: Joints,
}

/// The most periods for which the robot goes on by itself, and some more.
const MOST_LOST: u64 = 32;

impl Setpoint {
    /// At rest.
    pub fn at_rest(q: Joints) -> Setpoint {
        Setpoint { q, dq: Joints::zeros(), ddq: Joints::zeros() }
    }

    /// A period later, by this jerk [rad/s³].
    pub fn after(&self, jerk: &Joints) -> Setpoint {
        let ddq = self.ddq + jerk * PERIOD;
        let dq = self.dq + ddq * PERIOD;
        Setpoint { q: self.q + dq * PERIOD, dq, ddq }
    }

    /// So many periods later, by no jerk: what the robot makes of answers that it does not get. After [`MOST_LOST`] it has stopped.
    pub fn extrapolated(&self, periods: u64) -> Setpoint {
        (0..periods.min(MOST_LOST)).fold(*self, |setpoint, _| setpoint.after(&Joints::zeros()))
    }

    /// Brings it to rest a little: the next setpoint, within `jerk` [rad/s³].
    pub fn braked(&self, jerk: f64, acceleration: f64) -> Setpoint {
        let speed = self.dq.amax();
        let w = FASTEST
            .min((0.5 * jerk / speed.max(1e-12)).sqrt())
            .min(0.25 * jerk / self.ddq.amax().max(1e-12))
            .min(2.0 * acceleration / speed.max(1e-12));
        let jerk = self.dq * -(w * w) - self.ddq * (2.0 * w);
        let next = self.after(&jerk);
        // What is left would end by itself.
        if speed < 1e-7 && self.ddq.amax() < 1e-5 { Setpoint::at_rest(self.q) } else { next }
    }
}

/// The path that is demanded, and how fast the robot comes back to it.
#[derive(Clone, Debug)]
pub struct Rejoining {
    path: Option<Path>,
}

/// The path at the last demand.
#[derive(Clone, Copy, Debug)]
struct Path {
    setpoint: Setpoint,
    /// The period for whose end that was.
    count: u64,
    /// How often in a row each joint has jumped.
    jumps: [u8; JOINTS],
}

impl Rejoining {
    /// Without a path.
    pub const fn new() -> Rejoining {
        Rejoining { path: None }
    }

    /// The robot is held: the next demand begins a path.
    pub fn forget(&mut self) {
        *self = Rejoining::new();
    }

    /// What to tell the robot, which follows `robot` at the beginning of the period `count`, when `demanded` is for its end;
    /// and how far it is from its path then [rad].
    pub fn next(&mut self, count: u64, robot: &Setpoint, demanded: &Joints) -> (Setpoint, f64) {
        let (path, jerk) = self.path_to(count, demanded);
        // A period before its end.
        let before = Setpoint {
            q: path.q - path.dq * PERIOD,
            dq: path.dq - path.ddq * PERIOD,
            ddq: path.ddq - jerk * PERIOD,
        };
        let off = [robot.q - before.q, robot.dq - before.dq, robot.ddq - before.ddq];
        let jerk = jerk.map(|jerk| jerk.clamp(-PATH_JERK, PATH_JERK));
        let w = fastest(off.map(|off| off.amax()), JERK - jerk.amax());
        let jerk = jerk - off[0] * (w * w * w) - off[1] * (3.0 * w * w) - off[2] * (3.0 * w);
        // Where both add up to more acceleration than there is, the return takes longer.
        let most = robot.ddq.map(|ddq| (ACCELERATION - ddq) / PERIOD);
        let least = robot.ddq.map(|ddq| (-ACCELERATION - ddq) / PERIOD);
        let next = robot.after(&jerk.inf(&most).sup(&least));
        let away = (next.q - path.q).amax();
        (next, away)
    }

    /// The path at the end of the period `count`, and its jerk since the last demand.
    fn path_to(&mut self, count: u64, demanded: &Joints) -> (Setpoint, Joints) {
        let known = self.path.filter(|path| (path.count + 1..=path.count + FORGOTTEN).contains(&count));
        let (path, jerk) = match known {
            None => {
                (Path { setpoint: Setpoint::at_rest(*demanded), count, jumps: [0; JOINTS] }, Joints::zeros())
            }
            Some(path) => path.after(count, demanded),
        };
        self.path = Some(path);
        (path.setpoint, jerk)
    }
}

/// The largest w at which the return from a distance [rad], a velocity [rad/s] and an acceleration [rad/s²] keeps this jerk
/// [rad/s³] and [`BACK_ACCELERATION`]. From rest a distance d asks for an acceleration of `0.231 w² d`, and a velocity v for
/// `0.80 w v`; each has half of it.
fn fastest([q, dq, ddq]: [f64; 3], jerk: f64) -> f64 {
    let keeps = |w: f64| {
        w * (w * (w * q + 3.0 * dq) + 3.0 * ddq) <= jerk
            && 0.462 * w * w * q <= BACK_ACCELERATION
            && 1.6 * w * dq <= BACK_ACCELERATION
    };
    if keeps(FASTEST) {
        return FASTEST;
    }
    // To a millionth of it, by halves.
    let (mut kept, mut broken) = (0.0, FASTEST);
    for _ in 0..20 {
        let middle = 0.5 * (kept + broken);
        if keeps(middle) {
            kept = middle;
        } else {
            broken = middle;
        }
    }
    kept
}

impl Path {
    /// At the next demand, and the jerk with which it came there.
    ///
    /// A joint that jumps keeps its velocity and acceleration: its demand is late, or early, or the path begins anew. If it goes on
    /// jumping, its velocity is that between the last two demands.
    fn after(&self, count: u64, demanded: &Joints) -> (Path, Joints) {
        let Setpoint { q, dq, ddq } = self.setpoint;
        let n = (count - self.count) as f64;
        let (first, second) = (n * PERIOD, 0.5 * n * (n + 1.0) * PERIOD * PERIOD);
        let third = n * (n + 1.0) * (n + 2.0) / 6.0 * PERIOD * PERIOD * PERIOD;
        let mut jerk = (demanded - q - dq * first - ddq * second) / third;
        let mut setpoint = Setpoint { q: *demanded, dq, ddq };
        let mut jumps = self.jumps;
        for i in 0..JOINTS {
            let jumped = jerk[i].abs() > JUMP;
            jumps[i] = if jumped { jumps[i] + 1 } else { 0 };
            if jumped {
                jerk[i] = 0.0;
            }
            if jumps[i] == JUMPS {
                (setpoint.dq[i], setpoint.ddq[i], jumps[i]) = ((demanded[i] - q[i]) / first, 0.0, 0);
                continue;
            }
            setpoint.dq[i] += ddq[i] * first + jerk[i] * second;
            setpoint.ddq[i] += jerk[i] * first;
        }
        (Path { setpoint, count, jumps }, jerk)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits;

    /// Joints that all do the same.
    fn all(value: f64) -> Joints {
        Joints::repeat(value)
    }

    /// To and fro about 0, from rest on: amplitude \[rad\], greatest acceleration [rad/s²].
    fn swing(amplitude: f64, acceleration: f64, count: u64) -> Joints {
        let w = (acceleration / amplitude).sqrt();
        all(amplitude * (1.0 - (w * count as f64 * PERIOD).cos()))
    }

    /// The jerk that the robot sees [rad/s³].
    fn jerk(now: &Setpoint, next: &Setpoint) -> f64 {
        ((next.ddq - now.ddq) / PERIOD).amax()
    }

    /// Within the limits of this module.
    fn check(now: &Setpoint, next: &Setpoint) {
        assert!(jerk(now, next) <= JERK + 1e-6, "{} rad/s³", jerk(now, next));
        assert!(next.ddq.amax() <= ACCELERATION + 1e-9, "{} rad/s²", next.ddq.amax());
    }

    #[test]
    fn on_a_gentle_path_the_robot_is_told_the_demands_themselves() {
        let mut rejoining = Rejoining::new();
        let mut robot = Setpoint::at_rest(all(0.0));
        // 0.2 rad, 1.5 rad/s² and, once it moves, at most 4.1 rad/s³. It begins with a jump of the acceleration.
        for count in 0..5000 {
            let demanded = swing(0.2, 1.5, count);
            let (next, away) = rejoining.next(count, &robot, &demanded);
            check(&robot, &next);
            robot = next;
            assert!(away < 2e-5, "{count}: {away} rad");
            assert!(count < 500 || away < 1e-12, "{count}: {away} rad");
        }
    }

    #[test]
    fn the_return_from_a_distance_is_that_of_three_equal_roots() {
        let (distance, mut rejoining) = (1e-4, Rejoining::new());
        let mut robot = Setpoint::at_rest(all(distance));
        for count in 0..60 {
            let (next, away) = rejoining.next(count, &robot, &all(0.0));
            check(&robot, &next);
            robot = next;
            let t = FASTEST * PERIOD * (count + 1) as f64;
            let expected = distance * (1.0 + t + 0.5 * t * t) * (-t).exp();
            // The period is a seventh of the roots' time: the steps are coarse.
            assert!((away - expected).abs() < 0.05 * distance, "{count}: {away}, {expected}");
        }
        assert!(robot.q[0] >= 0.0 && robot.q[0] < 0.02 * distance, "{}", robot.q[0]);
    }

    #[test]
    fn from_any_state_the_robot_comes_back_to_rest_within_its_limits() {
        for (q, dq, ddq) in
            [(0.05, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 7.0), (0.01, 0.3, 7.0), (-0.01, 0.3, 5.0)]
        {
            let mut rejoining = Rejoining::new();
            let mut robot = Setpoint { q: all(q), dq: all(dq), ddq: all(ddq) };
            for count in 0..3000 {
                let (next, _) = rejoining.next(count, &robot, &all(0.0));
                check(&robot, &next);
                robot = next;
            }
            assert!(robot.q.amax() < 1e-9, "from {q}, {dq}, {ddq}: {} rad left", robot.q.amax());
        }
    }

    #[test]
    fn fault_95_after_up_to_19_lost_answers_the_robot_comes_back_onto_its_path_within_its_limits() {
        // 0.3 rad, 3 rad/s²: at most 0.95 rad/s and 9.5 rad/s³.
        let path = |count| swing(0.3, 3.0, count);
        let w = (3.0_f64 / 0.3).sqrt();
        let steepest = 3.0 * w;
        for lost in 1..20_u64 {
            let mut rejoining = Rejoining::new();
            let mut robot = Setpoint::at_rest(all(0.0));
            let (mut count, mut farthest) = (0, 0.0_f64);
            while count < 3000 {
                // The robot goes on by itself from 700 on. It gets answers, but not in time.
                let is_lost = (700..700 + lost).contains(&count);
                let (next, away) = rejoining.next(count, &robot, &path(count));
                robot = if is_lost {
                    robot.extrapolated(1)
                } else {
                    check(&robot, &next);
                    next
                };
                farthest = if count > 500 { farthest.max(away) } else { 0.0 };
                count += 1;
            }
            // Constant acceleration for n periods leaves the path's acceleration by n j T, its velocity by n (n + 1) j T² / 2 and
            // the path by n (n + 1) (n + 2) j T³ / 6. From the first two the return goes farther, by 0.27 / w² and 0.84 / w of
            // them. The steps are coarse.
            let n = lost as f64;
            let (ddq, dq) = (n * steepest * PERIOD, 0.5 * n * (n + 1.0) * steepest * PERIOD * PERIOD);
            let q = n * (n + 1.0) * (n + 2.0) / 6.0 * steepest * PERIOD * PERIOD * PERIOD;
            let farther = 0.27 * ddq / (FASTEST * FASTEST) + 0.84 * dq / FASTEST;
            assert!(
                farthest <= 1.2 * (q + farther),
                "{lost} lost: {farthest} rad off, {} expected",
                q + farther
            );
            assert!(lost < 19 || farthest < 3e-5, "{farthest} rad off");
            assert!((robot.q - path(count - 1)).amax() < 1e-9, "{lost} lost: not back");
        }
    }

    #[test]
    fn fault_95_a_late_answer_that_the_robot_has_taken_after_all_asks_for_no_more_than_it_takes() {
        let mut rejoining = Rejoining::new();
        let mut robot = Setpoint::at_rest(all(0.0));
        // A jump of the path: the robot is on its return, with the largest jerk.
        let path = |count: u64| swing(0.3, 3.0, count) + all(if count > 700 { 0.004 } else { 0.0 });
        for count in 0..900 {
            let (next, _) = rejoining.next(count, &robot, &path(count));
            // As if that answer had been lost: the next one is told from where the robot would be then.
            let (after, _) = rejoining.clone().next(count + 1, &robot.extrapolated(1), &path(count + 1));
            // The robot takes its differences from what it was told.
            let dq = (after.q - next.q) / PERIOD;
            let seen = Setpoint { q: after.q, dq, ddq: (dq - next.dq) / PERIOD };
            assert!(jerk(&next, &seen) <= 4.0 * JERK + 1e-3, "{count}: {} rad/s³", jerk(&next, &seen));
            let most = ACCELERATION + 2.0 * JERK * PERIOD;
            assert!(seen.ddq.amax() <= most + 1e-6, "{count}: {} rad/s²", seen.ddq.amax());
            robot = next;
        }
        const { assert!(4.0 * JERK < limits::JERK) };
        const { assert!(ACCELERATION + 2.0 * JERK * PERIOD < limits::ACCELERATION) };
    }

    #[test]
    fn what_is_braked_comes_to_rest_within_its_limits() {
        for (dq, ddq) in [(0.5, 0.0), (-2.0, 5.0), (1.0, 7.0), (0.0, -7.0)] {
            let mut robot = Setpoint { q: all(0.0), dq: all(dq), ddq: all(ddq) };
            let mut periods = 0;
            while robot.dq != all(0.0) || robot.ddq != all(0.0) {
                let next = robot.braked(JERK, ACCELERATION);
                check(&robot, &next);
                (robot, periods) = (next, periods + 1);
                assert!(periods < 5000, "{dq} rad/s, {ddq} rad/s²: it does not come to rest");
            }
        }
    }
}
