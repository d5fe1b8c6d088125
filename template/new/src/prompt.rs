//! Asks on the terminal, by the same prompts as cargo-generate.
//!
//! Not left to cargo-generate because it makes the project's folder first and asks then: who breaks off at a
//! question finds an empty folder.

use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use dialoguer::console::Term;
use dialoguer::theme::ColorfulTheme;
use dialoguer::{Confirm, Input, MultiSelect, Select};
use signal_hook::consts::SIGINT;

use crate::error::Error;
use crate::template::{Choice, Kind, Placeholder, Value};

/// Whether somebody can be asked.
#[must_use]
pub fn somebody_is_there() -> bool {
    io::stdin().is_terminal() && io::stderr().is_terminal()
}

/// Asks for one choice.
///
/// # Errors
/// The terminal gives no answer.
pub fn ask(placeholder: &Placeholder) -> Result<Value, Error> {
    // Caught, so that who breaks off by Ctrl-C gets the cursor back, which a question hides. The flag is of no use: the
    // question itself ends with an error.
    let _ = signal_hook::flag::register(SIGINT, Arc::new(AtomicBool::new(false)));
    answer(placeholder).map_err(|dialoguer::Error::IO(error)| {
        let _ = Term::stderr().show_cursor();
        let what = format!("{} was not chosen: {error}", placeholder.name);
        Error::failed(what, "take all defaults by `--defaults`, or choose by `--define name=value`")
    })
}

fn answer(placeholder: &Placeholder) -> dialoguer::Result<Value> {
    let theme = ColorfulTheme::default();
    let is_default = |choice: &Choice| match &placeholder.default {
        Some(Value::Text(text)) => *text == choice.value,
        Some(Value::List(list)) => list.contains(&choice.value),
        Some(Value::Bool(_)) | None => false,
    };
    let labels = |choices: &[Choice]| choices.iter().map(|choice| choice.label.clone()).collect::<Vec<_>>();
    Ok(match &placeholder.kind {
        Kind::YesNo => Value::Bool(
            Confirm::with_theme(&theme)
                .with_prompt(&placeholder.prompt)
                .default(placeholder.default == Some(Value::Bool(true)))
                .interact()?,
        ),
        Kind::OneOf(choices) => {
            let chosen = Select::with_theme(&theme)
                .with_prompt(&placeholder.prompt)
                .items(labels(choices))
                .default(choices.iter().position(is_default).unwrap_or(0))
                .interact()?;
            Value::Text(choices[chosen].value.clone())
        }
        Kind::AnyOf(choices) => {
            let chosen = MultiSelect::with_theme(&theme)
                .with_prompt(format!("{} (blank selects)", placeholder.prompt))
                .items(labels(choices))
                .defaults(&choices.iter().map(is_default).collect::<Vec<_>>())
                .interact()?;
            Value::List(chosen.into_iter().map(|i| choices[i].value.clone()).collect())
        }
        Kind::Text(_) => {
            let input = Input::<String>::with_theme(&theme).with_prompt(&placeholder.prompt);
            let input = match &placeholder.default {
                Some(default) => input.default(default.to_string()),
                None => input,
            };
            let valid = |text: &String| match placeholder.read(text) {
                Ok(_) => Ok(()),
                Err(Error::Refused { help, .. } | Error::Failed { help, .. } | Error::Usage(help)) => {
                    Err(help)
                }
            };
            Value::Text(input.validate_with(valid).interact_text()?)
        }
    })
}
