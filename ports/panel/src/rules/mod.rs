//! Who may do what: plain rules, without a socket or a clock of their own.
//!
//! In: what a browser sends, and when. Out: whether it is admitted, and what it asks for. `origin` looks at hosts and origins, `token`
//! at who knows the secret, `authority` at who operates, `request` at what is asked and for which step, `rate` at how often.

pub mod authority;
pub mod origin;
pub mod rate;
pub mod request;
pub mod token;

/// The longest message of a page \[bytes\].
pub const LONGEST: usize = 1024;

/// The most connections at a time.
pub const CONNECTIONS: usize = 48;

/// The most pages at a time; the other connections are for those that have not shown the token yet, and for files.
pub const PAGES: usize = 32;
