//! The pairs of links that an SRDF, which MoveIt's assistant writes beside a URDF, says not to check.
//!
//! In: the text of the SRDF. Out: [`DisabledPair`]s, which `ClearanceBuilder::ignore_disabled` takes. Its groups and states are not read.

use super::document::{Element, parsed, shown};
use super::error::UrdfError;

/// Two links of one arm that are not checked against one another: `<disable_collisions>`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisabledPair {
    /// The links.
    pub links: [String; 2],
    /// Why, such as `Adjacent` or `Never`, if that is said.
    pub reason: Option<String>,
}

impl DisabledPair {
    /// All pairs of an SRDF, in its order.
    ///
    /// # Errors
    /// [`UrdfError`], with the line: not XML, not `<robot>`, a link without a name or twice in a pair, an attribute that is not known.
    pub fn from_srdf(text: &str) -> Result<Vec<Self>, UrdfError> {
        let document = parsed(text)?;
        let robot = Element { node: document.root_element(), called: "the robot".to_owned() };
        let pairs = robot.all("disable_collisions").map(|pair| {
            pair.only(&["link1", "link2", "reason"])?;
            let first = pair.required_text("link1", "link1=\"..\"")?;
            let second = pair.required_text("link2", "link2=\"..\"")?;
            if first == second {
                return Err(pair.bad("link2", "another link than link1"));
            }
            Ok(Self { links: [shown(first), shown(second)], reason: pair.text("reason")?.map(shown) })
        });
        pairs.collect()
    }
}
