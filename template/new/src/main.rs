//! Makes a new mrroc project: `cargo run -p mrroc-new -- my-task`.

use std::env;
use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use mrroc_new::choices::settle;
use mrroc_new::error::Error;
use mrroc_new::generator::{self, Copy};
use mrroc_new::options::{Project, Request, Rest, parse};
use mrroc_new::project::{GENERATION, generate, make, place};
use mrroc_new::template::{Placeholder, Template};
use mrroc_new::{external, prompt, shell, source};

fn main() -> ExitCode {
    let mut arguments = env::args_os().skip(1);
    if env::args_os().nth(1).is_some_and(|first| first == GENERATION) {
        return match generate(arguments.by_ref().skip(1)) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                let _ = writeln!(io::stdout(), "{}", error.text);
                ExitCode::from(error.status)
            }
        };
    }
    match parse(arguments).and_then(carry_out) {
        Ok(text) => say(&text),
        Err(error) => {
            complain(&format!("error: {error}"));
            ExitCode::from(error.status())
        }
    }
}

/// Does what was asked for; returns what there is to say.
fn carry_out(request: Request) -> Result<String, Error> {
    match request {
        Request::Print(text) => Ok(text),
        Request::Choices => choices(),
        Request::Generators => Ok(generator::list()),
        Request::Generator { name, as_name } => Copy::new(&name, &as_name, &here()?)?.write(),
        Request::External(sensor) => external::write(&sensor, &here()?),
        Request::Project(project) => new_project(project),
    }
}

/// The folder in which it was started.
fn here() -> Result<PathBuf, Error> {
    env::current_dir().map_err(|error| Error::Failed {
        what: format!("this folder cannot be entered: {error}"),
        help: "go into the project's folder by `cd`".to_owned(),
    })
}

fn choices() -> Result<String, Error> {
    let template = Template::built_in()?;
    let checkout = source::checkout().filter(|_| template.has("mrroc_source"));
    let note = checkout.map_or_else(String::new, |checkout| {
        format!("\nWithout these, mrroc_source is `path` here: mrroc lies in {}\n", checkout.display())
    });
    Ok(format!("{template}{note}"))
}

fn new_project(Project { name, into, mut given, rest }: Project) -> Result<String, Error> {
    let template = Template::built_in()?;
    // Refused before anything is asked.
    place(&name, &into)?;
    source::complete(&template, &mut given, source::checkout().as_deref())?;
    let asked = rest == Rest::Asked && prompt::somebody_is_there();
    let ask = if asked { prompt::ask } else { Placeholder::default };
    let chosen = settle(&template, &given, ask)?;
    let project = make(&name, &into, &chosen)?;
    let mut text = format!("{name} is made:\n");
    for (choice, value) in chosen {
        text += &format!("  {choice} = {value}\n");
    }
    text += &format!("\nNow:\n  cd {}\n  cargo run\n", shell::quoted(&project));
    Ok(text)
}

/// Prints a text. A reader that has had enough and closed the pipe is no failure.
fn say(text: &str) -> ExitCode {
    match io::stdout().write_all(text.as_bytes()).and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            complain(&format!("error: the standard output cannot be written: {error}"));
            ExitCode::FAILURE
        }
        Ok(()) | Err(_) => ExitCode::SUCCESS,
    }
}

fn complain(line: &str) {
    // Files of the project are quoted, which may hold anything.
    let line: String = line.chars().map(|c| if c.is_control() && c != '\n' { ' ' } else { c }).collect();
    // Without a standard error the exit status alone must tell.
    let _ = writeln!(io::stderr(), "{line}");
}
