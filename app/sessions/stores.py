"""Opens a store by what the command line says of it."""

import os
import sys
from pathlib import Path

from .sqlite_store import SqliteStore
from .store import Store


def open_store(where: str | None = None) -> Store:
    """where: a folder, a redis:// address, or None for the user's own folder.

    Raises OSError if it cannot be used, ValueError without the package that it needs.
    """
    if where is not None and where.startswith(("redis://", "rediss://", "unix://")):
        from .redis_store import RedisStore

        return RedisStore(where)
    return SqliteStore(state_folder() if where is None else Path(where))


def state_folder() -> Path:
    """Where this platform keeps a user's state."""
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    return base / "viewimit"
