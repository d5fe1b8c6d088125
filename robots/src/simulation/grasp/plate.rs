//! A plate with round holes, which bodies touch with the points of their hull and a peg with its round side.
//!
//! ```text
//! solid of the plate, in P:  z <= 0,  rho >= r,  (rho - r - z - c) / sqrt 2 >= 0   at a hole of radius r and chamfer c (45 degrees)
//!                            or z <= -depth                                         its floor
//! d: the least of the three, of the floor the greater one: how deep a point is in, along the normal of that face
//!
//!      \ c                 c /     two kinds of contact:
//!       |    |   peg  |     |       a point of the body's hull in the plate: the rim of a peg on top, chamfer, wall and floor
//!       |    |________|     |       a point of the hole's edges in the peg: the side or the end of the peg on an edge
//!  P: z up, the origin of the plate on its top
//!
//! n = max(0, k d + c dd/dt)                       along the normal, never pulls
//! t = -k s - beta c v_t,   |t| <= mu n            s: the stretch since it touched, cut to the cone, as of a table
//! ```
//!
//! `d` is continuous from face to face, so the springs' energy is; no term creates energy. A tilted peg touches the wall with its
//! rim and the edge with its side: so it jams or wedges by friction where a real one does (Whitney 1982).

use mrroc::pose::{Pose, Wrench};
use nalgebra::{Unit, Vector3};

use super::body::{Barrel, Moving};
use super::contact::{at_lever, within};
use super::error::{WorldError, not_negative, positive};

/// Points of each edge of a hole.
const EDGE: usize = 32;

/// A plate with holes.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Plate {
    X_WP: Pose,
    holes: Vec<Hole>,
    friction: f64,
    stiffness: f64,
    damping: f64,
}

/// A round hole with a flat floor, square to the plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hole {
    /// Where its middle is, along x and y of P \[m\].
    pub at: [f64; 2],
    /// \[m\], > 0.
    pub diameter: f64,
    /// How far its floor is below the top \[m\], greater than the chamfer.
    pub depth: f64,
    /// How wide its chamfer of 45° is \[m\], >= 0: 0 is a sharp edge.
    pub chamfer: f64,
}

impl Plate {
    /// A plate without holes, with its frame P at `X_WP`: z is its normal, outwards, the origin is on its top. Of friction 0.2, as of
    /// steel on steel with oil, and at each point that touches 1e5 N/m and 100 N s/m (assumed).
    #[must_use]
    #[allow(non_snake_case)]
    pub fn at(X_WP: Pose) -> Self {
        Self { X_WP, holes: Vec::new(), friction: 0.2, stiffness: 1e5, damping: 100.0 }
    }

    /// The same plate with this hole in it. Holes must not meet.
    #[must_use]
    pub fn with_hole(mut self, hole: Hole) -> Self {
        self.holes.push(hole);
        self
    }

    /// The same plate with this coefficient of friction, >= 0.
    #[must_use]
    pub fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// The same plate with this stiffness [N/m], > 0, and damping [N s/m], >= 0, at each point.
    #[must_use]
    pub fn with_stiffness(self, stiffness: f64, damping: f64) -> Self {
        Self { stiffness, damping, ..self }
    }

    pub(super) fn check(&self) -> Result<(), WorldError> {
        if !self.X_WP.to_homogeneous().iter().all(|x| x.is_finite()) {
            return Err(WorldError::NotFinite("the plate's pose"));
        }
        not_negative("the plate's friction", self.friction, "")?;
        positive("the plate's stiffness", self.stiffness, "N/m")?;
        not_negative("the plate's damping", self.damping, "N s/m")?;
        for hole in &self.holes {
            if !hole.at.iter().all(|x| x.is_finite()) {
                return Err(WorldError::NotFinite("the place of a hole"));
            }
            positive("a hole's diameter", hole.diameter, "m")?;
            not_negative("a hole's chamfer", hole.chamfer, "m")?;
            positive("how far a hole's floor is below its chamfer", hole.depth - hole.chamfer, "m")?;
        }
        for (i, a) in self.holes.iter().enumerate() {
            for b in &self.holes[..i] {
                let apart = (a.at[0] - b.at[0]).hypot(a.at[1] - b.at[1]);
                let reach = 0.5 * (a.diameter + b.diameter) + a.chamfer + b.chamfer;
                positive("the plate between two holes", apart - reach, "m")?;
            }
        }
        Ok(())
    }

