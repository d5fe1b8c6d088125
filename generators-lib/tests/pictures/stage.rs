//! Arms that do exactly as they are told, and what surrounds them.
//!
//! In: a generator and what it is told in each step. Out: where the tools are demanded to be.

use mrroc::generator::{Generator, Motion, RobotList, Robots};
use mrroc::pose::Wrench;
use mrroc::prelude::*;
use mrroc::robot::{RobotImage, RobotState};
use mrroc::sensor::SensorImage;
use mrroc_generators::cooperation::Displacement;
use mrroc_robots::{Irp6, Six};
use nalgebra::Vector3;

use super::sheet::Trace;

/// Path time of a step \[s\].
pub const DT: f64 = 4e-3;

/// Two arms.
pub type Two = [Irp6; 2];
/// What is known of an arm.
pub type Image = RobotImage<Irp6>;

/// A force and torque sensor.
pub struct Wrist;

impl Sensor for Wrist {
    const KIND: &'static str = "wrist";
    type Reading = Wrench;
    type Configuration = ();
}

/// What sees where something is.
pub struct Camera;

impl Sensor for Camera {
    const KIND: &'static str = "camera";
    type Reading = Displacement;
    type Configuration = ();
}

/// Where the joints are at the start [rad].
pub fn joints() -> Six {
    Irp6::READY
}

fn image(pose: Pose) -> Image {
    let state = RobotState { joints: joints(), velocity: Six::zeros(), pose };
    RobotImage::new(state, state)
}

/// Where the tool is at the start.
pub fn start() -> Pose {
    Irp6::nominal().forward(&joints())
}

/// A force along the tool's z axis \[N\].
pub fn force(z: f64) -> SensorImage<Wrist> {
    SensorImage::new(Wrench::new(Vector3::z() * z, Vector3::zeros()), 0)
}

/// What the tool feels of a spring of 2 N/mm that begins `gap` \[m\] ahead of it.
pub fn table(at: &Image, gap: f64) -> SensorImage<Wrist> {
    let depth = start().inv_mul(&at.demanded().pose).translation.z - gap;
    force(-2000.0 * depth.max(0.0))
}

/// How many arms a list has, and how it is spelled.
pub trait Arms: Robots<Motion> + Sized {
    /// The state of the list's arms.
    fn state(images: &[Image; 2]) -> State<Self>;
    /// What each is told.
    fn told(demands: &Self::Demands) -> Vec<Demand<Irp6>>;
}

impl Arms for Irp6 {
    fn state(images: &[Image; 2]) -> State<Self> {
        State::new(images[0])
    }
    fn told(demands: &Demand<Irp6>) -> Vec<Demand<Irp6>> {
        vec![*demands]
    }
}

impl Arms for Two {
    fn state(images: &[Image; 2]) -> State<Self> {
        State::new(*images)
    }
    fn told(demands: &[Demand<Irp6>; 2]) -> Vec<Demand<Irp6>> {
        demands.to_vec()
    }
}

impl Arms for (Irp6, Irp6) {
    fn state(images: &[Image; 2]) -> State<Self> {
        State::new((images[0], images[1]))
    }
    fn told(demands: &(Demand<Irp6>, Demand<Irp6>)) -> Vec<Demand<Irp6>> {
        vec![demands.0, demands.1]
    }
}

/// Where a demand leads a tool that is at `image` and began at `origin`.
fn followed(demand: &Demand<Irp6>, image: &Image, origin: &Pose) -> Image {
    let joints = demand.as_joints().unwrap_or(image.demanded().joints);
    let pose = demand
        .as_pose()
        .or_else(|| demand.as_displacement().map(|moved| origin * moved))
        .or_else(|| demand.as_joints().map(|q| Irp6::nominal().forward(&q)))
        .unwrap_or(image.demanded().pose);
    let state = RobotState { joints, velocity: Six::zeros(), pose };
    RobotImage::new(state, state)
}

/// Follows a generator to its end, or for so many steps, as long as it throws no fault.
pub fn follow<G>(
    mut generator: G,
    most: u64,
    mut known: impl FnMut(u64, &[Image; 2]) -> (G::Order, Reading<G::Sensors>),
) -> Vec<Trace>
where
    G: Generator<Language = Motion>,
    G::Robots: Arms,
{
    let origins = [start(), Pose::translation(0.0, 0.5, 0.0) * start()];
    let mut images = origins.map(image);
    let mut traces: Vec<Trace> =
        origins[..<G::Robots as RobotList>::LEN].iter().map(|pose| vec![pose.translation.vector]).collect();
    for step in 0..most {
        let t = Tick { step, dt: DT, duration: DT };
        let ((order, v), e) = (known(step, &images), G::Robots::state(&images));
        let order = Order::new(order);
        let stepped = if step == 0 {
            generator.first_step(&order, &e, &v, t)
        } else {
            generator.next_step(&order, &e, &v, t)
        };
        let Ok(Step::Next(demands)) = stepped else { break };
        for (i, demand) in G::Robots::told(&demands).iter().enumerate() {
            images[i] = followed(demand, &images[i], &origins[i]);
            traces[i].push(images[i].demanded().pose.translation.vector);
        }
    }
    traces
}

/// Without sensors and orders, to its end.
pub fn alone<G>(generator: G) -> Vec<Trace>
where
    G: Generator<Language = Motion, Sensors = (), Order = ()>,
    G::Robots: Arms,
{
    follow(generator, 5_000, |_, _| ((), Reading::new(())))
}

/// An order that leads along z by 50 mm and back within a second, rest to rest.
pub fn ordered(step: u64) -> Displacement {
    let x = (step as f64 * DT).min(1.0);
    Displacement {
        pose: Pose::translation(0.0, 0.0, 0.1 * (0.5 - 0.5 * (std::f64::consts::TAU * x).cos()).powi(2)),
    }
}
