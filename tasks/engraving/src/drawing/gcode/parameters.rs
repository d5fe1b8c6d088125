//! Parameters `#1` to `#5602` and `#<name>`.

use std::collections::HashMap;

/// What a `#` names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Parameter {
    /// `#n`.
    Numbered(u32),
    /// `#<name>`, in lower case without blanks.
    Named(String),
}

/// The parameters' values: a numbered one that was never set is 0, as on the machine; a named one is an error.
#[derive(Debug, Default)]
pub struct Parameters {
    values: HashMap<Parameter, f64>,
}

impl Parameters {
    /// The value, if it has one.
    pub fn value(&self, parameter: &Parameter) -> Option<f64> {
        let unset = match parameter {
            Parameter::Numbered(_) => Some(0.0),
            Parameter::Named(_) => None,
        };
        self.values.get(parameter).copied().or(unset)
    }

    /// Gives the parameter a value.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        self.values.insert(parameter, value);
    }
}
