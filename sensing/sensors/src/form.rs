//! The form of a thing as light meets it: a union of solids with simple surfaces.
//!
//! In: a ray in the frame P of the form. Out: where it meets the surface first, and the normal there. The frame P of a part lies where
//! the part does: z = 0 is what it stands on, z up.

use nalgebra::{Vector2, Vector3};

/// A solid with a simple surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A box along the axes, from the lower to the upper corner \[m\].
    Block {
        /// Lower corner.
        lower: Vector3<f64>,
        /// Upper corner.
        upper: Vector3<f64>,
    },
    /// An upright tube from z = 0 on; a cylinder where the inner radius is 0.
    Tube {
        /// Outer radius \[m\].
        radius: f64,
        /// Inner radius \[m\], 0 of none.
        inner: f64,
        /// \[m\].
        height: f64,
    },
    /// The part of a ball about (0, 0, `centre`) above z = `from` \[m\].
    Cap {
        /// Radius of the ball \[m\].
        radius: f64,
        /// Height of its centre \[m\].
        centre: f64,
        /// Where it begins \[m\].
        from: f64,
    },
    /// A half-cylinder that lies on z = 0, its axis along x, of this radius and half length \[m\].
    Half {
        /// \[m\].
        radius: f64,
        /// \[m\].
        half_length: f64,
    },
    /// All points within a radius \[m\] of a segment.
    Capsule {
        /// Its ends \[m\].
        ends: [Vector3<f64>; 2],
        /// \[m\].
        radius: f64,
    },
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the ray's direction, > 0.
    pub distance: f64,
    /// Unit vector, outwards.
    pub normal: Vector3<f64>,
}

/// A union of pieces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Form(Vec<Piece>);

impl Form {
    /// Of these pieces.
    #[must_use]
    pub fn new(pieces: impl IntoIterator<Item = Piece>) -> Self {
        Self(pieces.into_iter().collect())
    }

    /// Its pieces.
    #[must_use]
    pub fn pieces(&self) -> &[Piece] {
        &self.0
    }

    /// The same form, `scale` times as large.
    #[must_use]
    pub fn scaled(&self, scale: f64) -> Self {
        Self(self.0.iter().map(|piece| piece.scaled(scale)).collect())
    }

    /// Where a ray meets it first.
    #[must_use]
    pub fn hit(&self, origin: &Vector3<f64>, direction: &Vector3<f64>) -> Option<Hit> {
        let nearer = |a: Hit, b: Hit| if b.distance < a.distance { b } else { a };
        self.0.iter().filter_map(|piece| piece.hit(origin, direction)).reduce(nearer)
    }

    /// Corners of boxes that hold its pieces \[m\].
    pub fn corners(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.0.iter().flat_map(|piece| {
            let (lower, upper) = piece.extent();
            (0..8).map(move |i| {
                Vector3::from_fn(|axis, _| if i & (1 << axis) == 0 { lower[axis] } else { upper[axis] })
            })
        })
    }
}

impl Piece {
    fn scaled(&self, scale: f64) -> Self {
        match *self {
            Self::Block { lower, upper } => Self::Block { lower: lower * scale, upper: upper * scale },
            Self::Tube { radius, inner, height } => {
                Self::Tube { radius: radius * scale, inner: inner * scale, height: height * scale }
            }
            Self::Cap { radius, centre, from } => {
                Self::Cap { radius: radius * scale, centre: centre * scale, from: from * scale }
            }
            Self::Half { radius, half_length } => {
                Self::Half { radius: radius * scale, half_length: half_length * scale }
            }
            Self::Capsule { ends, radius } => {
                Self::Capsule { ends: ends.map(|end| end * scale), radius: radius * scale }
            }
        }
    }

    /// Lower and upper corner of the box that holds it \[m\].
    fn extent(&self) -> (Vector3<f64>, Vector3<f64>) {
        match *self {
            Self::Block { lower, upper } => (lower, upper),
            Self::Tube { radius, height, .. } => {
                (Vector3::new(-radius, -radius, 0.0), Vector3::new(radius, radius, height))
            }
            Self::Cap { radius, centre, from } => {
                let across = (radius * radius - (from - centre).powi(2)).max(0.0).sqrt();
                (Vector3::new(-across, -across, from), Vector3::new(across, across, centre + radius))
            }
            Self::Half { radius, half_length } => {
                (Vector3::new(-half_length, -radius, 0.0), Vector3::new(half_length, radius, radius))
            }
            Self::Capsule { ends: [a, b], radius } => {
                let around = Vector3::repeat(radius);
                (a.inf(&b) - around, a.sup(&b) + around)
            }
        }
    }

