"""The benchmark measures what it says; its baselines are the paper's equations."""

import numpy as np
import pytest

from viewimit.experiments import baselines, benchmark
from viewimit.scene import load_scene
from viewimit.world import World


def test_the_baselines_agree_with_each_other():
    world = World(load_scene("iiwa"))
    demo, _ = world.demo_images(np.radians([45, -60]))
    postures = np.random.default_rng(0).uniform(world.scene.lower, world.scene.upper, (100, 2))
    E, condition = baselines.batch(world, demo, postures, with_condition=True)
    np.testing.assert_allclose(E, baselines.loop(world, demo, postures), rtol=1e-9)
    assert condition.min() >= 1
    assert baselines.batch(world, demo, postures)[1] is None


def test_the_benchmark_compares_like_with_like_and_is_much_faster(monkeypatch):
    """A third of the speed known: a noisy machine may halve a ratio, a broken fast path costs far more."""
    monkeypatch.setattr(benchmark, "LOOP_SHARE", 50)
    monkeypatch.setattr(benchmark, "ROUNDS", 3)
    monkeypatch.setattr(benchmark, "SLOW_ROUNDS", 1)
    result = benchmark.run()
    assert (result.postures, result.loop_postures) == (91 * 181, 91 * 181 // 50)
    assert result.batch_agreement < 1e-8 and result.loop_agreement < 1e-8 and result.condition_agreement < 1e-8
    assert result.batch_s > 5 * result.landscape_s["epipolar"]
    assert result.loop_s > 50 * result.landscape_s["epipolar"]
    assert result.batch_s > 3 * result.condition_s
    text = benchmark.table(result)
    for name, times in result.fit_s.items():
        assert name in text and set(times) == {1, benchmark.BATCH}
        assert times[1] == pytest.approx(times[benchmark.BATCH], rel=2)  # overhead, not points, decides
    assert f"{result.loop_postures} postures, scaled" in text
