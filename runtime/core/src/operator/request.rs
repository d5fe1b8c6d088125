//! What a console asks of a running cell, and what it is answered: a console of the command line, a page of the panel, for the cell or
//! for a lower one.
//!
//! In: a word and what stands behind it, in a line of text `speed 50%`, in JSON `{"do": "speed", "rest": "50%"}`. Out: a request;
//! back, its answer.
//!
//! | request | answer |
//! |---|---|
//! | `stop`, `abort`, `let-go 4711` | to every console: they only bring robots to rest |
//! | `suspend`, `resume`, `speed 50%`, and all other [buttons](Button) | only to the console that holds the control token; a console that asks while the token is free takes it |
//! | `take`, `release` | takes or returns the token; the end of a console returns it as well |
//! | `status` | a picture |
//! | `watch` | a picture, and from then on up to 20 pictures a second between the answers |
//! | `of press suspend` | any of these, of the lower cell `press`; each cell has a control token of its own |
//! | `by 3 81726354 suspend` | any of these, asked by page 3 of a panel, which heard it at this time of the machine \[ns\]: for the recording |

use core::fmt;

use serde::{Deserialize, Serialize};

use super::button::{Button, ButtonKind};
use super::no_request::NoRequest;
use crate::model::name::Name;
use crate::model::time::Nanos;
use crate::suggestion::suggestion;

/// What a console asks for.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Words")]
pub enum Request {
    /// `status`: one picture.
    Status,
    /// `watch`: one picture now, and further ones from then on.
    Watch,
    /// `take`: the control token.
    Take,
    /// `release`: give the control token back.
    Release,
    /// A button is pressed.
    Press(Button),
}

/// The requests that are no buttons, and their words.
const PLAIN: [(&str, Request); 4] = [
    ("status", Request::Status),
    ("watch", Request::Watch),
    ("take", Request::Take),
    ("release", Request::Release),
];

/// A request in JSON.
#[derive(Deserialize)]
struct Words {
    #[serde(rename = "do")]
    word: String,
    #[serde(default)]
    rest: String,
}

impl TryFrom<Words> for Request {
    type Error = String;

    fn try_from(Words { word, rest }: Words) -> Result<Request, String> {
        Request::of(&word, rest.trim()).map_err(|error| error.in_a_line())
    }
}

impl Request {
    /// Reads a request.
    ///
    /// # Errors
    /// [`NoRequest`]: what is wrong, and what to write.
    pub fn read(line: &str) -> Result<Request, NoRequest> {
        let (request, rest) = word(line);
        Request::of(request, rest.trim())
    }

    fn of(word: &str, rest: &str) -> Result<Request, NoRequest> {
        let plain = PLAIN.into_iter().find(|(known, _)| *known == word);
        if let Some((_, request)) = plain {
            return if rest.is_empty() { Ok(request) } else { Err(NoRequest::of(word, rest, "")) };
        }
        if let Some(kind) = ButtonKind::ALL.iter().find(|kind| kind.word == word) {
            return Button::read(kind, rest).map(Request::Press);
        }
        let buttons = ButtonKind::ALL.iter().map(|kind| kind.word);
        let known: Vec<_> = PLAIN.iter().map(|(word, _)| *word).chain(buttons).collect();
        let help = suggestion(word, &known, "there are");
        Err(NoRequest { what: format!("`{}` is no request", word.escape_default()), help })
    }
}

/// `speed 50%`: what [`Request::read`] reads.
impl fmt::Display for Request {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Request::Status => f.write_str("status"),
            Request::Watch => f.write_str("watch"),
            Request::Take => f.write_str("take"),
            Request::Release => f.write_str("release"),
            Request::Press(button) => button.fmt(f),
        }
    }
}

/// For whom a console asks: a page of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OnBehalf {
    /// The number of the page.
    pub page: u64,
    /// When the panel heard it, by the machine's monotonic clock \[ns\].
    pub heard: Nanos,
}

/// A request, the lower cell that it is for, or the uppermost one if none is named, and the page that made it, if one did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Addressed {
    /// The page.
    pub by: Option<OnBehalf>,
    /// The lower cell.
    pub cell: Option<Name>,
    /// What is asked for.
    pub request: Request,
}

impl Addressed {
    /// Reads a request, which may name a page and a cell.
    ///
    /// # Errors
    /// [`NoRequest`]
    pub fn read(mut line: &str) -> Result<Addressed, NoRequest> {
        let (mut by, mut cell) = (None, None);
        if let ("by", rest) = word(line) {
            let (page, rest) = word(rest);
            let (heard, rest) = word(rest);
            let numbers = page.parse().ok().zip(heard.parse().ok());
            let refused =
                || NoRequest::of("by", page, "the page and when it was heard: by 3 81726354 suspend");
            by = Some(numbers.map(|(page, heard)| OnBehalf { page, heard }).ok_or_else(refused)?);
            line = rest;
        }
        if let ("of", rest) = word(line) {
            let (name, rest) = word(rest);
            let refused =
                |_| NoRequest::of("of", name, "the lower cell and what it is asked: of press suspend");
            cell = Some(Name::of_process(name).map_err(refused)?);
            line = rest;
        }
        Ok(Addressed { by, cell, request: Request::read(line)? })
    }
}

