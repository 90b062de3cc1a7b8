"""How a process beside the server begins."""

import os
import signal

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def stand_back(niceness: int) -> None:
    """Leave Ctrl+C to the server, which ends this process; let it go first; compute in one thread.

    To be called before numpy is loaded.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(niceness)
    for name in THREADS:
        os.environ[name] = "1"
