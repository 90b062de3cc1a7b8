"""Random scenes hold what they promise, and the trust region arrives in a seeded set of them, with any head."""

import numpy as np
import pytest

from viewimit.estimation.residuals import conflict
from viewimit.estimation.transfers import projective
from viewimit.experiments.bench import draws
from viewimit.experiments.bench.benchmark import Context
from viewimit.experiments.bench.draws import draw_scene, resize, write_scene
from viewimit.experiments.bench.scenes import CASES, Run, outcome, run
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


@pytest.mark.parametrize("any_head", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_a_scene_is_read_back_as_it_was_written_and_shows_both_arms(seed, any_head, tmp_path):
    drawn = draw_scene(np.random.default_rng(seed), any_head)
    assert load_scene(write_scene(drawn.scene, tmp_path, "drawn")) == drawn.scene
    world = World(drawn.scene, drawn.points)
    resize(world, drawn.size)
    corners = np.stack(np.meshgrid(*np.radians(drawn.scene.range_deg)), -1).reshape(-1, 2)
    assert len(world.body) == drawn.points
    for theta in corners:
        views = world.look(theta, theta)
        assert views.visible.mean() > 0.9
    assert draw_scene(np.random.default_rng(seed), any_head) == drawn


def test_scenes_differ_in_all_that_is_drawn():
    scenes = [draw_scene(np.random.default_rng(seed)).scene for seed in range(20)]
    assert {scene.robot for scene in scenes} == set(draws.ROBOTS)
    assert len({scene.head.baseline for scene in scenes}) == len({scene.learner.yaw_deg for scene in scenes}) == 20
    drawn = [draw_scene(np.random.default_rng(seed), any_head=True) for seed in range(12)]
    heads = [each.scene.head for each in drawn]
    assert all(0 < head.toe_in_deg < 20 and head.left.focal != head.right.focal for head in heads)
    assert all(0.8 < each.size < 1.2 and 10 <= each.points <= 40 for each in drawn)
    assert len({each.size for each in drawn}) == len({head.toe_in_deg for head in heads}) == 12


@pytest.mark.parametrize("seed", range(8))
def test_at_the_true_posture_the_projective_transfer_leaves_nothing_in_any_of_them(seed):
    """Parallel axes: exact but for the prior of p. A degree away in each joint E is ten thousand times as large."""
    rng = np.random.default_rng([2, seed])
    drawn = draw_scene(rng)
    scene, world = drawn.scene, World(drawn.scene, drawn.points)
    for theta in rng.uniform(scene.lower, scene.upper, (5, 2)):
        away = theta + np.radians(1.0) * np.where(theta > (scene.lower + scene.upper) / 2, -1, 1)
        E_true, E_away = (conflict(projective.fit(views).residual(views)) for views in
                          (world.look(theta, theta), world.look(theta, away)))  # fmt: skip
        assert E_true < 1e-5 and E_away > 1e4 * E_true


@pytest.mark.parametrize("scenes", [8, pytest.param(12, marks=pytest.mark.slow)])
def test_every_start_of_a_seeded_set_of_scenes_arrives_also_with_any_head_if_images_are_rectified(scenes):
    """Of 1,000 runs a row 98 and 97 % are claimed; the median is 7 motions, 95 % take up to 11."""
    parallel, rectified = run(
        Settings(),
        scenes=scenes,
        pairs=2,
        seed=4,
        max_motions=60,
        cases=(CASES[0], CASES[2]),
        context=Context.in_processes(1),
    )
    for found in (parallel, rectified):
        assert found.runs == found.claimed.count == found.ended[1.0].count == 2 * scenes
        assert found.beyond.count == found.falsely.count == 0 and found.motions_median <= 8 and found.motions_95 <= 14
    (raw,) = run(
        Settings(), scenes=8, pairs=1, seed=4, max_motions=60, cases=CASES[1:2], context=Context.in_processes(1)
    )
    assert raw.ended[1.0].count < 4


def test_what_the_bound_allows_is_what_normal_errors_reach():
    rng = np.random.default_rng(0)
    bounds = rng.choice([0.0, 0.2, 0.6, 1.5], 4000)
    worst = lambda error: np.array([0.0, error])
    of = lambda b: Run(worst(abs(rng.normal(0, b))), worst(b), worst(2 * b), worst(b), 5, True, 1.0)
    runs = [of(b) for b in bounds]
    found = outcome("row", runs)
    for near, reached in found.ended.items():
        assert abs(found.at_most[near] - reached.share) < 4 * np.sqrt(0.25 / len(runs))
        assert found.at_most_as_seen[near] < found.at_most[near]
    assert found.bound_as_seen_deg == 2 * found.bound_deg
