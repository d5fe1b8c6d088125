//! What `--check` prints: the cell as a table.
//!
//! In: the layout of the cell. Out: text: its processes with their periods, priorities and cores; its robots with the
//! limits of each joint and how long a stop takes, `T_stop = T_detect + T_brake`; its obstacles; its sensors.

use core::fmt::{self, Display};
use std::time::Duration;

use mrroc_core::cell::Cell;
use mrroc_core::cell::{Permission, Realtime};
use mrroc_core::console::quoted;
use mrroc_core::fault::Name;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::observe::Recording;
use mrroc_core::observe::layout::{
    HardwareLayout, JointLayout, Layout, RobotLayout, SensorLayout, SignalLayout,
};
use mrroc_core::observe::solid::ObstacleLayout;
use mrroc_core::robot::InterpolationSpace;
use mrroc_core::sensor::VspMode;

/// A cell as a table.
pub(super) struct Table<'a> {
    layout: Layout,
    realtime: Option<&'a Realtime>,
    recording: Option<&'a Recording>,
    dry_run: bool,
    /// The link on which the cell runs.
    link: &'static str,
}

impl Table<'_> {
    pub fn of<'a>(cell: &'a Cell, link: &'static str) -> Table<'a> {
        let (realtime, recording) = (cell.realtime(), cell.recording());
        Table { layout: cell.layout(), realtime, recording, dry_run: cell.demands_dry_run(), link }
    }

    fn about(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Layout { step, stop_time, detection, .. } = &self.layout;
        let (step, stop, detection) = (ms(*step), ms(*stop_time), detection * 1e3);
        writeln!(f, "step {step}, stops within {stop}, a lost peer is noticed after {detection:.0} ms")?;
        let (path, protective) = (self.layout.path_stop, self.layout.protective_stop);
        writeln!(
            f,
            "suspend and abort keep the path and take up to {}; a protective stop leaves it after {}",
            ms(path),
            ms(protective)
        )?;
        writeln!(f, "link: {}{}", self.link, if self.dry_run { ", after a dry run" } else { "" })?;
        match self.realtime {
            None => writeln!(f, "real time: nothing is asked of the machine")?,
            Some(realtime) => {
                let memory = if realtime.lock_memory { "memory locked" } else { "memory not locked" };
                let permission = match realtime.permission {
                    Permission::Required => "required",
                    Permission::BestEffort => "best effort",
                };
                writeln!(f, "real time: SCHED_FIFO {}, {memory}, {permission}", realtime.priority)?;
            }
        }
        match self.recording {
            None => writeln!(f, "recording: none"),
            Some(recording) => writeln!(f, "recording: {recording}"),
        }
    }

    fn processes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n{:<30}{:<16}{:>10}{:>10}{:>8}", "process", "program", "period", "priority", "core")?;
        let own = |own: bool, other: &'static str| if own { "its own" } else { other };
        let step = ms(self.layout.step);
        let mut row = |process: String, program: &str, period: &str, id: ProcessId| {
            let (priority, core) = self.placed(id);
            writeln!(f, "{process:<30}{program:<16}{period:>10}{priority:>10}{core:>8}")
        };
        row("mp".to_owned(), own(self.layout.mp_program, "triggering"), &step, ProcessId::MP)?;
        for (name, step) in &self.layout.cells {
            let id = ProcessId { name: Name::of_process(name).ok(), ..ProcessId::MP };
            row(format!("mp {name}"), "its own", &ms(*step), id)?;
        }
        for robot in &self.layout.robots {
            let id =
                |role| Name::of_process(&robot.name).map_or(ProcessId::MP, |name| ProcessId::new(role, name));
            let (ecp, edp) = (format!("ecp {}", robot.name), format!("edp {}", robot.name));
            row(ecp, own(robot.ecp_program, "transparent"), &step, id(Role::Ecp))?;
            row(edp, robot.kind, &ms(robot.servo), id(Role::Edp))?;
        }
        for sensor in &self.layout.sensors {
            let id =
                Name::of_process(&sensor.name).map_or(ProcessId::MP, |name| ProcessId::new(Role::Vsp, name));
            let period = match sensor.mode {
                VspMode::NonInteractive(period) => ms(period),
                VspMode::Interactive | VspMode::WithDelay => "-".to_owned(),
            };
            row(format!("vsp {}", sensor.name), sensor.kind, &period, id)?;
        }
        Ok(())
    }

    /// The priority and the core of a process, as text.
    fn placed(&self, process: ProcessId) -> (String, String) {
        let Some(realtime) = self.realtime else { return ("-".to_owned(), "-".to_owned()) };
        let names = self.layout.robots.iter().filter_map(|robot| Name::of_process(&robot.name).ok());
        let ecps: Vec<_> = names.map(|name| ProcessId::new(Role::Ecp, name)).collect();
        let core = match &realtime.cores {
            Some(cores) => {
                realtime.core(process, &ecps, cores).map_or("any".to_owned(), |core| core.to_string())
            }
            None if matches!(process.role, Role::Ecp | Role::Edp) => "in turn".to_owned(),
            None => "any".to_owned(),
        };
        (realtime.priority.to_string(), core)
    }

    fn robot(&self, robot: &RobotLayout, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let space = match robot.space {
            InterpolationSpace::Joints => "joints",
            InterpolationSpace::Task => "the task space",
        };
        let homed = if robot.homed { "knows where it is" } else { "looks for its reference marks first" };
        let mounted =
            robot.mounted_on.as_ref().map(|on| format!(", on the flange of {on}")).unwrap_or_default();
        writeln!(f, "\n{}: {}{mounted}, {homed}, interpolates in {space}", robot.name, robot.kind)?;
        match &robot.drives {
            HardwareLayout::Real(hardware) => {
                let hardware = quoted(hardware, 120);
                writeln!(
                    f,
                    "real drives, {hardware}: not opened; a dry run takes simulated ones in their place"
                )?;
            }
            HardwareLayout::Simulator(simulator) => {
                let simulator = quoted(simulator, 120);
                writeln!(f, "{simulator}: not opened; a dry run takes its own simulated drives")?;
            }
            HardwareLayout::StandIn(hardware) => {
                writeln!(f, "simulated drives in place of {}", quoted(hardware, 120))?;
            }
            HardwareLayout::Nothing => {}
        }
        writeln!(
            f,
            "{:<9}{:>10}{:>10}{:>10}{:>14}{:>10}{:>11}{:>9}{:>9}{:>9}",
            "joint",
            "lower",
            "upper",
            "velocity",
            "acceleration",
            "jerk",
            "following",
            "T_brake",
            "T_stop",
            "limit"
        )?;
        robot
            .joints
            .iter()
            .enumerate()
            .try_for_each(|(i, joint)| self.joint(i, joint, robot.stop_time, f))?;
        robot.coupled_limits.iter().try_for_each(|limit| writeln!(f, "{limit}"))?;
        robot.signals.iter().try_for_each(|SignalLayout { name, channel, is_output, note }| {
            let direction = if *is_output { "output" } else { "input" };
            let channel = channel.to_string();
            writeln!(f, "{}", format!("{direction:<9}{name:<26}{channel:<14}{note}").trim_end())
        })
    }

    fn joint(
        &self,
        i: usize,
        joint: &JointLayout,
        limit: Duration,
        f: &mut fmt::Formatter<'_>,
    ) -> fmt::Result {
        let JointLayout { lower, upper, velocity, acceleration, following_error, braking, .. } = joint;
        let jerk = joint.jerk.map_or_else(|| "-".to_owned(), |jerk| format!("{jerk:.1}"));
        let name = format!("{} {}", i + 1, joint.kind.unit(0));
        let (stop, limit) = (self.layout.detection + braking, limit.as_secs_f64());
        writeln!(
            f,
            "{name:<9}{lower:>10.4}{upper:>10.4}{velocity:>10.4}{acceleration:>14.4}{jerk:>10}{following_error:>11.4}{:>9}{:>9}{:>9}",
            seconds(*braking),
            seconds(stop),
            seconds(limit)
        )
    }

    fn sensor(sensor: &SensorLayout, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SensorLayout { name, kind, latency, stale_after, every, .. } = sensor;
        let of = sensor.of.as_deref().unwrap_or("-");
        let readers = if sensor.readers.is_empty() { "-".to_owned() } else { sensor.readers.join(", ") };
        let mode = match sensor.mode {
            VspMode::Interactive => "interactive",
            VspMode::WithDelay => "with delay",
            VspMode::NonInteractive(_) => "free running",
        };
        let every = if *every == 1 { "step".to_owned() } else { format!("{every} steps") };
        writeln!(
            f,
            "{name:<26}{kind:<16}{of:<18}{readers:<18}{mode:<14}{every:>9}{:>9}{:>12}",
            ms(*latency),
            ms(*stale_after)
        )?;
        match &sensor.hardware {
            HardwareLayout::Real(hardware) | HardwareLayout::Simulator(hardware) => {
                let hardware = quoted(hardware, 120);
                writeln!(f, "  reads {hardware}: not opened; a dry run takes a simulated sensor in its place")
            }
            HardwareLayout::StandIn(hardware) => {
                writeln!(f, "  a simulated sensor in place of {}", quoted(hardware, 120))
            }
            HardwareLayout::Nothing => Ok(()),
        }
    }
}