    /// Where a ray meets it first.
    fn hit(&self, o: &Vector3<f64>, d: &Vector3<f64>) -> Option<Hit> {
        match *self {
            Self::Block { lower, upper } => slabs(o, d, &lower, &upper),
            Self::Tube { radius, inner, height } => tube(o, d, radius, inner, height),
            Self::Cap { radius, centre, from } => {
                let centre = Vector3::new(0.0, 0.0, centre);
                let above = |hit: &Hit| o.z + hit.distance * d.z >= from;
                ball(o, d, &centre, radius).into_iter().flatten().find(above)
            }
            Self::Half { radius, half_length } => half(o, d, radius, half_length),
            Self::Capsule { ends, radius } => capsule(o, d, &ends, radius),
        }
    }
}

/// A box: the last slab that is entered.
fn slabs(o: &Vector3<f64>, d: &Vector3<f64>, lower: &Vector3<f64>, upper: &Vector3<f64>) -> Option<Hit> {
    let (mut enter, mut leave, mut face) = (f64::NEG_INFINITY, f64::INFINITY, 0);
    for axis in 0..3 {
        let inverse = d[axis].recip();
        let (a, b) = ((lower[axis] - o[axis]) * inverse, (upper[axis] - o[axis]) * inverse);
        let (near, far) = if a < b { (a, b) } else { (b, a) };
        if near > enter {
            (enter, face) = (near, axis);
        }
        leave = leave.min(far);
    }
    if enter > leave || enter <= 0.0 {
        return None;
    }
    let mut normal = Vector3::zeros();
    normal[face] = -d[face].signum();
    Some(Hit { distance: enter, normal })
}

/// Roots of a t^2 + 2 b t + c.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - a * c;
    (discriminant >= 0.0 && a > 0.0).then(|| {
        let root = discriminant.sqrt();
        [(-b - root) / a, (-b + root) / a]
    })
}

fn tube(o: &Vector3<f64>, d: &Vector3<f64>, radius: f64, inner: f64, height: f64) -> Option<Hit> {
    let (p, v) = (o.xy(), d.xy());
    let mut first: Option<Hit> = None;
    let mut take = |distance: f64, normal: Vector3<f64>| {
        if distance > 0.0 && first.is_none_or(|first| distance < first.distance) {
            first = Some(Hit { distance, normal });
        }
    };
    // Its top, the outer wall where the ray enters, the inner wall where the ray leaves the hole.
    let distance = (height - o.z) / d.z;
    let at = p + v * distance;
    if (inner * inner..=radius * radius).contains(&at.norm_squared()) {
        take(distance, Vector3::z());
    }
    let wall = |r: f64, which: usize| {
        let distance = roots(v.norm_squared(), p.dot(&v), p.norm_squared() - r * r)?[which];
        let z = o.z + distance * d.z;
        let out: Vector2<f64> = (p + v * distance) / r;
        (0.0..=height).contains(&z).then_some((distance, Vector3::new(out.x, out.y, 0.0)))
    };
    if let Some((distance, normal)) = wall(radius, 0) {
        take(distance, normal);
    }
    if inner > 0.0
        && let Some((distance, normal)) = wall(inner, 1)
    {
        take(distance, -normal);
    }
    first
}

fn ball(o: &Vector3<f64>, d: &Vector3<f64>, centre: &Vector3<f64>, radius: f64) -> [Option<Hit>; 2] {
    let offset = o - centre;
    let Some(both) = roots(d.norm_squared(), offset.dot(d), offset.norm_squared() - radius * radius) else {
        return [None, None];
    };
    both.map(|t| (t > 0.0).then(|| Hit { distance: t, normal: (offset + d * t) / radius }))
}

fn half(o: &Vector3<f64>, d: &Vector3<f64>, radius: f64, half_length: f64) -> Option<Hit> {
    // The round side, from outside; else an end.
    let (p, v) = (o.yz(), d.yz());
    if let Some([distance, _]) = roots(v.norm_squared(), p.dot(&v), p.norm_squared() - radius * radius) {
        let at = o + d * distance;
        if distance > 0.0 && at.z >= 0.0 && at.x.abs() <= half_length {
            return Some(Hit { distance, normal: Vector3::new(0.0, at.y, at.z) / radius });
        }
    }
    let end = -half_length * d.x.signum();
    let distance = (end - o.x) / d.x;
    let at = o + d * distance;
    let on = distance > 0.0 && at.z >= 0.0 && at.yz().norm_squared() <= radius * radius;
    on.then(|| Hit { distance, normal: Vector3::x() * end.signum() })
}

