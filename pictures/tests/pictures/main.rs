//! Pictures as a program of a user's gets them: read back with an XML parser.

mod page;
mod runs;