impl Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.about(f)?;
        self.processes(f)?;
        self.layout.robots.iter().try_for_each(|robot| self.robot(robot, f))?;
        if !self.layout.obstacles.is_empty() {
            writeln!(f, "\n{:<26}{:<30}shape", "obstacle", "at [m]")?;
        }
        for ObstacleLayout { name, pose, solid } in &self.layout.obstacles {
            let [x, y, z]: [f64; 3] = pose.translation.vector.into();
            let at = format!("{x:.4}, {y:.4}, {z:.4}");
            writeln!(f, "{name:<26}{at:<30}{solid}")?;
        }
        if self.layout.sensors.is_empty() {
            return Ok(());
        }
        writeln!(
            f,
            "\n{:<26}{:<16}{:<18}{:<18}{:<14}{:>9}{:>9}{:>12}",
            "sensor", "kind", "of", "read by ECP of", "mode", "every", "latency", "stale after"
        )?;
        self.layout.sensors.iter().try_for_each(|sensor| Table::sensor(sensor, f))
    }
}

fn ms(time: Duration) -> String {
    format!("{} ms", time.as_nanos() as f64 * 1e-6)
}

fn seconds(time: f64) -> String {
    format!("{time:.3} s")
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::observe::solid::Solid;
    use mrroc_core::pose::Pose;

    #[test]
    fn obstacles_are_listed_with_their_places_and_shapes() {
        let cell = Cell::new(Duration::from_millis(2))
            .shows_obstacle(
                "bench",
                Pose::translation(0.4, 0.0, -0.025),
                Solid::Box { edges: [1.2, 0.8, 0.05] },
            )
            .shows_obstacle("floor", Pose::identity(), Solid::HalfSpace);
        let table = Table::of(&cell, "memory").to_string();
        let rows = "\nobstacle                  at [m]                        shape\n\
                    bench                     0.4000, 0.0000, -0.0250       box, 1.2 x 0.8 x 0.05 m\n\
                    floor                     0.0000, 0.0000, 0.0000        half space\n";
        assert!(table.contains(rows), "{table}");
    }
}