/// The first word of a line, and what stands behind it.
fn word(line: &str) -> (&str, &str) {
    let line = line.trim_start();
    line.split_at(line.find(char::is_whitespace).unwrap_or(line.len()))
}

/// `by 3 81726354 of press suspend`: what [`Addressed::read`] reads.
impl fmt::Display for Addressed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(OnBehalf { page, heard }) = self.by {
            write!(f, "by {page} {heard} ")?;
        }
        match self.cell {
            Some(cell) => write!(f, "of {cell} {}", self.request),
            None => self.request.fmt(f),
        }
    }
}

/// The answer to a request: in a line of text `done suspended: step 1203`, in JSON `{"outcome": "done", "text": "suspended: step 1203"}`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "outcome", content = "text", rename_all = "lowercase")]
pub enum Answer {
    /// The request was carried out; with what happened, in which step.
    Done(String),
    /// The request was refused; with the reason.
    Refused(String),
    /// The request will be carried out when the next step begins; at present the program computes.
    Pending(String),
}

impl Answer {
    /// Reads an answer, if a line is one.
    #[must_use]
    pub fn read(line: &str) -> Option<Answer> {
        let (outcome, text) = line.split_once(' ').unwrap_or((line, ""));
        let answer = match outcome {
            "done" => Answer::Done,
            "refused" => Answer::Refused,
            "pending" => Answer::Pending,
            _ => return None,
        };
        Some(answer(text.to_owned()))
    }

    /// What has become of the request, in a word, and what is said of it.
    #[must_use]
    pub fn parts(&self) -> (&'static str, &str) {
        match self {
            Answer::Done(text) => ("done", text),
            Answer::Refused(text) => ("refused", text),
            Answer::Pending(text) => ("pending", text),
        }
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (outcome, text) = self.parts();
        write!(f, "{outcome} {text}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_request_is_read_as_it_is_written_in_a_line_and_in_json() {
        let buttons = [Button::Stop, Button::Speed(0.3), Button::Reduced(true)].map(Request::Press);
        for request in PLAIN.map(|(_, request)| request).into_iter().chain(buttons) {
            let text = request.to_string();
            assert_eq!(Request::read(&text), Ok(request));
            let (word, rest) = text.split_once(' ').unwrap_or((&text, ""));
            let json = Words { word: word.to_owned(), rest: rest.to_owned() };
            assert_eq!(Request::try_from(json), Ok(request));
        }
    }

    #[test]
    fn what_is_no_request_is_refused_with_what_to_write() {
        for (line, told) in [
            ("speed 0.5.", "write 0% to 100%"),
            ("speed %", "write 0% to 100%"),
            ("speed 101%", "write 0% to 100%"),
            ("speed NaN%", "write 0% to 100%"),
            ("speed fast", "`speed fast` is no request"),
            ("speed", "write 0% to 100%"),
            ("staus", "did you mean `status`?"),
            ("suspnd", "did you mean `suspend`?"),
            ("stop now", "write stop alone"),
            ("take 2", "write take alone"),
            ("jog 4711 0 left", "tool x -50%"),
            ("jog left tool x 10%", "jog 4711 0 left tool x 20%"),
            ("jog 4711 70000 left tool x 10%", "jog 4711 0 left tool x 20%"),
            ("jog-done", "write the robot: jog-done left"),
            ("", "there are: status"),
            ("\u{fffd}", "no request"),
            ("of", "of press suspend"),
            ("of press", "no request"),
            ("of a:b stop", "`of a:b` is no request"),
            ("of x y", "no request"),
            ("by 3 stop", "by 3 81726354 suspend"),
            ("by -1 3 stop", "by 3 81726354 suspend"),
            ("by 1 3", "no request"),
        ] {
            let refused = Addressed::read(line).expect_err("no request").in_a_line();
            assert!(refused.contains(told) && !refused.contains('\n'), "{refused}");
        }
    }

    #[test]
    fn a_request_may_name_the_page_that_made_it_and_the_cell_that_it_is_for() {
        let page = |page, heard| Some(OnBehalf { page, heard });
        for (line, by, cell, request) in [
            ("of press suspend", None, Some("press"), Request::Press(Button::Suspend)),
            (" of  line.press  status", None, Some("line.press"), Request::Status),
            ("watch", None, None, Request::Watch),
            ("by 3 81726354 let-go 7", page(3, 81_726_354), None, Request::Press(Button::LetGo(7))),
            (" by  1  2  of press stop", page(1, 2), Some("press"), Request::Press(Button::Stop)),
        ] {
            let cell = cell.map(|name| Name::of_process(name).expect("a name"));
            let read = Addressed::read(line).expect("a request");
            assert_eq!(read, Addressed { by, cell, request });
            assert_eq!(Addressed::read(&read.to_string()), Ok(read));
        }
    }

    #[test]
    fn every_answer_is_read_as_it_is_written() {
        for answer in
            [Answer::Done, Answer::Refused, Answer::Pending].map(|answer| answer("stop: 3".to_owned()))
        {
            assert_eq!(Answer::read(&answer.to_string()), Some(answer));
        }
        assert_eq!(Answer::read("picture"), None);
    }
}
