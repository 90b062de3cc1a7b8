"""How a process beside the server begins."""

import os
import signal

from viewimit.geometry import limit_blas_threads


def stand_back(niceness: int) -> None:
    """Leave Ctrl+C and a closed terminal to the server, which ends this process; let that go first; use one thread.

    To be called before numpy is loaded.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(niceness)
    limit_blas_threads(override=True)
