//! What the processes of a cell show while it runs: the rate of path time, readings of sensors, inputs and outputs of robots.
//!
//! In: what an observer of the picture is shown, by each process in its order, but by several processes in any order. Out: numbers
//! and states over time, in bounded memory, which do not depend on that order: the rate comes from the MP, inputs and outputs of a
//! robot from its EDP, and readings of several processes are put together step by step ([`Track`]).

use std::sync::{Mutex, MutexGuard, PoisonError};

use mrroc::fault::{Name, ProcessId, Role};
use mrroc::observe::layout::{Layout, RobotLayout, SensorLayout, SignalLayout};
use mrroc::observe::step_observer::{ReadingState, StepEvent, StepObserver, StepRecord};
use mrroc::payload::Wire;
use mrroc::robot::{Channel, Signals};

use crate::quantities::Quantities;
use crate::states::States;
use crate::track::Track;

/// An observer of the run.
#[derive(Debug, Default)]
pub(crate) struct Seen(Mutex<Sights>);

/// What was seen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sights {
    /// The length of a step \[s\].
    pub step: f64,
    /// The rate of path time, 0 to 1; and the speed that the operator wants, as a share of the plan, 0 to 1.
    pub rate: Track,
    pub sensors: Vec<SensorSight>,
    pub robots: Vec<RobotSight>,
}

/// What was seen of a sensor.
#[derive(Clone, Debug)]
pub(crate) struct SensorSight {
    pub name: String,
    pub kind: &'static str,
    /// The robot that it belongs to.
    pub of: Option<String>,
    pub quantities: Quantities,
    /// The numbers of its readings in the order of the quantities, then their states.
    pub readings: Track,
    /// The processes that may read it, the MP first.
    pub readers: Vec<Reader>,
}

/// What a process got of a sensor.
#[derive(Clone, Debug)]
pub(crate) struct Reader {
    pub process: ProcessId,
    /// Steps in which it asked and there was a reading.
    pub read: u64,
    /// Steps in which it asked and there was none.
    pub missed: u64,
    /// The last step in which it asked, and whether there was a reading.
    last: Option<(u64, bool)>,
}

/// What was seen of the inputs and outputs of a robot.
#[derive(Clone, Debug)]
pub(crate) struct RobotSight {
    pub name: String,
    pub digital: Vec<(SignalLayout, States)>,
    pub analog: Vec<SignalLayout>,
    /// The values of the analog ones, in their order.
    pub levels: Track,
}

impl Seen {
    /// A cell is going to run.
    pub fn expect(&self, layout: &Layout) {
        *self.lock() = Sights::of(layout);
    }

