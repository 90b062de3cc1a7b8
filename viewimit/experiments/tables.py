"""Results as tables: columns of one length, by name, units in the names."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Table = dict[str, NDArray]
Tables = dict[str, Table]


def joint_columns(joints: Sequence[int], what: str, degrees: NDArray) -> Table:
    """degrees: (k, m) → a column a joint, such as theta2_deg."""
    return {f"{what}{joint}_deg": degrees[:, k] for k, joint in enumerate(joints)}


def stacked(parts: list[dict]) -> Table:
    """Tables of the same columns, one below the other. What is the same throughout a part may be given once."""
    if not parts:
        return {}
    lengths = [max(np.size(column) for column in part.values()) for part in parts]
    return {
        name: np.concatenate([np.broadcast_to(part[name], length) for part, length in zip(parts, lengths)])
        for name in parts[0]
    }
