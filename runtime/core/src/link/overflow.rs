//! Names the process whose stack has overflowed: on the memory link it meets the guard page below a coroutine's stack,
//! and the system would end the executable without a word.
//!
//! In: which coroutine runs, told by the scheduler. Out: a line on the standard error, written by the handler of SIGSEGV,
//! and then the end of the executable by that signal, as without the handler. Faults at any other address are left to the
//! handler that was there before, such as that of Rust's threads. On systems other than Linux nothing is said.

use core::cell::Cell;
use core::ops::Range;

use corosensei::stack::Stack;

/// The guard page of a process's stack, and what is said when the process touches it.
#[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "no handler reads it"))]
pub(super) struct Guard {
    page: Range<usize>,
    /// Made beforehand: a handler of a signal must not allocate.
    text: String,
}

thread_local! {
    /// What runs on this thread. It is initialised by a constant and needs no drop, so that the handler of a signal may
    /// read it.
    static RUNNING: Cell<Running> =
        const { Cell::new(Running { stack: core::ptr::null(), process: core::ptr::null() }) };
}

/// The stack that is in use, and the process that uses it: mostly its own.
#[derive(Clone, Copy)]
struct Running {
    stack: *const Guard,
    #[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "no handler reads it"))]
    process: *const Guard,
}

impl Guard {
    /// The guard page of the stack of the process called `name`, which has room for `size` bytes above it.
    pub fn of(name: &str, stack: &impl Stack, size: usize) -> Guard {
        let kilobytes = size >> 10;
        let text = format!(
            "error: {name} has overflowed its stack of {kilobytes} kB, and with it the cell has ended\n help: a function calls itself \
             without an end, or its variables are too large for the stack: put them into a Box or a Vec\n"
        );
        Guard { page: stack.limit().get()..stack.base().get() - size, text }
    }

    /// While what it returns lives, this thread runs on the stack of this guard page, which must not go before that.
    #[inline]
    pub fn enter(&self) -> Below {
        Below(RUNNING.replace(Running { stack: self, process: self }))
    }

    /// While what it returns lives, this thread runs the process of this guard page, which must not go before that, on the
    /// stack that is in use.
    #[inline]
    pub fn lend(&self) -> Below {
        let below = RUNNING.get();
        RUNNING.set(Running { process: self, ..below });
        Below(below)
    }
}

/// What ran before something else was entered: dropped, also by a panic, the thread is back there.
pub(super) struct Below(Running);

impl Drop for Below {
    #[inline]
    fn drop(&mut self) {
        RUNNING.set(self.0);
    }
}

/// Prepares this thread and the executable for [`Guard::enter`].
pub(super) fn listen() {
    #[cfg(target_os = "linux")]
    signal::listen();
}

#[cfg(target_os = "linux")]
mod signal {
    use core::mem::MaybeUninit;
    use core::ptr::{null, null_mut};
    use std::sync::{Once, OnceLock};

    use libc::{SA_ONSTACK, SA_SIGINFO, SIGSEGV, SS_DISABLE, c_int, c_void, sigaction, siginfo_t, stack_t};

    use super::RUNNING;

    /// Bytes of an alternate stack: the kernel saves up to some 12 kB of registers there, and the handler needs little.
    const ALTERNATE: usize = 64 << 10;

    /// What had SIGSEGV before.
    static BEFORE: OnceLock<sigaction> = OnceLock::new();

    pub fn listen() {
        static HANDLER: Once = Once::new();
        HANDLER.call_once(install);
        alternate_stack();
    }

    /// Puts the handler in the place of the one that is there.
    fn install() {
        let mut before = MaybeUninit::<sigaction>::zeroed();
        // SAFETY: only reads the action of a signal, into memory of its type.
        #[allow(unsafe_code)]
        let asked = unsafe { libc::sigaction(SIGSEGV, null(), before.as_mut_ptr()) };
        if asked != 0 {
            return;
        }
        // SAFETY: written by the call above; and zeros are a valid action as well.
        #[allow(unsafe_code)]
        let mut action = unsafe { before.assume_init() };
        BEFORE.get_or_init(|| action);
        action.sa_sigaction = handle as *const () as usize;
        action.sa_flags = SA_SIGINFO | SA_ONSTACK;
        // SAFETY: the handler has the type that SA_SIGINFO asks for, and does only what a handler may do. If it cannot be
        // installed, an overflow ends the executable without a word, as before.
        #[allow(unsafe_code)]
        let _ = unsafe { libc::sigaction(SIGSEGV, &action, null_mut()) };
    }

    /// Gives this thread a stack for handlers of signals, unless it has one, as all threads of Rust's have: the coroutine's
    /// own is used up.
    fn alternate_stack() {
        let mut now = stack_t { ss_sp: null_mut(), ss_flags: 0, ss_size: 0 };
        // SAFETY: only reads this thread's alternate stack.
        #[allow(unsafe_code)]
        let asked = unsafe { libc::sigaltstack(null(), &mut now) };
        if asked != 0 || now.ss_flags & SS_DISABLE == 0 {
            return;
        }
        let memory = Box::leak(vec![0_u8; ALTERNATE].into_boxed_slice());
        let stack = stack_t { ss_sp: memory.as_mut_ptr().cast(), ss_flags: 0, ss_size: memory.len() };
        // SAFETY: the memory is never freed and used for nothing else.
        #[allow(unsafe_code)]
        let _ = unsafe { libc::sigaltstack(&stack, null_mut()) };
    }

    /// Says which process has overflowed its stack, if one has, and hands the signal back.
    extern "C" fn handle(_: c_int, info: *mut siginfo_t, _: *mut c_void) {
        // SAFETY: the kernel gives a handler with SA_SIGINFO valid information, and that of SIGSEGV has an address.
        #[allow(unsafe_code)]
        let (address, code) = unsafe { ((*info).si_addr() as usize, (*info).si_code) };
        // SAFETY: a scheduler keeps what `Guard::enter` has pointed to for as long as its `Below` lives.
        #[allow(unsafe_code)]
        let (stack, process) = unsafe { (RUNNING.get().stack.as_ref(), RUNNING.get().process.as_ref()) };
        // A code above zero means that the kernel has found the fault, and not that somebody has sent the signal.
        let is_overflow = stack.is_some_and(|stack| code > 0 && stack.page.contains(&address));
        if let Some(text) = process.filter(|_| is_overflow).map(|process| &process.text) {
            // SAFETY: `write` may be called in a handler, and reads the bytes of a text that lives.
            #[allow(unsafe_code)]
            let _ = unsafe { libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len()) };
        }
        if let Some(before) = BEFORE.get() {
            // SAFETY: the action that was there before; `sigaction` may be called in a handler.
            #[allow(unsafe_code)]
            let _ = unsafe { libc::sigaction(SIGSEGV, before, null_mut()) };
        }
        if code <= 0 {
            // SAFETY: `raise` may be called in a handler. A signal that was sent would not come again by itself.
            #[allow(unsafe_code)]
            let _ = unsafe { libc::raise(SIGSEGV) };
        }
        // The instruction runs again now, and its signal comes to who had it before.
    }
}
