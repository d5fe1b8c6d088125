"""How programs in Python are begun and ended that end by an interrupt."""

import signal


def interruptible():
    """For `preexec_fn`: a background process of a shell ignores interrupts, and so do those that it begins, unless they are told this."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def until_interrupted(program, *arguments):
    """Runs it until a SIGTERM ends it as Ctrl-C would, which a background process of a shell does not hear."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        program(*arguments)
    except KeyboardInterrupt:
        pass


def end(process, by=signal.SIGINT):
    """Interrupts it, and waits until it has ended. What it says is read, or it might wait for that."""
    if process.poll() is None:
        process.send_signal(by)
    process.communicate(timeout=30)
