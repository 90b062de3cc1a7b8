"""Assignments cost as little as those of scipy, and of a search through all of them."""

from itertools import combinations, permutations, product

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from viewimit.geometry.assignment import assign, cheapest_pairs


@pytest.mark.parametrize(
    "draw",
    [
        lambda rng, rows, columns: rng.uniform(-1, 1, (rows, columns)),
        lambda rng, rows, columns: rng.integers(0, 4, (rows, columns)).astype(float),  # many equal paths
        lambda rng, rows, columns: np.outer(rng.random(rows), rng.random(columns)),  # paths are long
    ],
    ids=["uniform", "few integers", "rank one"],
)
def test_an_assignment_costs_as_little_as_that_of_scipy(draw):
    for seed, (rows, columns) in product(range(5), ((1, 1), (1, 4), (3, 7), (10, 10), (16, 20), (40, 40))):
        rng = np.random.default_rng([seed, rows, columns])
        cost = draw(rng, rows, columns)
        found, (i, j) = assign(cost), linear_sum_assignment(cost)
        assert len(set(found.tolist())) == rows
        assert cost[range(rows), found].sum() == pytest.approx(cost[i, j].sum(), abs=1e-12)


@pytest.mark.parametrize("rows, columns", [(1, 1), (2, 3), (3, 2), (4, 4)])
def test_some_pairs_cost_as_little_as_the_best_of_all_choices(rows, columns):
    for seed in range(10):
        cost = np.random.default_rng(seed).uniform(-1, 1, (rows, columns))
        for count in range(min(rows, columns) + 1):
            found = cheapest_pairs(cost, count)
            paired = np.flatnonzero(found >= 0)
            assert len(paired) == len(set(found[paired].tolist())) == count
            all_choices = (
                sum(cost[i, j] for i, j in zip(some, order))
                for some in combinations(range(rows), count)
                for order in permutations(range(columns), count)
            )
            assert cost[paired, found[paired]].sum() == pytest.approx(min(all_choices), abs=1e-12)


def test_costs_that_have_no_assignment_are_refused():
    with pytest.raises(ValueError, match="3 rows cannot have a column each of 2"):
        assign(np.zeros((3, 2)))
    with pytest.raises(ValueError, match="finite"):
        assign(np.array([[0.0, np.nan]]))
