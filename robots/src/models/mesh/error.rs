//! Why a file gives no mesh, or a mesh no cover.

use std::path::{Path, PathBuf};

use crate::models::xml::TooMuchXml;

/// A mesh that cannot be read or covered. One variant is one cause.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// What is wrong with a file.
    #[error("{}: {why}", path.display())]
    In {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        why: Box<MeshError>,
    },
    /// The file cannot be read.
    #[error("{0}")]
    File(#[from] std::io::Error),
    /// The file is larger than any mesh of a link needs.
    #[error("it has {bytes} bytes, at most {limit} are read: simplify the mesh")]
    TooLarge {
        /// Its size \[bytes\].
        bytes: u64,
        /// The most that is read \[bytes\].
        limit: u64,
    },
    /// A kind of file that is not read.
    #[error("its name does not end in .stl, .obj or .dae: convert it to one of these")]
    Kind,
    /// A binary STL file of another length than its number of triangles needs.
    #[error(
        "it states {count} triangles, which need {needed} bytes, and has {bytes}: it is cut off or no STL file"
    )]
    Length {
        /// The number of triangles that it states.
        count: u32,
        /// What they need \[bytes\].
        needed: u64,
        /// What there is \[bytes\].
        bytes: u64,
    },
    /// A line of a text, or an element of an XML text, that is not what it should be.
    #[error("line {line}: {found} where {expected} should stand")]
    Text {
        /// Line, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What should stand there.
        expected: &'static str,
    },
    /// A text that ends before the mesh does.
    #[error("it ends at line {line} before {expected}: it is cut off")]
    CutOff {
        /// The last line, from 1.
        line: usize,
        /// What should have come.
        expected: &'static str,
    },
    /// A text that is not UTF-8.
    #[error("it is no text in UTF-8")]
    NoText,
    /// A text that is not XML.
    #[error("line {line}: not well-formed XML: {what}")]
    Xml {
        /// Line, from 1.
        line: usize,
        /// What the XML reader says.
        what: String,
    },
    /// XML that asks for too much.
    #[error(transparent)]
    TooMuch(#[from] TooMuchXml),
    /// A part of a COLLADA file that is not read.
    #[error("line {line}: {what}: export the mesh as triangles, or as STL")]
    Collada {
        /// Line, from 1.
        line: usize,
        /// What is not read.
        what: String,
    },
    /// An index of a vertex that is not there.
    #[error("triangle {triangle} names vertex {index}, and there are {count}")]
    Index {
        /// The triangle, from 0.
        triangle: usize,
        /// The index.
        index: u64,
        /// How many vertices there are.
        count: usize,
    },
    /// A coordinate that is not a number, infinite or absurd.
    #[error(
        "vertex {vertex} is not within {limit} m of the origin: check its numbers and the units of the file"
    )]
    Coordinate {
        /// The vertex, from 0.
        vertex: usize,
        /// The farthest that is taken \[m\].
        limit: f64,
    },
    /// A scale that is 0, infinite or not a number.
    #[error("the scale {scale:?} is not three finite numbers other than 0")]
    Scale {
        /// The scale.
        scale: [f64; 3],
    },
    /// No triangle that has an area.
    #[error("it has no triangle with an area ({dropped} without)")]
    Empty {
        /// How many triangles without an area there are.
        dropped: usize,
    },
    /// An excess that is not a length above 0.
    #[error("the excess {excess} m is not a finite number above 0")]
    Excess {
        /// The excess \[m\].
        excess: f64,
    },
    /// The body is too large for the excess.
    #[error(
        "it is {size:.1} m across, more than {limit} times the excess of {:.1} mm: check its unit and scale, or allow more",
        excess * 1e3
    )]
    TooFine {
        /// How large the body is \[m\].
        size: f64,
        /// The excess \[m\].
        excess: f64,
        /// The most that it may be of the excess \[1\].
        limit: f64,
    },
    /// The cover would need too many capsules.
    #[error(
        "more than {limit} capsules are needed to cover it with an excess of {:.1} mm ({open_edges} of its edges are open): \
         allow a larger excess, or close it",
        excess * 1e3
    )]
    TooMany {
        /// The most capsules of a cover.
        limit: usize,
        /// The excess \[m\].
        excess: f64,
        /// How many edges have an odd number of triangles.
        open_edges: usize,
    },
}

impl MeshError {
    /// The same, with the file that it is about.
    pub(crate) fn of_file(self, path: &Path) -> Self {
        MeshError::In { path: path.to_owned(), why: Box::new(self) }
    }
}
