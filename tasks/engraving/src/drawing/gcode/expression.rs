//! Values: numbers, parameters, bracketed expressions and functions, by recursive descent.
//!
//! Precedence from tight to loose, left to right within one (RS274/NGC 3.3.2.3, LinuxCNC's comparisons added):
//! `**`; `* / mod`; `+ -`; `eq ne gt ge lt le`; `and or xor`. Angles in degrees.

use super::characters::Characters;
use super::parameters::{Parameter, Parameters};
use super::stop::{Cause, Stop, malformed};

/// A reader of values on one line.
pub struct Values<'a, 'b> {
    pub line: &'a mut Characters<'b>,
    pub parameters: &'a Parameters,
    /// How many levels of brackets are left.
    pub depth: usize,
    /// How many there were.
    pub limit: usize,
}

impl Values<'_, '_> {
    /// A real value: what may follow a word's letter.
    pub fn value(&mut self) -> Result<f64, Stop> {
        let byte = self.line.byte();
        let value = match self.line.peek() {
            Some('[') => self.bracketed()?,
            Some('#') => self.parameter_value()?,
            Some('+') => {
                self.line.take();
                self.nested(Self::value)?
            }
            Some('-') => {
                self.line.take();
                -self.nested(Self::value)?
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number()?,
            Some(c) if c.is_ascii_alphabetic() => self.function()?,
            Some(c) => {
                return malformed(
                    byte,
                    format!("{c:?} where a number should be"),
                    "write a number or [expression]",
                );
            }
            None => {
                return malformed(
                    byte,
                    "the line ends where a number should be",
                    "write a number after the letter",
                );
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(Stop { byte, cause: Cause::Range("the value".to_owned(), value), line: None })
        }
    }

    fn nested<T>(&mut self, read: impl FnOnce(&mut Self) -> Result<T, Stop>) -> Result<T, Stop> {
        let byte = self.line.byte();
        if self.depth == 0 {
            return Err(Stop { byte, cause: Cause::TooDeep("brackets", self.limit), line: None });
        }
        self.depth -= 1;
        let result = read(self);
        self.depth += 1;
        result
    }

    fn number(&mut self) -> Result<f64, Stop> {
        let byte = self.line.byte();
        let mut digits = String::new();
        while let Some(c) = self.line.peek().filter(|c| c.is_ascii_digit() || *c == '.') {
            digits.push(c);
            self.line.take();
        }
        match digits.parse() {
            Ok(number) => Ok(number),
            Err(_) => {
                malformed(byte, format!("{digits:?} is no number"), "write digits with at most one point")
            }
        }
    }

    /// What follows a `#`, which is taken here.
    pub fn parameter(&mut self) -> Result<Parameter, Stop> {
        let byte = self.line.byte();
        self.line.take();
        if self.line.accept('<') {
            return match self.line.through('>') {
                Some(name) => {
                    let name = name.chars().filter(|c| !c.is_whitespace()).collect::<String>();
                    Ok(Parameter::Named(name.to_ascii_lowercase()))
                }
                None => malformed(byte, "a parameter name without its >", "write #<name>"),
            };
        }
        let index = self.nested(Self::value)?;
        if index.fract() == 0.0 && (1.0..=5602.0).contains(&index) {
            Ok(Parameter::Numbered(index as u32))
        } else {
            malformed(byte, format!("parameter #{index}"), "parameters are #1 to #5602, or #<name>")
        }
    }

    fn parameter_value(&mut self) -> Result<f64, Stop> {
        let byte = self.line.byte();
        let parameter = self.parameter()?;
        match self.parameters.value(&parameter) {
            Some(value) => Ok(value),
            None => malformed(
                byte,
                "a named parameter that was never set here",
                "set it above: #<name> = 1; in a subroutine only names that begin with _ are known from outside: #<_name>",
            ),
        }
    }

    fn function(&mut self) -> Result<f64, Stop> {
        let byte = self.line.byte();
        let name = self.line.name();
        if self.line.peek() != Some('[') {
            return malformed(
                byte,
                format!("{name:?} where a number should be"),
                "write a number or [expression]",
            );
        }
        if name == "exists" {
            return self.exists(byte);
        }
        let x = self.bracketed()?;
        Ok(match name.as_str() {
            "abs" => x.abs(),
            "acos" => x.acos().to_degrees(),
            "asin" => x.asin().to_degrees(),
            "atan" => {
                if !self.line.accept('/') {
                    return malformed(byte, "atan of one value", "write atan[y]/[x]");
                }
                x.atan2(self.bracketed()?).to_degrees()
            }
            "cos" => x.to_radians().cos(),
            "exp" => x.exp(),
            "fix" => x.floor(),
            "fup" => x.ceil(),
            "ln" => x.ln(),
            "round" => x.round(),
            "sin" => x.to_radians().sin(),
            "sqrt" => x.sqrt(),
            "tan" => x.to_radians().tan(),
            _ => {
                return malformed(
                    byte,
                    format!("no function {name:?}"),
                    "known are abs acos asin atan cos exists exp fix fup ln round sin sqrt tan",
                );
            }
        })
    }

    /// What follows EXISTS: a named parameter in brackets; 1 if it has a value, else 0.
    fn exists(&mut self, byte: usize) -> Result<f64, Stop> {
        let named = self.line.accept('[') && self.line.peek() == Some('#');
        let parameter = if named { Some(self.parameter()?) } else { None };
        match parameter {
            Some(parameter @ Parameter::Named(_)) if self.line.accept(']') => {
                Ok(f64::from(u8::from(self.parameters.value(&parameter).is_some())))
            }
            _ => malformed(byte, "EXISTS of what is no named parameter", "write EXISTS[#<name>]"),
        }
    }

    /// An expression in brackets.
    pub fn bracketed(&mut self) -> Result<f64, Stop> {
        let byte = self.line.byte();
        if !self.line.accept('[') {
            return malformed(byte, "a [ is missing", "write [expression]");
        }
        let value = self.nested(|inner| inner.operations(0))?;
        if self.line.accept(']') {
            Ok(value)
        } else {
            malformed(byte, "a [ without its ]", "close the bracket")
        }
    }

    /// Operations that bind at least as tightly as `level`.
    fn operations(&mut self, level: u8) -> Result<f64, Stop> {
        const TIGHTEST: u8 = 4;
        if level > TIGHTEST {
            return self.value();
        }
        let mut left = self.operations(level + 1)?;
        while let Some(operator) = self.operator(level) {
            let right = self.operations(level + 1)?;
            left = operator.apply(left, right);
        }
        Ok(left)
    }

    /// Takes an operator of this level, if one follows.
    fn operator(&mut self, level: u8) -> Option<Operator> {
        let rest = self.line.rest();
        let (name, operator) =
            OPERATORS.iter().filter(|(_, operator)| operator.level() == level).find(|(name, _)| {
                rest.len() >= name.len()
                    && rest.as_bytes()[..name.len()].eq_ignore_ascii_case(name.as_bytes())
            })?;
        // A single * is not the start of **.
        if *name == "*" && rest.starts_with("**") {
            return None;
        }
        for _ in 0..name.len() {
            self.line.take();
        }
        Some(*operator)
    }
}

#[derive(Clone, Copy)]
enum Operator {
    Power,
    Times,
    Over,
    Modulo,
    Plus,
    Minus,
    Equal,
    Unequal,
    Above,
    NotBelow,
    Below,
    NotAbove,
    And,
    Or,
    Either,
}

const OPERATORS: &[(&str, Operator)] = &[
    ("**", Operator::Power),
    ("*", Operator::Times),
    ("/", Operator::Over),
    ("mod", Operator::Modulo),
    ("+", Operator::Plus),
    ("-", Operator::Minus),
    ("eq", Operator::Equal),
    ("ne", Operator::Unequal),
    ("gt", Operator::Above),
    ("ge", Operator::NotBelow),
    ("lt", Operator::Below),
    ("le", Operator::NotAbove),
    ("and", Operator::And),
    ("or", Operator::Or),
    ("xor", Operator::Either),
];

impl Operator {
    fn level(self) -> u8 {
        match self {
            Self::Power => 4,
            Self::Times | Self::Over | Self::Modulo => 3,
            Self::Plus | Self::Minus => 2,
            Self::Equal | Self::Unequal | Self::Above | Self::NotBelow | Self::Below | Self::NotAbove => 1,
            Self::And | Self::Or | Self::Either => 0,
        }
    }

    fn apply(self, a: f64, b: f64) -> f64 {
        let truth = |t: bool| f64::from(u8::from(t));
        match self {
            Self::Power => a.powf(b),
            Self::Times => a * b,
            Self::Over => a / b,
            Self::Modulo => a.rem_euclid(b),
            Self::Plus => a + b,
            Self::Minus => a - b,
            Self::Equal => truth((a - b).abs() < 1e-6),
            Self::Unequal => truth((a - b).abs() >= 1e-6),
            Self::Above => truth(a > b),
            Self::NotBelow => truth(a >= b),
            Self::Below => truth(a < b),
            Self::NotAbove => truth(a <= b),
            Self::And => truth(a != 0.0 && b != 0.0),
            Self::Or => truth(a != 0.0 || b != 0.0),
            Self::Either => truth((a != 0.0) != (b != 0.0)),
        }
    }
}
