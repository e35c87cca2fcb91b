"""What this process holds."""

import os
import time


def descriptors():
    return len(os.listdir("/proc/self/fd"))


def threads(at_most=0, within=10.0):
    """Threads that the kernel lists. It lists one that was joined for a moment more: waits until there are `at_most`, for `within` seconds."""
    end = time.monotonic() + within
    while (count := len(os.listdir("/proc/self/task"))) > at_most > 0 and time.monotonic() < end:
        time.sleep(0.01)
    return count
