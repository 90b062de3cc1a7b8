"""Clouds of postures in which E was least under noise."""

from collections.abc import Collection, Mapping

import numpy as np

from viewimit.drawing import svg
from viewimit.drawing.lessons import cloud
from viewimit.drawing.lessons.cloud import Cloud, draw_cloud

from ..joint_names import joint_names
from ..stage import Stage
from ..works.noise import FRAMES, RUNS
from .figure_kind import FigureKind

NAMES = {1: "one image each time", FRAMES[1]: f"{FRAMES[1]} images averaged each time"}


def _clouds(stage: Stage, layers: Collection[str], small: bool) -> str:
    made = stage.made.get("clouds", {})
    found = [
        Cloud(layer, NAMES[frames], np.degrees(made[frames]))
        for layer, frames in zip(("one", "averaged"), FRAMES)
        if frames in made
    ]
    noise = f"noise {svg.short(stage.session.settings.noise_px)} px in all four images"
    note = f"a dot a run, {RUNS} runs, {noise}"
    return draw_cloud(joint_names(stage.session.scene), stage.moment.theta_demo, found, layers, note, stage.narrow)


FIGURES: Mapping[str, FigureKind] = {"clouds": FigureKind(_clouds, cloud.LAYERS, works=("clouds",))}
