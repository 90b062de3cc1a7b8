"""How many threads linear algebra takes; to be said before numpy is loaded."""

import os

VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def take_one() -> None:
    """One, unless the environment says another number: with matrices of four rows more threads only spin."""
    for name in VARIABLES:
        os.environ.setdefault(name, "1")


def take_one_alone() -> None:
    """One, whatever the environment says: beside a server."""
    for name in VARIABLES:
        os.environ[name] = "1"