fn capsule(o: &Vector3<f64>, d: &Vector3<f64>, ends: &[Vector3<f64>; 2], radius: f64) -> Option<Hit> {
    let [a, b] = ends;
    let (axis, offset) = (b - a, o - a);
    let (length, along, start) = (axis.norm_squared(), axis.dot(d), axis.dot(&offset));
    let (p, v) = (offset * length - axis * start, d * length - axis * along);
    let scale = length * length * radius * radius;
    let mut best = if length > 0.0 {
        roots(v.norm_squared(), p.dot(&v), p.norm_squared() - scale).and_then(|[t, _]| {
            let s = (start + t * along) / length;
            let normal = (offset + d * t - axis * s) / radius;
            (t > 0.0 && (0.0..=1.0).contains(&s)).then_some(Hit { distance: t, normal })
        })
    } else {
        None
    };
    for end in ends {
        let [first, _] = ball(o, d, end, radius);
        if let Some(hit) = first.filter(|hit| best.is_none_or(|best| hit.distance < best.distance)) {
            best = Some(hit);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn down(x: f64, y: f64) -> (Vector3<f64>, Vector3<f64>) {
        (Vector3::new(x, y, 1.0), -Vector3::z())
    }

    #[test]
    fn rays_from_above_meet_each_form_at_its_height() {
        let block =
            Piece::Block { lower: Vector3::new(-0.03, -0.02, 0.0), upper: Vector3::new(0.03, 0.02, 0.04) };
        let ring = Piece::Tube { radius: 0.03, inner: 0.014, height: 0.032 };
        let cap = Piece::Cap { radius: 0.04, centre: 0.0, from: 0.02 };
        let half = Piece::Half { radius: 0.03, half_length: 0.05 };
        let lying = Piece::Capsule {
            ends: [Vector3::new(-0.1, 0.0, 0.5), Vector3::new(0.1, 0.0, 0.5)],
            radius: 0.02,
        };
        let height = |piece: &Piece, x, y| {
            let (o, d) = down(x, y);
            piece.hit(&o, &d).map(|hit| 1.0 - hit.distance)
        };
        let near =
            |got: Option<f64>, wanted: f64| assert!((got.expect("met") - wanted).abs() < 1e-12, "{got:?}");
        near(height(&block, 0.02, 0.01), 0.04);
        assert_eq!(height(&block, 0.04, 0.0), None);
        near(height(&ring, 0.02, 0.0), 0.032);
        assert_eq!(height(&ring, 0.0, 0.01), None);
        // Pythagoras.
        near(height(&cap, 0.024, 0.0), 0.032);
        assert_eq!(height(&cap, 0.036, 0.0), None);
        near(height(&half, 0.04, 0.018), 0.024);
        near(height(&lying, 0.05, 0.012), 0.516);
        near(height(&lying, 0.112, 0.0), 0.516);
    }

    #[test]
    fn slanted_rays_meet_walls_with_their_normals() {
        // Towards the hole of a ring, and its far wall inside.
        let ring = Piece::Tube { radius: 0.03, inner: 0.02, height: 0.04 };
        let hit = ring.hit(&Vector3::new(-0.015, 0.0, 0.05), &Vector3::new(1.0, 0.0, -1.0)).expect("met");
        assert!(
            (hit.distance - 0.035).abs() < 1e-12 && (hit.normal + Vector3::x()).norm() < 1e-12,
            "{hit:?}"
        );
        let block = Piece::Block { lower: Vector3::repeat(0.0), upper: Vector3::repeat(0.05) };
        let hit = block.hit(&Vector3::new(-0.1, 0.02, 0.02), &Vector3::new(2.0, 0.0, 0.0)).expect("met");
        assert!((hit.distance - 0.05).abs() < 1e-12 && (hit.normal + Vector3::x()).norm() < 1e-12, "{hit:?}");
        let half = Piece::Half { radius: 0.03, half_length: 0.05 };
        let hit = half.hit(&Vector3::new(0.1, 0.0, 0.02), &Vector3::new(-1.0, 0.0, -0.1)).expect("met");
        assert!((hit.distance - 0.05).abs() < 1e-12 && (hit.normal - Vector3::x()).norm() < 1e-12, "{hit:?}");
    }
}
