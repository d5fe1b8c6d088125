//! Writes the robots of the library as URDFs, with random states and what our dynamics says of them, for
//! `tests/peers/dynamics`.
//!
//! `cargo run --release -p mrroc-examples --example dynamics -- FOLDER STATES [SEED]` writes for every robot `NAME.urdf` and
//! `NAME.f64`: per state, numbers of 8 bytes, little-endian, in the joints' order: q, qdot, qddot, the tip's wrench in the world
//! (force, torque), tau (inverse dynamics of these), qddot (forward dynamics of that tau and wrench), the bias, the weight's
//! torques, M column by column, kinetic and potential energy. Of RNT, whose joints are no tree: q, qdot, M, bias.
//! `energy.csv`: kinetic and potential energy at the start and the largest change of their sum in 10 s of free motion
//! (Runge-Kutta of order 4, steps of 1 ms) \[J\].

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use mrroc::pose::{Pose, Wrench};
use mrroc::random::Random;
use mrroc::robot::{JointVector, Load, Robot, Tool};
use mrroc_robots::{
    Conveyor, Driven, Gripper, Irp6, Irp6FiveDof, Irp6Track, Polycrank, Rnt, Serial, TwoFingers,
};
use nalgebra::{Matrix3, SVector, Vector3};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn vector(random: &mut Random, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.between(-size, size))
}

/// Where the files go, and how many states.
struct Comparison {
    folder: PathBuf,
    states: u32,
    seed: u64,
    energies: Vec<String>,
}

/// A base that stands neither upright nor at the origin.
fn base() -> Pose {
    Pose::new(Vector3::new(0.4, -0.3, 0.2), Vector3::new(0.3, -0.5, 0.7))
}

/// A tool with a load on the flange.
fn tool() -> Tool {
    let inertia = Matrix3::new(4e-3, 2e-4, -1e-4, 2e-4, 5e-3, 3e-4, -1e-4, 3e-4, 3e-3);
    let load = Load { mass: 1.2, centre: Vector3::new(0.01, -0.02, 0.07), inertia };
    Tool { frame: Pose::new(Vector3::new(0.0, 0.03, 0.15), Vector3::new(0.0, 0.4, 0.0)), load }
}

impl Comparison {
    fn writer(
        &self,
        name: &str,
        urdf: Option<String>,
    ) -> Result<BufWriter<File>, Box<dyn std::error::Error>> {
        fs::write(self.folder.join(format!("{name}.urdf")), urdf.ok_or("no URDF")?)?;
        Ok(BufWriter::new(File::create(self.folder.join(format!("{name}.f64")))?))
    }

    /// Random positions within the limits, of endless joints within 3 rad, and speeds within theirs.
    fn state<const N: usize, R: Robot<Joints = SVector<f64, N>>>(
        robot: &R,
        random: &mut Random,
    ) -> [SVector<f64, N>; 2] {
        let limits = robot.limits();
        let q = SVector::from_joints(|i| random.between(limits.lower[i].max(-3.0), limits.upper[i].min(3.0)));
        [q, SVector::from_joints(|i| limits.velocity[i] * random.between(-1.0, 1.0))]
    }

    fn tree<const N: usize, R: Driven<N>>(&mut self, name: &str, robot: &R) -> Outcome {
        let mut file = self.writer(name, robot.urdf(name, &tool()))?;
        let tree = robot.tree().ok_or("no tree")?.with_load(&tool().load);
        let mut random = Random::seeded(self.seed);
        let mut put = |numbers: &[f64]| -> Outcome {
            numbers.iter().try_for_each(|x| file.write_all(&x.to_le_bytes()))?;
            Ok(())
        };
        for _ in 0..self.states {
            let [q, v] = Self::state(robot, &mut random);
            let a = robot.limits().acceleration.map(|most| random.between(-most, most));
            let wrench = Wrench::new(vector(&mut random, 50.0), vector(&mut random, 10.0));
            let tau = tree.inverse_dynamics(&q, &v, &a, Some(&wrench));
            let back = tree.forward_dynamics(&q, &v, &tau, Some(&wrench)).ok_or("no mass")?;
            let (bias, weight) = (tree.bias(&q, &v), tree.gravity_torques(&q));
            for vector in [&q, &v, &a] {
                put(vector.as_slice())?;
            }
            put(wrench.force.as_slice())?;
            put(wrench.torque.as_slice())?;
            for vector in [&tau, &back, &bias, &weight] {
                put(vector.as_slice())?;
            }
            put(tree.mass_matrix(&q).as_slice())?;
            put(&[tree.kinetic_energy(&q, &v), tree.potential_energy(&q)])?;
        }
        // Free motion: no motor, no friction, no limit.
        let [mut q, mut v] = Self::state(robot, &mut Random::seeded(self.seed + 1));
        let energies = |q: &_, v: &_| [tree.kinetic_energy(q, v), tree.potential_energy(q)];
        let start = energies(&q, &v);
        let (h, mut worst, mut most) = (1e-3, 0.0_f64, start[0]);
        let none = SVector::zeros();
        for _ in 0..10_000 {
            let rate = |q: &_, v: &SVector<f64, N>| {
                tree.forward_dynamics(q, v, &none, None).map(|a| (*v, a)).ok_or("no mass")
            };
            let (k1, a1) = rate(&q, &v)?;
            let (k2, a2) = rate(&(q + k1 * (h / 2.0)), &(v + a1 * (h / 2.0)))?;
            let (k3, a3) = rate(&(q + k2 * (h / 2.0)), &(v + a2 * (h / 2.0)))?;
            let (k4, a4) = rate(&(q + k3 * h), &(v + a3 * h))?;
            q += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
            v += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
            let [kinetic, potential] = energies(&q, &v);
            worst = worst.max((kinetic + potential - start[0] - start[1]).abs());
            most = most.max(kinetic);
        }
        self.energies.push(format!("{name},{},{},{most},{worst}", start[0], start[1]));
        Ok(())
    }

