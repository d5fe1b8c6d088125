"""How programs in Python are ended."""

import signal
import subprocess


def end(process, by=signal.SIGINT):
    """Interrupts it until it has ended: Python drops an interrupt that comes while it collects garbage or is called back."""
    for _ in range(30):
        if process.poll() is None:
            process.send_signal(by)
        try:
            # What it says is read, or it might wait for that.
            process.communicate(timeout=1)
            return
        except subprocess.TimeoutExpired:
            pass
    raise SystemExit(f"{process.args[1]} does not end")
