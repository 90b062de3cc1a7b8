"""Opens a store by what the command line says of it."""

from pathlib import Path

import platformdirs

from .sqlite_store import SqliteStore
from .store import Store

OF_REDIS = "redis://", "rediss://", "unix://"


def open_store(where: str | None = None) -> Store:
    """where: a folder, a redis:// address, or None for the user's own folder.

    Raises OSError if it cannot be used, ValueError without the package that it needs, and for another address.
    """
    if where is not None and where.startswith(OF_REDIS):
        from .redis_store import RedisStore

        return RedisStore(where)
    if where is not None and "://" in where:  # perhaps with a password, which is not repeated
        scheme = where.partition("://")[0]
        raise ValueError(f"{scheme}:// is no address of a store: say a folder, or one of {', '.join(OF_REDIS)}")
    if where is not None:
        return SqliteStore(Path(where))
    try:
        return SqliteStore(state_folder())
    except (OSError, RuntimeError) as error:  # RuntimeError: nobody knows a home
        what = f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename else error
        raise OSError(f"{what}; say a folder that can be written, --store DIR") from None


def state_folder() -> Path:
    """Where this platform keeps a user's state."""
    return platformdirs.user_state_path("viewimit", appauthor=False)
