//! The verdict on a trial, as its run says it, and as a copy of a run reports it in a line.

/// The verdict on a case.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    /// The fault was never applied: it came after the end.
    Void,
    /// The program ended without a fault, where the undisturbed run ends.
    Survived,
    /// All robots stood after `steps` steps; `bound` steps are allowed.
    Stopped { steps: u64, bound: u64 },
    /// A promise was broken.
    Broken(String),
}

impl Verdict {
    /// The line by which a copy of a run reports the verdict.
    pub fn to_line(&self) -> String {
        match self {
            Verdict::Void => "void".to_owned(),
            Verdict::Survived => "survived".to_owned(),
            Verdict::Stopped { steps, bound } => format!("stopped {steps} {bound}"),
            Verdict::Broken(what) => format!("broken {what}"),
        }
    }

    /// Reads the line of a copy; `None` if it is not complete.
    pub fn from_line(line: &str) -> Option<Verdict> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "void" => Some(Verdict::Void),
            "survived" => Some(Verdict::Survived),
            "stopped" => {
                let (steps, bound) = rest.split_once(' ')?;
                Some(Verdict::Stopped { steps: steps.parse().ok()?, bound: bound.parse().ok()? })
            }
            "broken" => Some(Verdict::Broken(rest.to_owned())),
            _ => None,
        }
    }
}