    /// Stiffness [N/m] and damping [N s/m] of one point.
    pub(super) const fn compliance(&self) -> (f64, f64) {
        (self.stiffness, self.damping)
    }

    /// The contacts that a body with these points, round or not, may have with it.
    pub(super) fn contacts(&self, points: &[Vector3<f64>], barrel: Option<Barrel>) -> Vec<Scrape> {
        let hull = points.iter().map(|at| Scrape::new(Of::Hull(*at)));
        let edges = self.holes.iter().filter(|_| barrel.is_some()).flat_map(Hole::edges);
        hull.chain(edges.map(|at| Scrape::new(Of::Edge(at)))).collect()
    }

    /// How deep a point is in the plate \[m\], negative outside, and the normal there, both in P.
    fn depth(&self, at: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let top = (-at.z, Vector3::z());
        let distance = |hole: &Hole| (at.x - hole.at[0]).hypot(at.y - hole.at[1]) - hole.radius();
        let by_distance = |a: &&Hole, b: &&Hole| distance(a).total_cmp(&distance(b));
        let Some(hole) = self.holes.iter().min_by(by_distance) else { return top };
        let outside = distance(hole);
        let rho = outside + hole.radius();
        // On the axis of the hole, where there is none, the point is far outside of the wall.
        let inwards = Unit::try_new(Vector3::new(hole.at[0] - at.x, hole.at[1] - at.y, 0.0), 1e-12)
            .map_or(Vector3::x(), Unit::into_inner);
        let wall = (rho - hole.radius(), inwards);
        let slope = core::f64::consts::FRAC_1_SQRT_2;
        let chamfer = ((outside - at.z - hole.chamfer) * slope, (inwards + Vector3::z()) * slope);
        let least = |a: (f64, Vector3<f64>), b: (f64, Vector3<f64>)| if b.0 < a.0 { b } else { a };
        let side = least(least(top, wall), chamfer);
        let floor = (-hole.depth - at.z, Vector3::z());
        if floor.0 > side.0 { floor } else { side }
    }

    /// How deep a contact is \[m\], negative where it does not touch; the normal, of the plate on the body; where it is. All in P.
    #[allow(non_snake_case)]
    fn touch(&self, of: &Of, X_PB: &Pose, barrel: Option<&Barrel>) -> (f64, Vector3<f64>, Vector3<f64>) {
        match (of, barrel) {
            (Of::Hull(at), _) => {
                let at = X_PB.rotation * at + X_PB.translation.vector;
                let (depth, normal) = self.depth(&at);
                (depth, normal, at)
            }
            (Of::Edge(at), Some(barrel)) => {
                let at_B = X_PB.rotation.inverse_transform_vector(&(at - X_PB.translation.vector));
                let (depth, outwards) = barrel.depth(&at_B);
                (depth, X_PB.rotation * -outwards, *at)
            }
            (Of::Edge(at), None) => (f64::NEG_INFINITY, Vector3::z(), *at),
        }
    }

    /// Finds the contacts that may touch within `duration` \[s\]: how many there are.
    pub(super) fn find(
        &self,
        body: &Moving,
        barrel: Option<&Barrel>,
        scrapes: &mut [Scrape],
        gravity: f64,
        duration: f64,
    ) -> usize {
        let pose = self.X_WP.inv_mul(&body.state().pose);
        let (velocity, omega) = (body.velocity(), body.angular_velocity());
        let fall = 0.5 * gravity * duration * duration;
        let mut count = 0;
        for scrape in scrapes {
            let (depth, _, at) = self.touch(&scrape.of, &pose, barrel);
            let lever = self.X_WP.rotation * (at - pose.translation.vector);
            let reach = 2.0 * ((velocity + omega.cross(&lever)).norm() * duration + fall);
            scrape.near = depth > -reach;
            if scrape.near {
                count += 1;
            } else {
                (scrape.stretch, scrape.force) = Default::default();
            }
        }
        count
    }

