//! What a page asks for.
//!
//! In: the text of a message. Out: a request, with the step for which it was made; or what is wrong with it. Each button carries the
//! epoch and the step that the page showed when it was pressed: what is asked of a picture that is old is refused.

use mrroc_core::fault::Name;
use mrroc_core::operator::Request;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::jog::JogOrder;
use serde_json::Value;

/// How much older than the newest step the step of a request may be \[ns\].
const OLD: u64 = 1_000_000_000;

/// What a page asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum PageRequest {
    /// To be let in.
    Token(String),
    /// Nothing: it is there.
    Beat,
    /// A stop, which is never refused.
    Stop,
    /// Authority.
    Take,
    /// To give it back.
    Release,
    /// A button.
    Press(Button, Stamp),
    /// Robots may move while this is said again and again, at reduced speed, or one is jogged; whether a hold begins.
    Hold(bool, Option<(Name, JogOrder)>, Stamp),
    /// They may no longer.
    LetGo,
    /// A robot that stands is taught its pose, by this name.
    Teach(Name, Name, Stamp),
    /// A pose of a robot gets another name.
    Rename(Name, Name, Name),
    /// A pose of a robot is forgotten.
    Forget(Name, Name),
    /// To see the path of a robot's tool to a pose.
    ToolPath(Name, Name),
    /// What a recording shows at a time \[s\], and whether with what plots show of the minute before.
    Frame(f64, bool),
}

/// Of which step a page knew when something was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// The epoch.
    pub epoch: u32,
    /// The step.
    pub step: u64,
}

/// A message of a page.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The number that the page gave it: the answer has the same one.
    pub number: u64,
    /// What is asked for.
    pub asked: PageRequest,
}

/// A message that is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadMessage {
    /// It is no JSON object, or lacks what it needs.
    #[error("a message needs `{0}`")]
    Lacks(&'static str),
    /// It asks for something that there is not.
    #[error("{0}")]
    Unknown(String),
}

/// Why a request is refused though its page may make it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Old {
    /// It was made before a reset, or for another cell.
    #[error("it was asked for before the last reset: look, and press again")]
    Epoch,
    /// The page showed a picture that is too old.
    #[error("it was asked for {0} steps ago: this page is too far behind the cell; look, and press again")]
    Step(u64),
}

impl Stamp {
    /// Whether what was asked for at this step may still be done at another one, of steps of this length \[ns\].
    ///
    /// # Errors
    /// [`Old`]
    pub fn check(&self, newest: Stamp, period: u64) -> Result<(), Old> {
        if self.epoch != newest.epoch {
            return Err(Old::Epoch);
        }
        let behind = newest.step.saturating_sub(self.step);
        if behind.saturating_mul(period) > OLD { Err(Old::Step(behind)) } else { Ok(()) }
    }

    fn of(json: &Value) -> Result<Stamp, BadMessage> {
        let epoch = json["epoch"].as_u64().and_then(|epoch| u32::try_from(epoch).ok());
        let epoch = epoch.ok_or(BadMessage::Lacks("epoch"))?;
        let step = json["step"].as_u64().ok_or(BadMessage::Lacks("step"))?;
        Ok(Stamp { epoch, step })
    }
}

/// A name in a message. A robot may be one of a lower cell.
fn name(json: &Value, key: &'static str) -> Result<Name, BadMessage> {
    let text = json[key].as_str().ok_or(BadMessage::Lacks(key))?;
    let read = if key == "robot" { Name::of_process(text) } else { Name::new(text) };
    read.map_err(|bad| BadMessage::Unknown(bad.to_string()))
}

/// The robot that is jogged, and how.
fn jog(json: &Value) -> Result<(Name, JogOrder), BadMessage> {
    let order = json["order"].as_str().ok_or(BadMessage::Lacks("order"))?;
    let order = JogOrder::read(&mut order.split_whitespace());
    Ok((name(json, "robot")?, order.map_err(|bad| BadMessage::Unknown(bad.in_a_line()))?))
}

