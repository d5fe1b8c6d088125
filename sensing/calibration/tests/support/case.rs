//! A problem as `tests/reference/fits.py` writes it, and as this crate states it.

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use mrroc_calibration::*;
use nalgebra::Vector3;
use serde_json::Value;

/// A problem of `fits.json`.
pub struct Case(Value);

/// The problem as this crate states it.
pub struct Stated {
    pub problem: Problem,
    pub arm: ArmId,
    pub balls: Vec<TargetId>,
}

impl Case {
    pub fn new(value: Value) -> Self {
        Self(value)
    }

    pub fn number(&self, key: &str) -> Option<f64> {
        self.0[key].as_f64()
    }

    pub fn loss(&self) -> Loss {
        match self.0["loss"].as_str() {
            Some("huber") => Loss::Huber(1.0),
            Some("cauchy") => Loss::Cauchy(1.0),
            _ => Loss::Squares,
        }
    }

    pub fn rows(&self, key: &str) -> Vec<Vec<f64>> {
        rows(&self.0[key])
    }

    /// Points by pose and ball.
    pub fn points(&self, key: &str) -> Vec<Vec<Vec<f64>>> {
        self.0[key].as_array().expect("poses").iter().map(rows).collect()
    }

    #[allow(non_snake_case)]
    pub fn stated(&self) -> Stated {
        let dh = self.rows("dh").into_iter().enumerate().map(|(i, row)| DhRow {
            name: format!("joint {}", i + 1),
            kind: JointKind::Revolute,
            theta: row[0],
            d: row[1],
            a: row[2],
            alpha: row[3],
        });
        let chain = Chain::distal(&dh.collect::<Vec<_>>());
        let all = self.rows("free").len() == 36;
        let detail = if all { Detail::Geometry } else { Detail::Zeros };
        let tolerance = self.number("tolerance");
        let same = tolerance.unwrap_or(1.0);
        let arm = chain.with(detail, &Tolerances { length: same, angle: same, zero: same, encoder: same });
        let arm = Told { free: self.rows("free"), arm, tolerance };
        let mut problem = Problem::new();
        let base = self.numbers("base");
        let arm = problem.arm("arm", arm.parameters_only(), pose(&base), Freedom::FRAME);
        let balls: Vec<TargetId> = self
            .rows("balls")
            .iter()
            .enumerate()
            .map(|(i, ball)| {
                let place = Pose::translation(ball[0], ball[1], ball[2]);
                problem.target(&format!("ball {}", i + 1), Some(arm), place, Freedom::POINT)
            })
            .collect();
        let sigma = self.number("sigma").expect("a sigma");
        let instruments: Vec<InstrumentId> = match self.0["theodolites"].as_array() {
            None => {
                let noise = Noise::Known(vec![sigma; 3]);
                vec![problem.instrument(
                    "tracker",
                    Points::new(),
                    None,
                    Pose::identity(),
                    Freedom::FIXED,
                    noise,
                )]
            }
            Some(places) => places
                .iter()
                .zip([
                    ("south", Freedom::FIXED),
                    ("north", Freedom { free: [false, false, false, true, true, true], ..Freedom::FRAME }),
                ])
                .map(|(place, (name, freedom))| {
                    let noise = Noise::Known(vec![sigma; 2]);
                    problem.instrument(name, Angles::both_faces(), None, pose(&list(place)), freedom, noise)
                })
                .collect(),
        };
        for (q, read) in self.rows("q").iter().zip(self.points("read")) {
            let posture = problem.posture(arm, q);
            for (ball, read) in balls.iter().zip(read) {
                for (instrument, own) in instruments.iter().zip(read.chunks(read.len() / instruments.len())) {
                    problem.measure(*instrument, *ball, &[posture], own);
                }
            }
        }
        Stated { problem, arm, balls }
    }

    fn numbers(&self, key: &str) -> Vec<f64> {
        list(&self.0[key])
    }
}

/// A chain with the tolerances of a case, which may have none, and some of whose zeros are known.
struct Told {
    free: Vec<Vec<f64>>,
    arm: ChainArm,
    tolerance: Option<f64>,
}

impl Told {
    fn parameters_only(self) -> Some6 {
        let all: Vec<Parameter> = self.arm.parameters().to_vec();
        let wanted = |parameter: &Parameter| {
            self.free.len() == 36
                || self.free.iter().any(|free| parameter.name == format!("joint {} zero", free[0] + 1.0))
        };
        let kept: Vec<usize> = (0..all.len()).filter(|i| wanted(&all[*i])).collect();
        let tolerance = self.tolerance;
        let parameters = kept.iter().map(|i| Parameter { tolerance, ..all[*i].clone() }).collect();
        Some6 { arm: self.arm, kept, parameters }
    }
}

/// An arm of which only some parameters are to be found.
struct Some6 {
    arm: ChainArm,
    kept: Vec<usize>,
    parameters: Vec<Parameter>,
}

impl Arm for Some6 {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn joints(&self) -> usize {
        self.arm.joints()
    }

    fn flange(&self, q: &[f64], values: &[f64]) -> Pose {
        self.arm.flange(q, &self.full(values))
    }

    fn linearise(&self, q: &[f64], values: &[f64], twists: &mut [nalgebra::Vector6<f64>]) -> Pose {
        let mut all = vec![nalgebra::Vector6::zeros(); self.arm.parameters().len()];
        let flange = self.arm.linearise(q, &self.full(values), &mut all);
        for (twist, i) in twists.iter_mut().zip(&self.kept) {
            *twist = all[*i];
        }
        flange
    }
}

impl Some6 {
    fn full(&self, values: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.arm.parameters().len()];
        for (i, value) in self.kept.iter().zip(values) {
            full[*i] = *value;
        }
        full
    }
}

fn pose(six: &[f64]) -> Pose {
    Pose::new(Vector3::new(six[0], six[1], six[2]), Vector3::new(six[3], six[4], six[5]))
}

fn list(of: &Value) -> Vec<f64> {
    of.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

fn rows(of: &Value) -> Vec<Vec<f64>> {
    of.as_array().expect("rows").iter().map(list).collect()
}