    /// The wrench of the plate on the body, about its centre of mass along the world's axes, after `h` \[s\] at its velocity.
    pub(super) fn press(
        &self,
        body: &Moving,
        barrel: Option<&Barrel>,
        scrapes: &mut [Scrape],
        h: f64,
    ) -> Wrench {
        let pose = self.X_WP.inv_mul(&body.state().pose);
        let into = self.X_WP.rotation.inverse();
        let (velocity, omega) = (into * body.velocity(), into * body.angular_velocity());
        let mut sum = Wrench::default();
        for scrape in scrapes.iter_mut().filter(|scrape| scrape.near) {
            let (depth, normal, at) = self.touch(&scrape.of, &pose, barrel);
            let lever = at - pose.translation.vector;
            let force = self.force(depth, &normal, &(velocity + omega.cross(&lever)), h, &mut scrape.stretch);
            scrape.force = self.X_WP.rotation * force;
            sum = sum + at_lever(force, &lever);
        }
        Wrench::new(self.X_WP.rotation * sum.force, self.X_WP.rotation * sum.torque)
    }

    /// The force of one contact on the body, in P.
    fn force(
        &self,
        depth: f64,
        normal: &Vector3<f64>,
        velocity: &Vector3<f64>,
        h: f64,
        stretch: &mut Vector3<f64>,
    ) -> Vector3<f64> {
        if depth <= 0.0 {
            *stretch = Vector3::zeros();
            return Vector3::zeros();
        }
        let closing = -velocity.dot(normal);
        let press = (self.stiffness * depth + self.damping * closing).max(0.0);
        let sliding = velocity + normal * closing;
        let cone = self.friction * press;
        *stretch += sliding * h;
        // The face may have turned: only what lies in it is a stretch.
        *stretch -= normal * stretch.dot(normal);
        let pull = self.stiffness * stretch.norm();
        if pull > cone {
            *stretch *= cone / pull;
        }
        let elastic = -self.stiffness * *stretch;
        let viscous = -self.damping * sliding;
        normal * press + elastic + viscous * within(&elastic, &viscous, cone)
    }

    /// Energy stored in the contacts of a body \[J\].
    pub(super) fn energy(&self, body: &Moving, barrel: Option<&Barrel>, scrapes: &[Scrape]) -> f64 {
        let pose = self.X_WP.inv_mul(&body.state().pose);
        let of = |scrape: &Scrape| {
            let depth = self.touch(&scrape.of, &pose, barrel).0.max(0.0);
            0.5 * self.stiffness * (depth * depth + scrape.stretch.norm_squared())
        };
        scrapes.iter().map(of).sum()
    }
}

impl Hole {
    fn radius(&self) -> f64 {
        0.5 * self.diameter
    }

    /// Points of its edges, in P: that of the wall, and that of the chamfer if there is one.
    fn edges(&self) -> impl Iterator<Item = Vector3<f64>> {
        let (wall, chamfer) = ((self.radius(), -self.chamfer), (self.radius() + self.chamfer, 0.0));
        let circles = [Some(wall), (self.chamfer > 0.0).then_some(chamfer)];
        let [x, y] = self.at;
        circles.into_iter().flatten().flat_map(move |(radius, z)| {
            (0..EDGE).map(move |i| {
                let angle = i as f64 * core::f64::consts::TAU / EDGE as f64;
                Vector3::new(x + radius * angle.cos(), y + radius * angle.sin(), z)
            })
        })
    }
}

/// Where a contact is.
#[derive(Clone, Copy, Debug)]
enum Of {
    /// At a point of the body's hull \[m, in B\].
    Hull(Vector3<f64>),
    /// At a point of an edge of a hole \[m, in P\].
    Edge(Vector3<f64>),
}

/// A contact of a body with a plate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scrape {
    of: Of,
    /// Whether it may touch in this interval.
    near: bool,
    /// How far it has crept from where it stuck \[m, in P\].
    stretch: Vector3<f64>,
    /// The force on the body \[N\], in the world's axes.
    pub force: Vector3<f64>,
}

impl Scrape {
    fn new(of: Of) -> Self {
        Self { of, near: false, stretch: Vector3::zeros(), force: Vector3::zeros() }
    }
}