    /// An arm of the tests read from URDF. One whose links have no `<inertial>` is given masses: what counts is that both read the same.
    fn serial<const N: usize>(&mut self, name: &str, base_link: &str, tip: &str) -> Outcome {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join(format!("../../robots/tests/reference/urdf/{name}.urdf"));
        let mut text = fs::read_to_string(path)?;
        for k in 1_u32.. {
            let Some((before, after)) =
                text.split_once("\"/>\n  <link name=\"").filter(|_| !text.contains("<inertial>") || k > 1)
            else {
                break;
            };
            let x = 0.1 + 0.02 * f64::from(k);
            text = format!(
                "{before}\"><inertial><origin xyz=\"{x} 0.05 {}\" rpy=\"{x} 0.3 0\"/><mass value=\"{}\"/><inertia ixx=\"0.2\" \
                 ixy=\"0.01\" ixz=\"-0.02\" iyy=\"0.25\" iyz=\"0.03\" izz=\"{x}\"/></inertial></link>\n  <link name=\"{after}",
                -x,
                40.0 / f64::from(k),
            );
        }
        let robot =
            Serial::<N>::from_urdf(&text, base_link, tip)?.with_acceleration(SVector::repeat(10.0))?;
        self.tree(name, &robot.with_base(base()))
    }

    /// RNT, whose loops the comparison closes.
    fn rnt(&mut self) -> Outcome {
        let robot = Rnt::new().with_base(base());
        let mut file = self.writer("rnt", robot.urdf("rnt", &Tool { load: Load::NONE, ..tool() }))?;
        let closed = robot.dynamics().ok_or("no dynamics")?;
        let mut random = Random::seeded(self.seed);
        let mut states = 0;
        while states < self.states {
            let [q, v] = Self::state(&robot, &mut random);
            if robot.check_coupled(&q, &q, 1.0).is_err() {
                continue;
            }
            states += 1;
            let equation = closed.equation(&q, &v);
            let numbers = [q.as_slice(), v.as_slice(), equation.mass.as_slice(), equation.bias.as_slice()];
            for x in numbers.concat() {
                file.write_all(&x.to_le_bytes())?;
            }
        }
        Ok(())
    }
}

fn main() -> Outcome {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("which folder?")?);
    let states = arguments.next().ok_or("how many states?")?.parse()?;
    let seed = arguments.next().map_or(Ok(1955), |seed| seed.parse())?;
    fs::create_dir_all(&folder)?;
    let mut comparison = Comparison { folder, states, seed, energies: Vec::new() };
    comparison.tree("irp6", &Irp6::nominal().with_base(base()))?;
    comparison.tree("irp6-calibrated", &Irp6::calibrated().with_base(base()))?;
    comparison.tree("irp6-5dof", &Irp6FiveDof::nominal().with_base(base()))?;
    comparison.tree("irp6-track", &Irp6Track::nominal().with_base(base()))?;
    comparison.tree("irp6-track-calibrated", &Irp6Track::calibrated().with_base(base()))?;
    comparison.tree("polycrank", &Polycrank::new().with_base(base()))?;
    comparison.tree("gripper", &Gripper::new().with_base(base()))?;
    comparison.tree("two-fingers", &TwoFingers::new().with_base(base()))?;
    comparison.tree("conveyor", &Conveyor::new().with_base(base()))?;
    comparison.serial::<6>("weighted_arm", "base_link", "tool0")?;
    comparison.serial::<7>("seven_axes", "world_foot", "flange")?;
    comparison.serial::<4>("gantry", "bed", "tool")?;
    comparison.serial::<4>("palletiser", "base", "tool")?;
    comparison.rnt()?;
    fs::write(comparison.folder.join("energy.csv"), comparison.energies.join("\n") + "\n")?;
    Ok(())
}
