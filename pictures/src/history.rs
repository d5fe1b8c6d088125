//! What is kept of one robot's servo periods, in bounded memory.
//!
//! In: an observation per servo period. Out: at most [`CAPACITY`] samples, evenly spaced, and the last one; ranges and
//! largest following errors of all periods. A full history drops every other sample and from then on keeps half as many.

use mrroc::observe::Observation;
use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::Vector3;

use crate::instructions::Log;
use crate::sample::Sample;
use crate::speed::Speeds;
use crate::svg::Range;

/// The most samples kept, besides the last.
pub(crate) const CAPACITY: usize = 4000;

/// Travel of a measured joint [rad or m] up to which it stands still: a regulator plays about its encoder's pulses.
const STILL: f64 = 2e-4;

/// What one joint did in all servo periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointRange {
    /// Least and largest position measured [rad or m].
    pub measured: Range,
    /// Least and largest position demanded [rad or m].
    pub demanded: Range,
    /// Largest difference of demanded and measured position [rad or m], at least 0.
    pub following_error: f64,
    /// Largest speed measured [rad/s or m/s], at least 0.
    pub speed: f64,
}

impl JointRange {
    const NONE: JointRange =
        JointRange { measured: Range::NOTHING, demanded: Range::NOTHING, following_error: 0.0, speed: 0.0 };

    fn include(&mut self, demanded: f64, measured: f64) {
        self.measured = self.measured.with(measured);
        self.demanded = self.demanded.with(demanded);
        self.following_error = self.following_error.max((demanded - measured).abs());
    }

    /// From the least to the largest position measured [rad or m].
    pub fn travel(&self) -> f64 {
        self.measured.width().max(0.0)
    }

    /// Whether the joint moved, or should have.
    pub fn moved(&self) -> bool {
        self.travel() > STILL || self.demanded.width() > 1e-6
    }
}

/// The length of a tool's path, in steps that are longer than an encoder's play.
#[derive(Clone, Copy, Debug, Default)]
struct PathLength {
    sum: f64,
    last: Option<Vector3<f64>>,
}

impl PathLength {
    /// Shortest step \[m\].
    const STEP: f64 = 1e-4;

    /// The tool is now at `point` \[m\].
    fn extend_to(&mut self, point: Vector3<f64>) {
        let step = self.last.map_or(f64::INFINITY, |last| (point - last).norm());
        if step >= PathLength::STEP {
            self.sum += if self.last.is_some() { step } else { 0.0 };
            self.last = Some(point);
        }
    }
}

/// What is kept of one robot.
#[derive(Clone, Debug)]
pub(crate) struct History {
    /// The robot's name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// What kind each joint is.
    pub joints: Vec<JointKind>,
    /// Whether it is mounted on another robot, and not on the floor.
    pub is_mounted: bool,
    /// What each joint did in all periods.
    pub ranges: Vec<JointRange>,
    /// Servo periods left out because something in them was not a finite number.
    pub not_finite: u64,
    /// The largest speed of the tool [m/s], at least 0.
    pub tool_speed: f64,
    /// What the program of its ECP did.
    pub program: Log,
    speeds: Speeds,
    path: PathLength,
    /// Every `stride`th sample.
    kept: Vec<Sample>,
    /// The last sample, unless it is kept.
    last: Option<Sample>,
    stride: u64,
    /// Samples of finite numbers so far.
    count: u64,
}

impl History {
    /// Of a robot that has not been observed yet.
    pub fn new(name: &str, kind: &'static str, joints: &[JointKind]) -> History {
        History {
            name: name.to_owned(),
            kind,
            joints: joints.to_vec(),
            is_mounted: false,
            ranges: vec![JointRange::NONE; joints.len()],
            not_finite: 0,
            tool_speed: 0.0,
            program: Log::default(),
            speeds: Speeds::default(),
            path: PathLength::default(),
            kept: Vec::new(),
            last: None,
            stride: 1,
            count: 0,
        }
    }

    /// The robot was observed at the end of a servo period; what it is mounted on stands at `X_WM`. The pose of its flange.
    #[allow(non_snake_case)]
    pub fn observe(&mut self, observation: &Observation<'_>, X_WM: &Pose) -> Pose {
        self.is_mounted = observation.mounted_on.is_some();
        self.program.observe(observation.time, &observation.ecp());
        let mut links = Vec::with_capacity(8);
        let (mut flange, mut tool) = (Pose::identity(), Pose::identity());
        observation.frames(&mut |frame| {
            flange = tool;
            tool = X_WM * frame;
            links.push(tool.translation.vector);
        });
        // The last frame is the tool's.
        links.pop();
        self.add(Sample {
            time: observation.time,
            demanded: observation.demanded.to_vec(),
            measured: observation.measured.to_vec(),
            links,
            tool,
            rates: None,
        });
        flange
    }