impl Message {
    /// Reads a message.
    ///
    /// # Errors
    /// [`BadMessage`]
    pub fn read(text: &str) -> Result<Message, BadMessage> {
        let json: Value = serde_json::from_str(text).map_err(|_| BadMessage::Lacks("JSON"))?;
        if let Some(token) = json["token"].as_str() {
            return Ok(Message { number: 0, asked: PageRequest::Token(token.to_owned()) });
        }
        let number = json["n"].as_u64().unwrap_or(0);
        let word = json["do"].as_str().ok_or(BadMessage::Lacks("do"))?;
        let asked = match word {
            "beat" => PageRequest::Beat,
            "stop" => PageRequest::Stop,
            "let-go" => PageRequest::LetGo,
            "hold" | "jog" => {
                let jog = (word == "jog").then(|| jog(&json)).transpose()?;
                PageRequest::Hold(json["begins"].as_bool().unwrap_or(false), jog, Stamp::of(&json)?)
            }
            "teach" => PageRequest::Teach(name(&json, "robot")?, name(&json, "name")?, Stamp::of(&json)?),
            "rename" => PageRequest::Rename(name(&json, "robot")?, name(&json, "name")?, name(&json, "to")?),
            "forget" => PageRequest::Forget(name(&json, "robot")?, name(&json, "name")?),
            "path" => PageRequest::ToolPath(name(&json, "robot")?, name(&json, "name")?),
            "frame" => {
                let at = json["at"].as_f64().filter(|at| at.is_finite());
                let minute = json["minute"].as_bool().unwrap_or(false);
                PageRequest::Frame(at.ok_or(BadMessage::Lacks("at"))?, minute)
            }
            _ => match serde_json::from_value(json.clone()) {
                Ok(Request::Take) => PageRequest::Take,
                Ok(Request::Release) => PageRequest::Release,
                Ok(Request::Press(button)) => PageRequest::Press(button, Stamp::of(&json)?),
                Ok(Request::Status | Request::Watch) => {
                    return Err(BadMessage::Unknown("a page is shown the cell without asking".to_owned()));
                }
                Err(bad) => return Err(BadMessage::Unknown(bad.to_string())),
            },
        };
        Ok(Message { number, asked })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc_core::operator::Renewal;

    fn read(text: &str) -> Result<PageRequest, BadMessage> {
        Message::read(text).map(|message| message.asked)
    }

    #[test]
    fn a_message_is_read_as_a_page_writes_it() {
        let stamp = Stamp { epoch: 2, step: 40 };
        let (left, pick) = (Name::new("left").expect("a name"), Name::new("pick").expect("a name"));
        let order = JogOrder::read(&mut "tool x 50%".split_whitespace()).expect("an order");
        for (text, asked) in [
            (r#"{"token":"abc"}"#, PageRequest::Token("abc".to_owned())),
            (r#"{"do":"beat"}"#, PageRequest::Beat),
            (r#"{"n":3,"do":"stop"}"#, PageRequest::Stop),
            (r#"{"n":3,"do":"take"}"#, PageRequest::Take),
            (r#"{"n":3,"do":"suspend","epoch":2,"step":40}"#, PageRequest::Press(Button::Suspend, stamp)),
            (
                r#"{"n":3,"do":"speed","rest":"50%","epoch":2,"step":40}"#,
                PageRequest::Press(Button::Speed(0.5), stamp),
            ),
            (
                r#"{"n":3,"do":"hold","begins":true,"epoch":2,"step":40}"#,
                PageRequest::Hold(true, None, stamp),
            ),
            (r#"{"n":3,"do":"hold","epoch":2,"step":40}"#, PageRequest::Hold(false, None, stamp)),
            (r#"{"n":3,"do":"release"}"#, PageRequest::Release),
            (r#"{"n":3,"do":"let-go"}"#, PageRequest::LetGo),
            (
                r#"{"n":3,"do":"jog","begins":true,"robot":"left","order":"tool x 50%","epoch":2,"step":40}"#,
                PageRequest::Hold(true, Some((left, order)), stamp),
            ),
            (
                r#"{"n":3,"do":"jog-done","rest":"left","epoch":2,"step":40}"#,
                PageRequest::Press(Button::JogDone(left), stamp),
            ),
            (
                r#"{"n":3,"do":"teach","robot":"left","name":"pick","epoch":2,"step":40}"#,
                PageRequest::Teach(left, pick, stamp),
            ),
            (
                r#"{"do":"rename","robot":"left","name":"pick","to":"left"}"#,
                PageRequest::Rename(left, pick, left),
            ),
            (r#"{"do":"forget","robot":"left","name":"pick"}"#, PageRequest::Forget(left, pick)),
            (r#"{"do":"path","robot":"left","name":"pick"}"#, PageRequest::ToolPath(left, pick)),
            (r#"{"do":"frame","at":1.5}"#, PageRequest::Frame(1.5, false)),
            (r#"{"do":"frame","at":1.5,"minute":true}"#, PageRequest::Frame(1.5, true)),
        ] {
            assert_eq!(read(text), Ok(asked), "{text}");
        }
        assert_eq!(Message::read(r#"{"n":3,"do":"stop"}"#).map(|message| message.number), Ok(3));
        // No page makes up a renewal: the panel counts them.
        assert!(read(r#"{"do":"jog 9 9 left tool x 50%","epoch":0,"step":0}"#).is_err());
        assert!(!matches!(
            read(r#"{"do":"hold 9 9","epoch":0,"step":0}"#),
            Ok(PageRequest::Press(Button::Hold(_), _))
        ));
        assert_eq!(Renewal::first(1).count(), 0);
    }

    #[test]
    fn fault_203_what_is_no_message_is_refused_with_what_it_lacks() {
        for (text, told) in [
            ("", "JSON"),
            ("[1, 2", "JSON"),
            ("7", "do"),
            ("{}", "do"),
            (r#"{"do":7}"#, "do"),
            (r#"{"do":"fly","epoch":0,"step":0}"#, "`fly` is no request"),
            (r#"{"do":"resume"}"#, "epoch"),
            (r#"{"do":"resume","epoch":-1,"step":4}"#, "epoch"),
            (r#"{"do":"resume","epoch":1e99,"step":4}"#, "epoch"),
            (r#"{"do":"resume","epoch":1}"#, "step"),
            (r#"{"do":"speed","rest":"fast","epoch":1,"step":1}"#, "`speed fast` is no request"),
            (r#"{"do":"jog","robot":"left","order":"tool x 900%","epoch":1,"step":1}"#, "tool x -50%"),
            (r#"{"do":"jog","robot":"left","order":"tool x 9%","epoch":1}"#, "step"),
            (r#"{"do":"jog","order":"tool x 9%","epoch":1,"step":1}"#, "robot"),
            (r#"{"do":"teach","robot":"left","name":"../x","epoch":1,"step":1}"#, "is no name"),
            (r#"{"do":"forget","robot":"/etc/x","name":"x"}"#, "is no name"),
            (r#"{"do":"frame","at":"x"}"#, "at"),
        ] {
            let bad = read(text).expect_err("refused").to_string();
            assert!(bad.contains(told), "{text}: {bad}");
        }
        // Nested beyond all measure.
        assert!(read(&"[".repeat(1000)).is_err());
    }

    #[test]
    fn fault_204_what_was_asked_for_a_second_ago_or_before_a_reset_is_refused() {
        let at = |epoch, step| Stamp { epoch, step };
        let period = 2_000_000;
        assert_eq!(at(1, 1000).check(at(1, 1000), period), Ok(()));
        assert_eq!(at(1, 500).check(at(1, 1000), period), Ok(()));
        assert_eq!(at(1, 499).check(at(1, 1000), period), Err(Old::Step(501)));
        // The page may know of a newer step than the panel.
        assert_eq!(at(1, 1007).check(at(1, 1000), period), Ok(()));
        for epoch in [0, 2] {
            assert_eq!(at(epoch, 1000).check(at(1, 1000), period), Err(Old::Epoch));
        }
        assert_eq!(at(1, 0).check(at(1, u64::MAX), u64::MAX), Err(Old::Step(u64::MAX)));
        // A stop has no stamp at all.
        assert_eq!(read(r#"{"do":"stop","epoch":"old","step":null}"#), Ok(PageRequest::Stop));
    }
}