    /// What was seen so far.
    pub fn sights(&self) -> Sights {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Sights> {
        // Whatever was seen before a thread panicked is drawn.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl StepObserver for Seen {
    fn see(&self, time: u64, by: ProcessId, what: &StepEvent, words: &[u64]) {
        self.lock().see(time as f64 * 1e-9, by, what, words);
    }
}

impl Sights {
    /// Of a cell that has not run yet.
    pub fn of(layout: &Layout) -> Sights {
        Sights {
            step: layout.step.as_secs_f64(),
            rate: Track::default(),
            sensors: layout.sensors.iter().map(SensorSight::of).collect(),
            robots: layout
                .robots
                .iter()
                .filter(|robot| !robot.signals.is_empty())
                .map(RobotSight::of)
                .collect(),
        }
    }

    /// What was seen of the inputs and outputs of the robot of this name.
    pub fn robot(&self, name: &str) -> Option<&RobotSight> {
        self.robots.iter().find(|robot| robot.name == name)
    }

    /// Something was shown at a time \[s\].
    fn see(&mut self, time: f64, by: ProcessId, what: &StepEvent, words: &[u64]) {
        match what {
            StepEvent::Step(StepRecord { step, dt, duration, speed, .. }) if *duration > 0.0 => {
                self.rate.see(*step, time, &[dt / duration, *speed]);
            }
            StepEvent::Reading { sensor, step, state, .. } => {
                let sensor = self.sensors.iter_mut().find(|known| known.name == sensor.as_str());
                if let Some(sensor) = sensor {
                    sensor.see(time, by, *step, *state, words);
                }
            }
            StepEvent::Signals { step } => {
                let Some(name) = by.name else { return };
                let robot = self.robots.iter_mut().find(|known| known.name == name.as_str());
                if let (Some(robot), Ok(signals)) = (robot, Signals::get(words)) {
                    robot.see(*step, time, &signals);
                }
            }
            _ => {}
        }
    }
}

impl SensorSight {
    fn of(sensor: &SensorLayout) -> SensorSight {
        let ecps = sensor.readers.iter().filter_map(|robot| Name::new(robot).ok());
        let processes = [ProcessId::MP].into_iter().chain(ecps.map(|name| ProcessId::new(Role::Ecp, name)));
        SensorSight {
            name: sensor.name.clone(),
            kind: sensor.kind,
            of: sensor.of.clone(),
            quantities: Quantities::of(sensor.reading),
            readings: Track::with_gaps(),
            readers: processes.map(|process| Reader { process, read: 0, missed: 0, last: None }).collect(),
        }
    }

    /// A process has collected this in a step, which ends at a time \[s\].
    fn see(&mut self, time: f64, by: ProcessId, step: u64, state: ReadingState, words: &[u64]) {
        let is_there = state == ReadingState::There;
        let reader = self.readers.iter_mut().find(|reader| reader.process == by);
        if reader.is_none_or(|reader| !reader.sees(step, is_there)) || !is_there {
            return;
        }
        let numbers = self.quantities.numbers().map(|number| number.value(words));
        let state = |word: &usize| words.get(*word).map_or(f64::NAN, |state| *state as f64);
        let states = self.quantities.choices.iter().map(|choice| state(&choice.word));
        let values: Vec<f64> = numbers.chain(states).collect();
        self.readings.see(step, time, &values);
    }

    /// The states of its readings, in the order of the quantities.
    pub fn states(&self) -> impl Iterator<Item = States> {
        let first = self.quantities.numbers().count();
        (first..first + self.quantities.choices.len()).map(|place| self.readings.states(place))
    }
}

impl Reader {
    /// It asked in a step: whether that is news, because a step may ask twice.
    fn sees(&mut self, step: u64, is_there: bool) -> bool {
        if self.last.is_some_and(|(last, was_there)| last > step || last == step && (was_there || !is_there))
        {
            return false;
        }
        if self.last == Some((step, false)) {
            self.missed -= 1;
        }
        self.last = Some((step, is_there));
        if is_there {
            self.read += 1;
        } else {
            self.missed += 1;
        }
        true
    }
}

impl RobotSight {
    fn of(robot: &RobotLayout) -> RobotSight {
        let (digital, analog): (Vec<_>, Vec<_>) =
            robot.signals.iter().cloned().partition(|signal| matches!(signal.channel, Channel::Digital(_)));
        RobotSight {
            name: robot.name.clone(),
            digital: digital.into_iter().map(|signal| (signal, States::default())).collect(),
            analog,
            levels: Track::default(),
        }
    }

    fn see(&mut self, step: u64, time: f64, signals: &Signals) {
        let values = |signal: &SignalLayout| if signal.is_output { signals.outputs } else { signals.inputs };
        for (signal, states) in &mut self.digital {
            if let Channel::Digital(number) = signal.channel {
                states.see(time, u64::from(values(signal).is_on(number)));
            }
        }
        if !self.analog.is_empty() {
            let level = |signal: &SignalLayout| match signal.channel {
                Channel::Analog(number) => values(signal).analog(number),
                Channel::Digital(_) => f64::NAN,
            };
            let levels: Vec<f64> = self.analog.iter().map(level).collect();
            self.levels.see(step, time, &levels);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::payload::Shape;

    fn ecp() -> ProcessId {
        ProcessId::new(Role::Ecp, Name::new("arm").unwrap())
    }

    fn sensor() -> SensorSight {
        const SHAPE: Shape = Shape::Fields(&[("depth", &Shape::Float), ("is_seen", &Shape::Truth)]);
        SensorSight::of(&SensorLayout {
            name: "eye".to_owned(),
            kind: "eye",
            of: None,
            readers: vec!["arm".to_owned()],
            every: 1,
            stale_after: std::time::Duration::from_millis(40),
            mode: mrroc::sensor::VspMode::Interactive,
            latency: std::time::Duration::ZERO,
            reading: &SHAPE,
            reading_layout: 0,
            hardware: mrroc::observe::layout::HardwareLayout::Nothing,
        })
    }

    /// The MP reads in steps 1 to 3, the ECP in steps 2 and 3; the MP finds nothing in step 4; nobody asks in steps 6 to 8.
    fn shown() -> [Vec<(ProcessId, u32, ReadingState)>; 2] {
        use ReadingState::{Lost, None, There};
        let mp =
            [(1, None), (1, There), (2, There), (2, There), (3, There), (4, Lost), (5, There), (9, There)];
        let ecp_s = [(2, None), (2, There), (3, There)];
        [
            mp.map(|(step, state)| (ProcessId::MP, step, state)).to_vec(),
            ecp_s.map(|(step, state)| (ecp(), step, state)).to_vec(),
        ]
    }

    fn seen(shown: impl Iterator<Item = (ProcessId, u32, ReadingState)>) -> SensorSight {
        let mut sensor = sensor();
        for (by, step, state) in shown {
            let time = f64::from(step) + if by == ProcessId::MP { 0.0 } else { 0.25 };
            let words = [f64::from(step).to_bits(), u64::from(step > 2)];
            sensor.see(time, by, u64::from(step), state, &words);
        }
        sensor
    }

    #[test]
    fn a_curve_has_gaps_where_there_was_no_reading_and_where_nobody_asked() {
        let [mp, _] = shown();
        let sensor = seen(mp.into_iter());
        let lines = sensor.readings.lines(&[0]);
        let drawn: Vec<_> = lines.values[0].iter().map(|x| x.is_finite().then_some(*x)).collect();
        assert_eq!(drawn, [Some(1.0), Some(2.0), Some(3.0), None, Some(5.0), None, Some(9.0)]);
        assert_eq!((sensor.readers[0].read, sensor.readers[0].missed), (5, 1));
        let states = sensor.states().next().unwrap();
        let on = states.spells().iter().filter(|spell| spell.state == Some(1)).count();
        assert_eq!(on, 3, "each gap ends a spell");
    }

    #[test]
    fn of_two_processes_it_does_not_matter_who_is_heard_first() {
        let [mp, ecp] = shown();
        let drawn = |sensor: &SensorSight| {
            let lines = sensor.readings.lines(&[0]);
            let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let counts: Vec<_> = sensor.readers.iter().map(|reader| (reader.read, reader.missed)).collect();
            let spells = sensor.states().next().unwrap().spells().to_vec();
            (bits(&lines.times), bits(&lines.values[0]), spells, counts)
        };
        let mp_first = drawn(&seen(mp.iter().chain(&ecp).copied()));
        let ecp_first = drawn(&seen(ecp.iter().chain(&mp).copied()));
        let mut in_turn = [mp, ecp].concat();
        in_turn.sort_by_key(|(_, step, _)| *step);
        assert_eq!(mp_first, ecp_first);
        assert_eq!(mp_first, drawn(&seen(in_turn.into_iter())));
        assert_eq!(mp_first.3, [(5, 1), (2, 0)]);
    }
}
