//! Pictures as a program of a user's gets them: read back with an XML parser.

mod instruments;
mod page;
mod runs;
