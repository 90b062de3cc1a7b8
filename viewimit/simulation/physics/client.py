"""A connection to PyBullet of one's own, and silence: it prints to the process's standard output, past Python."""

import contextlib
import os
import sys
from collections.abc import Iterator


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """What C code prints meanwhile, on either stream, goes nowhere: standard output belongs to the commands."""
    sys.stdout.flush()
    sys.stderr.flush()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    kept = [(stream, os.dup(stream)) for stream in (1, 2)]
    try:
        for stream, _ in kept:
            os.dup2(nowhere, stream)
        yield
    finally:
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)
        os.close(nowhere)


with quiet():
    import pybullet  # noqa: F401 - says when it was built
    from pybullet_utils.bullet_client import BulletClient


def connect() -> BulletClient:
    """A world of its own, without a window; it ends with the last reference to it."""
    with quiet():
        return BulletClient(pybullet.DIRECT)
