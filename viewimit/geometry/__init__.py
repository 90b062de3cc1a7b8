"""Projective and rigid geometry on plain arrays: no robot, no world, no page.

The number of threads of linear algebra must be set before numpy is imported, so this file imports nothing of it.
"""

import os

BLAS_VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def limit_blas_threads(override: bool = False) -> None:
    """Use one thread, unless the environment sets another number: with matrices of four rows more threads only spin.

    override: ignore the environment, as in a process beside a server.
    """
    for name in BLAS_VARIABLES:
        if override:
            os.environ[name] = "1"
        else:
            os.environ.setdefault(name, "1")
