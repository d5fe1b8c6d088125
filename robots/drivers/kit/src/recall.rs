//! What a reset does with a device that is talked to by a thread.
//!
//! In: the link to it, if there is one. Out: one that goes on, in the end; nothing here waits.

/// A link to a device, which goes on in a thread of its own.
pub trait Recalled {
    /// Why it has ended.
    type Fault;

    /// Whether something was heard of the device.
    ///
    /// # Errors
    /// Why nothing more is heard.
    fn has_heard(&self) -> Result<bool, Self::Fault>;

    /// Ends it, soon: its thread may wait for the device.
    fn hang_up(&self);

    /// Whether its thread has ended.
    fn is_over(&self) -> bool;
}

/// Goes on with a reset, from one call to the next, until the link is one that has heard something: whether that is so. A link that has ended
/// is begun anew once; `recovers` says that the present one was begun by this reset, and is kept between calls.
///
/// ```
/// use mrroc_driver_kit::{Recalled, recall};
///
/// struct Call(Result<bool, &'static str>);
/// impl Recalled for Call {
///     type Fault = &'static str;
///     fn has_heard(&self) -> Result<bool, &'static str> {
///         self.0
///     }
///     fn hang_up(&self) {}
///     fn is_over(&self) -> bool {
///         self.0.is_err()
///     }
/// }
///
/// let (mut link, mut recovers) = (Some(Call(Err("hung up"))), false);
/// assert_eq!(recall(&mut link, &mut recovers, || Ok(Call(Ok(true)))), Ok(false), "it is called again");
/// assert_eq!(recall(&mut link, &mut recovers, || Err("called twice")), Ok(true));
/// ```
///
/// # Errors
/// A link that this reset has begun has ended, or it cannot begin.
pub fn recall<L: Recalled>(
    link: &mut Option<L>,
    recovers: &mut bool,
    begin: impl FnOnce() -> Result<L, L::Fault>,
) -> Result<bool, L::Fault> {
    match link.as_ref().map(L::has_heard) {
        Some(Ok(true)) => {
            *recovers = false;
            return Ok(true);
        }
        Some(Ok(false)) => return Ok(false),
        Some(Err(fault)) if *recovers => {
            *recovers = false;
            return Err(fault);
        }
        Some(Err(_)) | None => {}
    }
    // A thread that waits for an answer ends soon, and is not waited for here.
    if let Some(link) = link.as_ref().filter(|link| !link.is_over()) {
        link.hang_up();
        return Ok(false);
    }
    *link = Some(begin()?);
    *recovers = true;
    Ok(false)
}
