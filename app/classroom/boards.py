"""Opens a class's board in the store that is there."""

from pathlib import Path

from ..sessions.stores import state_folder
from .board import Board
from .local_board import LocalBoard


def open_board(store: str | None, name: str, shared: bool) -> Board:
    """store: as `open_store` has it; name: of the class; shared: with other processes of this machine.

    Raises OSError if it cannot be used, ValueError without the package that it needs.
    """
    if store is not None and store.startswith(("redis://", "rediss://", "unix://")):
        from .redis_board import RedisBoard

        return RedisBoard(store, name)
    if not shared:
        return LocalBoard()
    from .sqlite_board import SqliteBoard

    return SqliteBoard(state_folder() if store is None else Path(store), name)
