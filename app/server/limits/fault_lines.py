"""What goes wrong in a server's own machinery, told in a line: whoever can bring it about could fill a log."""

import logging
import traceback
from collections.abc import Callable
from pathlib import Path

FRAMES = 3  # innermost
OF_CLIENTS = "opening handshake failed"  # says websockets of who connects and asks for nothing, or for what is refused


def in_a_line(message: str, error: BaseException | None) -> str:
    """With where it was raised."""
    if error is None:
        return message
    walked = traceback.walk_tb(error.__traceback__)
    frames = traceback.StackSummary.extract(walked, lookup_lines=False)[-FRAMES:]  # opens no file
    places = " < ".join(f"{Path(frame.filename).name}:{frame.lineno}" for frame in reversed(frames))
    return f"{message}: {error!r} at {places}"


class FaultLines(logging.Handler):
    """warn(text): writes it, if it may."""

    def __init__(self, warn: Callable[[str], None]):
        super().__init__(logging.WARNING)
        self._warn = warn

    def emit(self, record: logging.LogRecord) -> None:
        if record.getMessage() != OF_CLIENTS:
            self._warn(in_a_line(record.getMessage(), record.exc_info[1] if record.exc_info else None))


def logger_of(warn: Callable[[str], None]) -> logging.Logger:
    """For websockets."""
    made = logging.Logger("viewimit.websockets", logging.WARNING)
    made.addHandler(FaultLines(warn))
    return made
