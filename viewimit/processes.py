"""Child processes on every system: their priority, Ctrl-C, and an end with their parent."""

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Iterator
from typing import Any

if sys.platform == "win32":
    import ctypes

    kernel32: Any = ctypes.WinDLL("kernel32")
    kernel32.GetCurrentProcess.restype = ctypes.c_void_p
    kernel32.SetPriorityClass.argtypes = ctypes.c_void_p, ctypes.c_uint32
    BELOW_NORMAL_PRIORITY_CLASS = 0x4000


def lower_priority(niceness: int) -> None:
    """Let this process run after others. Windows knows one lower step where other systems have 19."""
    if sys.platform == "win32":
        if niceness > 0:
            kernel32.SetPriorityClass(kernel32.GetCurrentProcess(), BELOW_NORMAL_PRIORITY_CLASS)
    else:
        os.nice(niceness)


def ignore_interrupts() -> None:
    """Leave Ctrl-C, and the end of the terminal, to the parent process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "win32":
        signal.signal(signal.SIGBREAK, signal.SIG_IGN)  # Ctrl-Break, and a console window that is closed
    else:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # see `interrupts_withheld`


@contextlib.contextmanager
def interrupts_withheld() -> Iterator[None]:
    """Withhold Ctrl-C from processes that start inside, until they ignore it: each would print a traceback."""
    if sys.platform == "win32":
        kernel32.SetConsoleCtrlHandler(None, True)  # processes that start now ignore it, too
        try:
            yield
        finally:
            kernel32.SetConsoleCtrlHandler(None, False)
    else:
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def stop_signals() -> list[signal.Signals]:
    """Signals by which a user ends a program: Ctrl-C, a request to end, a terminal that is closed.

    nohup's wish not to hear of the terminal is kept.
    """
    if sys.platform == "win32":
        terminal = signal.SIGBREAK
    else:
        terminal = signal.SIGHUP
    ignored = signal.getsignal(terminal) == signal.SIG_IGN
    return [signal.SIGINT, signal.SIGTERM, *([] if ignored else [terminal])]


def end_with_parent() -> None:
    """End this process as soon as its parent process has ended, however that ends."""
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
