//! Mesh files: by the end of its name, a file becomes a [`TriangleMesh`].

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::error::MeshError;
use super::triangles::TriangleMesh;
use super::{dae, obj, stl};

/// Ends of the names of files that are read.
pub const MESH_EXTENSIONS: [&str; 3] = ["stl", "obj", "dae"];

/// The largest file that is read \[bytes\].
const LARGEST: u64 = 64 << 20;

impl TriangleMesh {
    /// The mesh of an STL (binary or ASCII), OBJ or COLLADA (`.dae`) file, told apart by the end of its name. A COLLADA file
    /// says its unit and which axis is up; the numbers of the others are metres.
    ///
    /// # Errors
    /// [`MeshError::In`], which names the file: it cannot be read, is cut off or too large, a number is not finite, an index is out of range,
    /// it has no triangle with an area.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let read = |path: &Path| {
            let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
            if !MESH_EXTENSIONS.contains(&end.as_str()) {
                return Err(MeshError::Kind);
            }
            Self::from_bytes(&end, &bytes_of(path)?)
        };
        read(path).map_err(|why| why.of_file(path))
    }

    /// The mesh that these bytes are as a file whose name has this end: `stl`, `obj` or `dae`.
    ///
    /// # Errors
    /// [`MeshError`].
    pub fn from_bytes(extension: &str, bytes: &[u8]) -> Result<Self, MeshError> {
        let (vertices, triangles) = match extension {
            "stl" => stl::read(bytes)?,
            "obj" => obj::read(bytes)?,
            "dae" => dae::read(bytes)?,
            _ => return Err(MeshError::Kind),
        };
        Self::new(&vertices, &triangles)
    }
}

/// All bytes of a file that is not too large.
fn bytes_of(path: &Path) -> Result<Vec<u8>, MeshError> {
    let mut bytes = Vec::new();
    // A pipe could keep its reader waiting.
    if !std::fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("it is no regular file").into());
    }
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    if length <= LARGEST {
        // It may grow meanwhile.
        file.by_ref().take(LARGEST + 1).read_to_end(&mut bytes)?;
    }
    let bytes_read = length.max(bytes.len() as u64);
    if bytes_read > LARGEST {
        return Err(MeshError::TooLarge { bytes: bytes_read, limit: LARGEST });
    }
    Ok(bytes)
}
