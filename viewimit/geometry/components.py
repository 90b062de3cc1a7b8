"""Connected components of a graph, by numpy alone."""

import numpy as np
from numpy.typing import NDArray


def connected_components(count: int, one: NDArray[np.int_], other: NDArray[np.int_]) -> NDArray[np.int_]:
    """Return the smallest member of the component of each of `count` nodes, joined by edges one[k] - other[k]."""
    group = np.arange(count)
    while True:
        before = group.copy()
        least = np.minimum(group[one], group[other])
        np.minimum.at(group, one, least)
        np.minimum.at(group, other, least)
        group = group[group]
        if (group == before).all():
            return group
