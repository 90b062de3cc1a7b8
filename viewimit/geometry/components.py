"""Connected components of a graph, by numpy alone."""

import numpy as np
from numpy.typing import NDArray


def connected_components(count: int, one: NDArray[np.int_], other: NDArray[np.int_]) -> NDArray[np.int_]:
    """Return the smallest member of the component of each of `count` nodes, joined by edges one[k] - other[k]."""
    group = np.arange(count)
    while (group[one] != group[other]).any():
        least = np.minimum(group[one], group[other])
        for roots in (group[one], group[other]):
            np.minimum.at(group, roots, least)
        while (group != group[group]).any():
            group = group[group]
    return group
