"""The linear assignment problem: pair rows with columns at the least total cost.

Shortest augmenting paths: each row is added in turn, along the path of least reduced cost to a free column. The dual
variables keep all reduced costs at 0 or more, so no negative cycle arises. O(n² m) for n rows and m columns.

References
----------
Jonker and Volgenant, "A shortest augmenting path algorithm for dense and sparse linear assignment problems",
Computing 38, 1987.
"""

import numpy as np
from numpy.typing import NDArray


def assign(cost: NDArray[np.float64]) -> NDArray[np.int_]:
    """Pair every row with a column of its own. cost: (n, m) finite costs, n ≤ m. Returns (n,), column of each row; the
    sum of their costs is the least possible. Raises ValueError for more rows than columns, or a cost that is not
    finite."""
    n, m = cost.shape
    if n > m:
        raise ValueError(f"{n} rows cannot have a column each of {m}: transpose the costs")
    if not np.isfinite(cost).all():
        raise ValueError("costs must be finite")
    row_dual, column_dual = cost.min(1), np.zeros(m)
    row_of, column_of = np.full(m, -1), np.full(n, -1)
    for row, column in enumerate(cost.argmin(1).tolist()):  # most rows find their cheapest column free
        if row_of[column] < 0:
            row_of[column], column_of[row] = row, column
    for start in np.flatnonzero(column_of < 0).tolist():
        distance, before = np.full(m, np.inf), np.full(m, -1)
        reached, row, length = np.zeros(m, bool), start, 0.0
        while True:
            through = length + cost[row] - row_dual[row] - column_dual
            shorter = ~reached & (through < distance)
            distance[shorter], before[shorter] = through[shorter], row
            column = int(np.where(reached, np.inf, distance).argmin())
            length, reached[column] = distance[column], True
            if row_of[column] < 0:
                break
            row = int(row_of[column])
        inside = np.flatnonzero(reached & (row_of >= 0))
        row_dual[row_of[inside]] += length - distance[inside]
        row_dual[start] += length
        column_dual[inside] -= length - distance[inside]
        while True:  # exchange pairs along the path, back to its start
            row = int(before[column])
            row_of[column], column_of[row], column = row, column, int(column_of[row])
            if row == start:
                break
    return column_of


def cheapest_pairs(cost: NDArray[np.float64], count: int) -> NDArray[np.int_]:
    """Pair some rows with columns. cost: (n, m) finite costs; count: number of pairs, at most n and m. Returns (n,),
    column of each row, -1 of those left out; the sum of the pairs' costs is the least possible."""
    n, m = cost.shape
    if count == n <= m:
        return assign(cost)
    # A row left out takes one of n - count further columns, and a column left out one of m - count further rows.
    square = np.zeros((n + m - count, n + m - count))
    square[:n, :m] = cost
    square[n:, m:] = 2 * float(np.abs(cost).sum()) + 1.0  # never taken
    columns = assign(square)[:n]
    return np.where(columns < m, columns, -1)
