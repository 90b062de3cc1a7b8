"""How well markers are detected in rendered pictures, against their projected truth, over random postures."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...estimation.views import VIEWS
from ...simulation.rendering import RenderedEyes
from ...simulation.scene import load_scene

FALSE_PX = 3.0  # farther from its own truth than a ball's radius, a detection is of something else


@dataclass(frozen=True)
class Detection:
    """Over pictures of both arms in random postures. in_sight: share of balls the middle of whose face is in sight;
    found: share found of all; found_in_sight: of those; error_px: median, 95th, 99th percentile, largest; rms_px: of a
    coordinate; bias_px: mean error (x, y); false: detections farther than FALSE_PX from their ball, of `detections`;
    usable: fewest and median number of balls found in all four pictures, of a pair of postures."""

    scene: str
    pictures: int
    markers: int
    in_sight: float
    found: float
    found_in_sight: float
    error_px: tuple[float, float, float, float]
    rms_px: float
    bias_px: tuple[float, float]
    false: int
    detections: int
    usable: tuple[int, float]


def run(scene: str, pairs: int, seed: int = 0, tell: Callable[[float], None] = lambda share: None) -> Detection:
    """pairs of postures, demonstrator and learner, four pictures each. tell(share done)."""
    eyes, rng = RenderedEyes(load_scene(scene)), np.random.default_rng(seed)
    low, high = eyes.world.scene.lower, eyes.world.scene.upper
    offsets, sights, finds, usable = [], [], [], []
    for k in range(pairs):
        demo, own = rng.uniform(low, high, (2, len(low)))
        eyes.demo_images(demo)
        eyes.own_images(own)
        eyes.look_at("lr")  # anew: both arms stand now where they are to
        eyes.look_at("LR")
        for view in VIEWS:
            image, in_sight = eyes.truth(view)
            offsets.append(eyes.detections[view].points - image)
            sights.append(in_sight)
            finds.append(eyes.detections[view].found)
        usable.append(int(np.all(finds[-len(VIEWS) :], 0).sum()))
        tell((k + 1) / pairs)
    errors, sighted, found = np.array(offsets), np.array(sights), np.array(finds)
    away = errors[found]
    distance = np.linalg.norm(away, axis=-1)
    right = away[distance <= FALSE_PX]
    median, most, nearly_all = np.percentile(distance, (50, 95, 99)).tolist()
    bias_x, bias_y = right.mean(0).tolist()
    return Detection(
        scene=scene,
        pictures=len(VIEWS) * pairs,
        markers=found.shape[1],
        in_sight=float(sighted.mean()),
        found=float(found.mean()),
        found_in_sight=float(found[sighted].mean()),
        error_px=(median, most, nearly_all, float(distance.max())),
        rms_px=float(np.sqrt((right**2).mean())),
        bias_px=(bias_x, bias_y),
        false=int((distance > FALSE_PX).sum()),
        detections=int(found.sum()),
        usable=(min(usable), float(np.median(usable))),
    )
