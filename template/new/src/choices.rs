//! Which choices are asked for, and what was chosen: cargo-generate's own order, before it starts.

use std::collections::BTreeMap;

use rhai::{Dynamic, Engine};

use crate::error::Error;
use crate::suggestion;
use crate::template::{Placeholder, Template, Value};

/// What was given by `--define`.
pub type Given = BTreeMap<String, String>;

/// What was chosen, in the order in which it was asked for.
pub type Chosen = Vec<(String, Value)>;

/// Settles every choice: by what was given, otherwise by `ask`. A choice that depends on others is asked for
/// once they say so.
///
/// # Errors
/// [`Error::Refused`] for a name or a value that there is not, before anything is asked; and for a choice that is
/// not there beside the others. Whatever `ask` returns.
pub fn settle(
    template: &Template,
    given: &Given,
    mut ask: impl FnMut(&Placeholder) -> Result<Value, Error>,
) -> Result<Chosen, Error> {
    for (name, value) in given {
        check(template, name, value)?;
    }
    let mut chosen = Chosen::new();
    let mut open: Vec<&Placeholder> = template.placeholders.iter().collect();
    let mut conditionals: Vec<_> = template.conditionals.iter().collect();
    while !open.is_empty() {
        for placeholder in open.drain(..) {
            if chosen.iter().any(|(name, _)| *name == placeholder.name) {
                continue;
            }
            let value = match given.get(&placeholder.name) {
                Some(text) => placeholder.read(text)?,
                None => ask(placeholder)?,
            };
            chosen.push((placeholder.name.clone(), value));
        }
        conditionals.retain(|conditional| {
            let holds = holds(&conditional.when, &chosen);
            if holds {
                open.extend(&conditional.placeholders);
            }
            !holds
        });
    }
    match given.keys().find(|name| !chosen.iter().any(|(chosen, _)| chosen == *name)) {
        None => Ok(chosen),
        Some(name) => Err(out_of_place(template, name, &chosen)),
    }
}

/// Refuses a name that there is not, and a value that nobody could choose.
fn check(template: &Template, name: &str, value: &str) -> Result<(), Error> {
    let mut refused = None;
    for (placeholder, _) in template.all().filter(|(placeholder, _)| placeholder.name == name) {
        match placeholder.read(value) {
            Ok(_) => return Ok(()),
            Err(error) => refused = Some(error),
        }
    }
    Err(refused.unwrap_or_else(|| {
        let names = template.all().map(|(placeholder, _)| placeholder.name.as_str()).collect::<Vec<_>>();
        let help = suggestion::help(name, "there are", names.iter().copied());
        Error::refused(format!("there is no choice `{name}`"), help)
    }))
}

fn out_of_place(template: &Template, name: &str, chosen: &Chosen) -> Error {
    let conditions = template.all().filter(|(placeholder, _)| placeholder.name == name);
    let conditions: Vec<_> = conditions.filter_map(|(_, when)| when).collect();
    let others: Vec<_> = chosen
        .iter()
        .filter(|(other, _)| conditions.iter().any(|when| mentions(when, other)))
        .map(|(other, value)| format!("{other} is `{value}`"))
        .collect();
    let what =
        format!("{name} can be chosen only when `{}`; {}", conditions.join("` or `"), others.join(", "));
    Error::refused(what, format!("leave out `--define {name}=..`, or choose the other accordingly"))
}

/// Whether a name stands in an expression as a word of its own.
fn mentions(expression: &str, name: &str) -> bool {
    expression.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|word| word == name)
}

/// Whether a condition holds. One that cannot be evaluated does not, as in cargo-generate.
fn holds(condition: &str, chosen: &Chosen) -> bool {
    let variables: BTreeMap<String, Dynamic> =
        chosen.iter().map(|(name, value)| (name.clone(), dynamic(value))).collect();
    let mut engine = Engine::new();
    // Volatile in Rhai's interface, but this is how cargo-generate gives a condition its variables.
    #[allow(deprecated)]
    engine.on_var(move |name, _, _| Ok(variables.get(name).cloned()));
    engine.eval_expression::<bool>(condition).unwrap_or(false)
}

fn dynamic(value: &Value) -> Dynamic {
    match value {
        Value::Text(text) => text.clone().into(),
        Value::Bool(yes) => (*yes).into(),
        Value::List(list) => list.iter().cloned().map(Dynamic::from).collect::<Vec<_>>().into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn template() -> Template {
        Template::read(
            r#"
            [placeholders.arms]
            prompt = "How many?"
            choices = ["one", { value = "two", label = "a pair" }]
            default = "one"
            [placeholders.sensors]
            type = "array"
            prompt = "Which?"
            choices = ["force", "probe"]
            default = []
            [placeholders.period]
            prompt = "How long?"
            regex = "^[124]$"
            default = "2"
            [conditional.'arms == "two"'.placeholders.tight]
            type = "bool"
            prompt = "Tight?"
            default = false
            [conditional.'sensors.contains("probe") && tight'.placeholders.distance]
            prompt = "How far?"
            "#,
        )
        .expect("a description")
    }

    fn settled(given: &[(&str, &str)]) -> Result<String, String> {
        let given = given.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
        let chosen = settle(&template(), &given, Placeholder::default).map_err(|error| error.to_string())?;
        Ok(chosen.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn choices_are_asked_for_when_others_say_so() {
        assert_eq!(settled(&[]).as_deref(), Ok("arms=one sensors= period=2"));
        assert_eq!(
            settled(&[("arms", "two"), ("tight", "yes"), ("sensors", "probe,force"), ("distance", "a b")])
                .as_deref(),
            Ok("arms=two sensors=probe,force period=2 tight=true distance=a b")
        );
    }

    #[test]
    fn what_cannot_be_chosen_is_refused_with_what_can() {
        for (given, parts) in [
            (("arm", "two"), ["no choice `arm`", "did you mean `arms`? there are: `arms`, `sensors`"]),
            (("arms", "tow"), ["arms cannot be `tow`", "did you mean `two`? it can be: `one`, `two`"]),
            (("period", "3"), ["period cannot be `3`", "of the form `^[124]$`, such as `2`"]),
            (("sensors", "force,prob"), ["sensors cannot be", "did you mean `probe`?"]),
            (("tight", "maybe"), ["tight cannot be", "`true`, `false`"]),
            (
                ("tight", "true"),
                ["only when `arms == \"two\"`; arms is `one`", "leave out `--define tight=..`"],
            ),
        ] {
            let error = settled(&[given]).expect_err(given.1);
            assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        }
        let error =
            settled(&[("arms", "two"), ("tight", "true"), ("sensors", "probe")]).expect_err("no default");
        assert!(error.contains("give it by `--define distance=..`"), "{error}");
    }

    #[test]
    fn the_list_of_choices_shows_values_defaults_and_conditions() {
        let text = template().to_string();
        for line in [
            "arms: How many?",
            "  one [default]",
            "  two  a pair",
            "  any of these, with commas between",
            "  a text of the form ^[124]$ [default: 2]",
            "tight: Tight?",
            "  only when arms == \"two\"",
            "  false [default]",
        ] {
            assert!(text.lines().any(|found| found == line), "{line} is not in\n{text}");
        }
    }
}
