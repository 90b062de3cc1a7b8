"""Where E is least under noise, run for run, with one image each time and with several averaged."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.observability import sample_estimates

from .work import Task, Work

FRAMES = (1, 25)
RUNS = 600


def _clouds(task: Task) -> Mapping[int, NDArray]:
    """(RUNS, m) rad, by the number of images that are averaged."""
    rng, noise_px = np.random.default_rng(task.settings.seed), task.settings.noise_px
    moment = task.snapshot
    return {
        frames: sample_estimates(task.world, moment.fit, moment.theta_demo, noise_px, frames, RUNS, rng)
        for frames in FRAMES
    }


WORKS: Mapping[str, Work] = {"clouds": Work(_clouds)}
