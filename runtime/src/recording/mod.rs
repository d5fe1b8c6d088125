//! mod
use std::path::PathBuf;
/// R
#[derive(Clone, Debug)]
pub struct Recording {
    /** f*/
    pub file: PathBuf,
}
