//! The problems of MotionBenchMaker for one robot, from a file that `tests/peers/planning/problems.py` writes.

use std::error::Error;

use mrroc::pose::Pose;
use mrroc_robots::clearance::{Clearance, ClearanceBuilder, Obstacle, Stop, Stopping};
use mrroc_robots::{Meshes, Serial, SerialOutline};
use nalgebra::{Quaternion, SVector, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;

/// A robot and its problems.
pub struct Problems {
    /// The first line of the file: names, limits and files of the robot.
    pub robot: Value,
    /// Its URDF.
    urdf: String,
    /// The other lines that are not known to be invalid.
    pub problems: Vec<Value>,
}

impl Problems {
    /// Reads the file, and the URDF that stands under `key` in its first line.
    pub fn read(file: &str, key: &str) -> Result<Self, Box<dyn Error>> {
        let text = std::fs::read_to_string(file).map_err(|error| format!("{file}: {error}"))?;
        let mut lines = text.lines();
        let robot: Value = serde_json::from_str(lines.next().ok_or("an empty file")?)?;
        let problems = lines.map(serde_json::from_str).collect::<Result<Vec<Value>, _>>()?;
        let problems = problems.into_iter().filter(|problem| problem["valid"] != Value::Bool(false));
        let urdf = std::fs::read_to_string(robot[key].as_str().ok_or("no URDF")?)?;
        // Meshes are files below the folder, and the file of UR5's gripper writes the upper half of a matrix twice.
        let urdf = urdf.replace("package://", "");
        let urdf = ["iyx", "izx", "izy"]
            .iter()
            .fold(urdf, |urdf, name| urdf.replace(&format!(" {name}=\"0.000000\""), ""));
        Ok(Problems { problems: problems.collect(), robot, urdf })
    }

    /// How many joints the robot has.
    pub fn joints(&self) -> usize {
        self.robot["joints"].as_array().map_or(0, Vec::len)
    }

    /// The robot, with a limit of acceleration [rad/s² or m/s²] for all joints, > 0.
    pub fn arm<const N: usize>(&self, acceleration: f64) -> Result<Serial<N>, Box<dyn Error>> {
        let [base, tip] = self.ends();
        let arm =
            Serial::from_urdf(&self.urdf, base, tip)?.with_acceleration(SVector::repeat(acceleration))?;
        Ok(arm.with_positions(vector(&self.robot["lower"])?, vector(&self.robot["upper"])?)?)
    }

    /// Its shape.
    pub fn outline<const N: usize>(&self, arm: Serial<N>) -> Result<SerialOutline<N>, Box<dyn Error>> {
        let meshes = Meshes::below(self.robot["meshes"].as_str().unwrap_or("."));
        let [base, tip] = self.ends();
        Ok(SerialOutline::from_urdf(arm, &self.urdf, base, tip, &meshes)?)
    }

    fn ends(&self) -> [&str; 2] {
        ["base", "tip"].map(|key| self.robot[key].as_str().unwrap_or_default())
    }
}

/// The robot among the obstacles of a problem, at a margin \[m\].
pub fn clearance<const N: usize>(
    outline: &SerialOutline<N>,
    problem: &Value,
    margin: f64,
) -> Result<Clearance, Box<dyn Error>> {
    let builder = Clearance::with_margin(margin).robot("arm", outline.clone())?;
    Ok(obstacles(builder, problem)?.build(Stopping { reaction: 0.02, stop: Stop::Braking })?)
}

/// Where a problem begins [rad or m], and its goals.
#[allow(clippy::type_complexity)]
pub fn ends<const N: usize>(problem: &Value) -> Result<(Vec<f64>, Vec<Vec<f64>>), Box<dyn Error>> {
    let positions = |value: &Value| Ok(vector::<N>(value)?.as_slice().to_vec());
    let goals = problem["goals"].as_array().ok_or("no goals")?;
    Ok((positions(&problem["start"])?, goals.iter().map(positions).collect::<Result<_, Box<dyn Error>>>()?))
}

fn vector<const N: usize>(value: &Value) -> Result<SVector<f64, N>, Box<dyn Error>> {
    let list = value.as_array().ok_or("no list")?;
    let numbers = list.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>().ok_or("no numbers")?;
    if numbers.len() == N {
        Ok(SVector::from_column_slice(&numbers))
    } else {
        Err("too many or too few numbers".into())
    }
}

#[allow(non_snake_case)]
fn obstacles(mut builder: ClearanceBuilder, problem: &Value) -> Result<ClearanceBuilder, Box<dyn Error>> {
    let place = |body: &Value| -> Result<Pose, Box<dyn Error>> {
        let q = vector::<4>(&body["quaternion"])?;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[3], q[0], q[1], q[2]));
        Ok(Pose::from_parts(Translation3::from(vector::<3>(&body["center"])?), turn))
    };
    let name = |body: &Value| body["name"].as_str().unwrap_or("body").to_owned();
    for body in problem["boxes"].as_array().into_iter().flatten() {
        let half: Vector3<f64> = vector::<3>(&body["half_extents"])?;
        builder = builder.obstacle(&name(body), Obstacle::Box { X_WO: place(body)?, half })?;
    }
    for body in problem["cylinders"].as_array().into_iter().flatten() {
        let number = |key: &str| body[key].as_f64().ok_or("no number");
        let (radius, half_length) = (number("radius")?, number("half_length")?);
        builder =
            builder.obstacle(&name(body), Obstacle::Cylinder { X_WO: place(body)?, radius, half_length })?;
    }
    for body in problem["spheres"].as_array().into_iter().flatten() {
        let radius = body["radius"].as_f64().ok_or("no number")?;
        builder = builder.obstacle(&name(body), Obstacle::ball(vector::<3>(&body["center"])?, radius))?;
    }
    Ok(builder)
}
