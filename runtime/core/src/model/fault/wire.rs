//! A fault as words of a message.

use super::text::Text;
use super::{Fault, FaultKind, ProcessId, Report, Role};
use crate::model::excess::Excess;
use crate::model::instruction::Instruction;
use crate::model::name::Name;
use crate::model::robot_stop::Stopped;
use crate::model::wire::{BadWords, WORDS, Wire};

/// The units that excesses come in; a unit travels as its place in this list.
const UNITS: [&str; 13] =
    ["", "rad", "m", "rad/s", "m/s", "rad/s²", "m/s²", "rad/s³", "m/s³", "step", "A", "N", "N m"];

/// A fault on the wire.
#[derive(Clone, Copy)]
pub struct FaultWords(Report);

impl From<&Fault> for FaultWords {
    fn from(fault: &Fault) -> Self {
        FaultWords(*fault.0)
    }
}

impl From<FaultWords> for Fault {
    fn from(words: FaultWords) -> Self {
        Fault(Box::new(words.0))
    }
}

const NONE: u64 = u64::MAX;

/// The bit beside a text's length that says that the first demand of a motion met the fault.
const FIRST_DEMAND: u64 = 1 << 32;

/// Where beside a text's length it stands what has stopped the robot.
const STOPPED: u32 = 48;

/// The bit beside a text's length that says that the instruction is named in which it happened.
const NAMES_INSTRUCTION: u64 = 1 << 33;

/// Where the instruction stands, behind the text.
const INSTRUCTION: usize = 8 + 3 + 15;

impl Wire for FaultWords {
    const LEN: usize = INSTRUCTION + Instruction::LEN;
    const LAYOUT: u64 = crate::model::wire::layout_hash(0, "fault with its instruction");

    fn put(&self, words: &mut [u64]) {
        let report = &self.0;
        words[0] = report.kind.code();
        words[1] = report.process.map_or(NONE, |process| process.role as u64);
        words[2] = report.joint.map_or(NONE, u64::from);
        words[3] = report.step.unwrap_or(NONE);
        let unit =
            report.excess.map(|excess| UNITS.iter().position(|&u| u == excess.unit).unwrap_or(0) as u64);
        words[4] = unit.unwrap_or(NONE);
        words[5] = report.excess.map_or(0, |excess| excess.actual.to_bits());
        words[6] = report.excess.map_or(0, |excess| excess.limit.to_bits());
        let stopped = report.stopped.map_or(0, Stopped::to_bits);
        let first = if report.first { FIRST_DEMAND } else { 0 };
        let named = if report.instruction.is_some() { NAMES_INSTRUCTION } else { 0 };
        words[7] = u64::from(report.text.len) | first | named | u64::from(stopped) << STOPPED;
        match report.process.and_then(|process| process.name) {
            Some(name) => name.put(&mut words[8..11]),
            None => words[8..11].fill(0),
        }
        match &report.instruction {
            Some(instruction) => instruction.put(&mut words[INSTRUCTION..Self::LEN]),
            None => words[INSTRUCTION..Self::LEN].fill(0),
        }
        for (word, chunk) in words[11..INSTRUCTION].iter_mut().zip(report.text.bytes.chunks_exact(8)) {
            *word = chunk.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
        }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..Self::LEN).ok_or(BadWords)?;
        let some = |word: u64| (word != NONE).then_some(word);
        let role = some(words[1]).map(|word| Role::get(&[word])).transpose()?;
        let process = role.map(|role| ProcessId { role, name: Name::get(&words[8..11]).ok() });
        let excess = match some(words[4]) {
            None => None,
            Some(unit) => Some(Excess {
                actual: f64::from_bits(words[5]),
                limit: f64::from_bits(words[6]),
                unit: UNITS.get(unit as usize).copied().ok_or(BadWords)?,
            }),
        };
        let mut bytes = [0; 120];
        for (chunk, word) in bytes.chunks_exact_mut(8).zip(&words[11..]) {
            chunk.copy_from_slice(&word.to_le_bytes());
        }
        let stopped = match (words[7] >> STOPPED) as u16 {
            0 => None,
            bits => Some(Stopped::from_bits(bits).ok_or(BadWords)?),
        };
        let named = words[7] & NAMES_INSTRUCTION != 0;
        let instruction = named.then(|| Instruction::get(&words[INSTRUCTION..])).transpose()?;
        let len = words[7] & !(FIRST_DEMAND | NAMES_INSTRUCTION) & ((1 << STOPPED) - 1);
        let len = u8::try_from(len).ok().filter(|&len| len <= 120).ok_or(BadWords)?;
        Ok(FaultWords(Report {
            kind: FaultKind::from_code(words[0]).ok_or(BadWords)?,
            process,
            joint: some(words[2]).map(|joint| joint as u32),
            step: some(words[3]),
            instruction,
            excess,
            text: Text { bytes, len },
            stopped,
            first: words[7] & FIRST_DEMAND != 0,
            orderly: false,
        }))
    }
}

const _: () = assert!(FaultWords::LEN <= WORDS, "a fault fits into a message");
