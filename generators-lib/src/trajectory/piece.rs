//! Polynomials of one joint, between two points.

/// A polynomial of degree 5 in time; its coefficients, the constant one first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece(pub [f64; 6]);

/// Halvings of an interval, after which its control points are taken for what lies between them.
const HALVINGS: u32 = 10;

impl Piece {
    /// From `[position, velocity, acceleration]` to another one in a time \[s\], > 0.
    pub fn quintic([p, v, a]: [f64; 3], [q, w, b]: [f64; 3], time: f64) -> Piece {
        let h = time;
        let distance = q - p - h * (v + 0.5 * h * a);
        let speed = w - v - h * a;
        let change = b - a;
        let cubes = h.powi(3);
        Piece([
            p,
            v,
            0.5 * a,
            (10.0 * distance - 4.0 * h * speed + 0.5 * h * h * change) / cubes,
            (-15.0 * distance + 7.0 * h * speed - h * h * change) / (cubes * h),
            (6.0 * distance - 3.0 * h * speed + 0.5 * h * h * change) / (cubes * h * h),
        ])
    }

    /// From position and velocity to others in a time \[s\], > 0, by degree 3.
    pub fn cubic([p, v]: [f64; 2], [q, w]: [f64; 2], time: f64) -> Piece {
        let distance = q - p - time * v;
        let speed = w - v;
        let square = time * time;
        let curved = (3.0 * distance - time * speed) / square;
        Piece([p, v, curved, (time * speed - 2.0 * distance) / (square * time), 0.0, 0.0])
    }

    /// Position, velocity and acceleration at a time \[s\] from its beginning.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let Piece([c0, c1, c2, c3, c4, c5]) = *self;
        [
            c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))),
            c1 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5))),
            2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5)),
        ]
    }

    /// Its derivative.
    pub fn derivative(&self) -> Piece {
        let Piece([_, c1, c2, c3, c4, c5]) = *self;
        Piece([c1, 2.0 * c2, 3.0 * c3, 4.0 * c4, 5.0 * c5, 0.0])
    }

    /// What it has within a time \[s\] from its beginning that is below `lower` or above `upper`, if there is anything.
    pub fn beyond(&self, time: f64, lower: f64, upper: f64) -> Option<f64> {
        beyond(self.control_points(time), lower, upper, HALVINGS)
    }

    /// A bound of its absolute value within a time \[s\] from its beginning: that of the largest control point.
    pub fn bound(&self, time: f64) -> f64 {
        self.control_points(time).iter().fold(0.0, |most: f64, point| most.max(point.abs()))
    }

    /// Its Bézier ordinates over a time from its beginning: it lies between the least and the largest of them.
    fn control_points(&self, time: f64) -> [f64; 6] {
        // Row j has C(j, i) / C(5, i).
        const SHARES: [[f64; 6]; 6] = [
            [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 0.2, 0.0, 0.0, 0.0, 0.0],
            [1.0, 0.4, 0.1, 0.0, 0.0, 0.0],
            [1.0, 0.6, 0.3, 0.1, 0.0, 0.0],
            [1.0, 0.8, 0.6, 0.4, 0.2, 0.0],
            [1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
        ];
        let mut scaled = self.0;
        let mut power = 1.0;
        for coefficient in &mut scaled {
            *coefficient *= power;
            power *= time;
        }
        SHARES.map(|row| row.iter().zip(&scaled).map(|(share, coefficient)| share * coefficient).sum())
    }
}

fn beyond(points: [f64; 6], lower: f64, upper: f64, halvings: u32) -> Option<f64> {
    let [first, .., last] = points;
    // What is no number is beyond any bound.
    let outside = |value: f64| !(lower..=upper).contains(&value);
    if let Some(value) = [first, last].into_iter().find(|&value| outside(value)) {
        return Some(value);
    }
    let worst = points.into_iter().find(|&value| outside(value))?;
    if halvings == 0 {
        return Some(worst);
    }
    let [left, right] = halved(points);
    let left = beyond(left, lower, upper, halvings - 1);
    left.or_else(|| beyond(right, lower, upper, halvings - 1))
}

/// The control points of both halves, by de Casteljau.
fn halved(mut points: [f64; 6]) -> [[f64; 6]; 2] {
    let (mut left, mut right) = (points, points);
    for level in 1..6 {
        for k in 0..6 - level {
            points[k] = 0.5 * (points[k] + points[k + 1]);
        }
        left[level] = points[0];
        right[5 - level] = points[5 - level];
    }
    [left, right]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Random numbers of -1 to 1.
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut random = mrroc::random::Random::seeded(seed);
        move || random.within(1.0)
    }

    #[test]
    fn a_piece_has_its_ends_and_is_the_integral_of_its_derivative() {
        let mut number = numbers(1);
        for _ in 0..1000 {
            let (from, to) = ([number(), number(), number()], [number(), number(), number()]);
            let time = 0.05 + number().abs();
            let piece = Piece::quintic(from, to, time);
            for (at, expected) in [(0.0, from), (time, to)] {
                for (actual, expected) in piece.at(at).into_iter().zip(expected) {
                    assert!((actual - expected).abs() < 1e-9 / time, "{piece:?} at {at}");
                }
            }
            let cubic = Piece::cubic([from[0], from[1]], [to[0], to[1]], time);
            for (at, expected) in [(0.0, from), (time, to)] {
                let [position, velocity, _] = cubic.at(at);
                assert!(
                    (position - expected[0]).abs() < 1e-12 && (velocity - expected[1]).abs() < 1e-11 / time
                );
            }
            let at = 0.4 * time;
            for piece in [piece, cubic] {
                let difference = (piece.at(at + 1e-6)[0] - piece.at(at - 1e-6)[0]) / 2e-6;
                let slope = piece.derivative().at(at)[0];
                assert!((slope - piece.at(at)[1]).abs() < 1e-9 * (1.0 + slope.abs()));
                assert!(
                    (slope - difference).abs() < 1e-4 * (1.0 + slope.abs() / time),
                    "{slope} {difference}"
                );
            }
        }
    }

    #[test]
    fn what_is_beyond_a_bound_is_found_and_nothing_else() {
        let mut number = numbers(2);
        let (mut found, mut clear) = (0, 0);
        for _ in 0..2000 {
            let piece = Piece([number(), number(), number(), number(), number(), number()]);
            let time = 2.0 * number().abs();
            let values = (0..=4000).map(|k| piece.at(time * f64::from(k) / 4000.0)[0]);
            let (least, most) =
                values.fold((f64::MAX, f64::MIN), |(least, most), x| (least.min(x), most.max(x)));
            let room = 1e-5 * (1.0 + most - least);
            assert_eq!(piece.beyond(time, least - room, most + room), None, "{piece:?} {time}");
            for (lower, upper) in [(least + room, most + room), (least - room, most - room)] {
                if upper - lower > 4.0 * room {
                    let value = piece.beyond(time, lower, upper).expect("it goes beyond");
                    assert!(value < lower || value > upper);
                    found += 1;
                }
            }
            assert!(piece.bound(time) >= most.max(-least) - 1e-12);
            clear += 1;
        }
        assert!(found > 3000 && clear == 2000);
    }
}
