"""The priority of what stands for a device: a robot's controller or a cable is never busy with something else."""

import os


def urgent(inherited=True):
    """Gives this thread a priority above those of a cell, where it may have one; what it starts has it as well, or none."""
    policy = os.SCHED_FIFO if inherited else os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(60))
    except PermissionError:
        pass