    /// The next sample; its rates are found here.
    pub fn add(&mut self, mut sample: Sample) {
        if !sample.is_finite() {
            self.not_finite += 1;
            return;
        }
        for (range, (demanded, measured)) in
            self.ranges.iter_mut().zip(sample.demanded.iter().zip(&sample.measured))
        {
            range.include(*demanded, *measured);
        }
        sample.rates = self.speeds.next(&sample);
        if let Some(rates) = &sample.rates {
            for (range, speed) in self.ranges.iter_mut().zip(&rates.measured) {
                range.speed = range.speed.max(speed.abs());
            }
            self.tool_speed = self.tool_speed.max(rates.tool);
        }
        self.path.extend_to(sample.tool.translation.vector);
        let due = self.count.is_multiple_of(self.stride);
        self.count += 1;
        if !due {
            self.last = Some(sample);
            return;
        }
        self.last = None;
        self.kept.push(sample);
        if self.kept.len() > CAPACITY {
            let mut index = 0_usize;
            self.kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
        }
    }

    /// The samples kept, in order of time, to the last servo period; empty when there was none.
    pub fn samples(&self) -> Vec<&Sample> {
        let mut samples: Vec<&Sample> = Vec::with_capacity(self.kept.len() + 1);
        for sample in self.kept.iter().chain(&self.last) {
            // Time goes forwards: a sample that is not later is left out.
            if samples.last().is_none_or(|before| before.time < sample.time) {
                samples.push(sample);
            }
        }
        samples
    }

    /// Length of the tool's path in all servo periods \[m\].
    pub fn path_length(&self) -> f64 {
        self.path.sum
    }

    /// Whether any joint moved, or should have.
    pub fn moved(&self) -> bool {
        self.ranges.iter().any(JointRange::moved)
    }

    /// The largest following error of all joints of this kind [rad or m] with its joint, from 0.
    pub fn largest_following_error(&self, kind: JointKind) -> Option<(usize, f64)> {
        let errors = self.ranges.iter().map(|range| range.following_error).enumerate();
        errors.filter(|(joint, _)| self.joints.get(*joint) == Some(&kind)).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A slide along x with its flange at `x` \[m\].
    pub(crate) fn slide(time: f64, demanded: f64, x: f64) -> Sample {
        Sample {
            time,
            demanded: vec![demanded],
            measured: vec![x],
            links: vec![Vector3::zeros(), Vector3::new(x, 0.0, 0.5)],
            tool: Pose::translation(x, 0.0, 0.5),
            rates: None,
        }
    }

    #[test]
    fn a_history_stays_bounded_and_keeps_the_first_the_last_and_every_peak() {
        let mut history = History::new("slide", "slide", &[JointKind::Prismatic]);
        let periods = 1_000_003_u32;
        for i in 0..periods {
            let time = f64::from(i) * 1e-3;
            // One period of all has a following error of 0.3 m.
            let error = if i == 123_457 { 0.3 } else { 0.001 };
            history.add(slide(time, time.sin() + error, time.sin()));
        }
        let samples = history.samples();
        assert!(samples.len() <= CAPACITY + 1 && samples.len() > CAPACITY / 2 - 1, "{}", samples.len());
        assert!(samples[0].time.abs() < 1e-12);
        assert!((samples[samples.len() - 1].time - f64::from(periods - 1) * 1e-3).abs() < 1e-9);
        // Evenly spaced, but for the last.
        let gap = samples[1].time - samples[0].time;
        assert!(samples[..samples.len() - 1].windows(2).all(|w| (w[1].time - w[0].time - gap).abs() < 1e-9));
        let (joint, worst) = history.largest_following_error(JointKind::Prismatic).unwrap();
        assert_eq!(joint, 0);
        assert!((worst - 0.3).abs() < 1e-12);
        assert_eq!(history.largest_following_error(JointKind::Revolute), None);
        // A sine of 1 m and 1 rad/s: 1 m/s at most, and 2 / pi m/s in the mean.
        assert!((history.tool_speed - 1.0).abs() < 1e-4 && (history.ranges[0].speed - 1.0).abs() < 1e-4);
        assert!(
            (history.path_length() / (f64::from(periods) * 1e-3) - 2.0 / std::f64::consts::PI).abs() < 1e-3
        );
    }

    #[test]
    fn what_is_not_a_number_is_left_out_and_counted() {
        let mut history = History::new("slide", "slide", &[JointKind::Prismatic]);
        history.add(slide(0.0, 0.0, 0.0));
        history.add(slide(0.001, f64::NAN, 0.0));
        history.add(slide(f64::INFINITY, 0.0, 0.0));
        assert_eq!((history.samples().len(), history.not_finite), (1, 2));
        assert!(!history.moved());
    }
}
