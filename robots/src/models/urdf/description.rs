//! A URDF before it is a robot: which joints move between two of its links.

use std::io::Read;
use std::path::Path;

use mrroc_launch::files;

use super::chain::Chain;
use super::document::{LONGEST, Tree, parsed};
use super::error::UrdfError;

/// The text of a URDF, to be looked at before the number of an arm's joints, a part of its type, is known.
///
/// ```
/// use mrroc_robots::UrdfText;
/// # let text = r#"<robot name="r"><link name="base"/><link name="tool"/>
/// #   <joint name="turn" type="revolute"><parent link="base"/><child link="tool"/><axis xyz="0 0 1"/>
/// #   <limit lower="-1" upper="1" velocity="2"/></joint></robot>"#;
/// let urdf = UrdfText::new(text);
/// assert_eq!(urdf.root()?, "base");
/// assert_eq!(urdf.joints("base", "tool")?, ["turn"]);
/// # Ok::<(), mrroc_robots::UrdfError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UrdfText(String);

impl UrdfText {
    /// A URDF with this text.
    #[must_use]
    pub fn new(text: &str) -> Self {
        Self(text.to_owned())
    }

    /// The URDF in a file.
    ///
    /// # Errors
    /// [`UrdfError::File`] when the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, UrdfError> {
        text_of(path.as_ref()).map(Self)
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The link on which all others hang: the base link, where a file describes one robot.
    ///
    /// # Errors
    /// [`UrdfError`]: not a URDF, or no such link.
    pub fn root(&self) -> Result<String, UrdfError> {
        let document = parsed(&self.0)?;
        Tree::of(&document)?.root().map(str::to_owned)
    }

    /// The names of the joints that move from link `base` to link `tip`, in that order, mimic joints not counted.
    ///
    /// # Errors
    /// [`UrdfError`], as of [`Serial::from_urdf`](super::Serial::from_urdf).
    pub fn joints(&self, base: &str, tip: &str) -> Result<Vec<String>, UrdfError> {
        let document = parsed(&self.0)?;
        let chain = Chain::between(&Tree::of(&document)?, base, tip, None)?;
        Ok(chain.movers.into_iter().map(|mover| mover.name).collect())
    }
}

/// The text of a file, of which no more is read than a URDF may have.
pub(super) fn text_of(path: &Path) -> Result<String, UrdfError> {
    let failed = |why| UrdfError::File { path: path.to_owned(), why };
    let mut text = String::new();
    let file = files::open(path).map_err(failed)?;
    file.take(LONGEST as u64 + 1).read_to_string(&mut text).map_err(failed)?;
    Ok(text)
}
