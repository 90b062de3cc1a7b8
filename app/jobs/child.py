"""How a process beside the server begins."""

from viewimit.geometry import limit_blas_threads
from viewimit.processes import ignore_interrupts, lower_priority


def stand_back(niceness: int) -> None:
    """Leave Ctrl+C and a closed terminal to the server, which ends this process; let that go first; use one thread.

    To be called before numpy is loaded.
    """
    ignore_interrupts()
    lower_priority(niceness)
    limit_blas_threads(override=True)
