"""Tracked points from files, one reader a format; all in pixels, (0, 0) at the picture's upper left or in the middle of
its first pixel, which makes no difference as long as all views agree.

What is not read is refused with what converts it.
"""

from .reading import read_files, read_view
from .tidy import read_tidy, write_tidy
from .track import Row, Track, TrackedPoints

__all__ = ["Row", "Track", "TrackedPoints", "read_files", "read_tidy", "read_view", "write_tidy"]
