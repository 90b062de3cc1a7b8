"""How a process beside the server begins."""

import os
import signal

from viewimit import threads


def stand_back(niceness: int) -> None:
    """Leave Ctrl+C to the server, which ends this process; let it go first; compute in one thread.

    To be called before numpy is loaded.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(niceness)
    threads.take_one_alone()
