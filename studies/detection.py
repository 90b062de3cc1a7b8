"""How well markers are detected in rendered pictures: `python studies/detection.py`."""

import argparse
from dataclasses import dataclass

import numpy as np

from viewimit.estimation.views import VIEWS
from viewimit.experiments.bench.intervals import rms
from viewimit.simulation.eyes import require_eyes
from viewimit.simulation.rendering import SAMPLES, RenderedEyes
from viewimit.simulation.scene import load_scene

MAX_FACE_DEPTH = 1.2  # from a ball's centre to the nearest visible surface, in radii
WRONG_DETECTION_PX = 3.0  # a marker's radius: a detection farther from its marker is of something else


@dataclass(frozen=True)
class Detection:
    """Detection of markers in rendered pictures of both arms in random postures."""

    scene: str
    pictures: int
    markers: int
    in_sight: float  # share of markers the middle of whose face is visible
    found: float  # share of all markers
    found_in_sight: float  # share of those in sight
    error_px: tuple[float, float, float, float]  # median, 95th and 99th percentile, largest
    rms_px: float  # of a coordinate
    bias_px: tuple[float, float]  # mean error in x and y
    false: int  # detections farther than WRONG_DETECTION_PX from their marker
    detections: int
    usable: tuple[int, float]  # fewest and median number of markers found in all four pictures


def detect(scene: str, pairs: int, seed: int) -> Detection:
    """Detect markers in four pictures for each pair of random postures. Raises ValueError for a scene without."""
    require_eyes("rendered", load_scene(scene))
    eyes, rng = RenderedEyes(load_scene(scene)), np.random.default_rng(seed)
    low, high = eyes.world.scene.lower, eyes.world.scene.upper
    offsets, sights, finds, usable = [], [], [], []
    for _ in range(pairs):
        demo, own = rng.uniform(low, high, (2, len(low)))
        eyes.demo_images(demo)
        eyes.own_images(own)
        eyes.look_at("lr")  # once more, because both arms have reached their postures only now
        eyes.look_at("LR")
        for view in VIEWS:
            image, in_sight = truth(eyes, view)
            offsets.append(eyes.detections[view].points - image)
            sights.append(in_sight)
            finds.append(eyes.detections[view].found)
        usable.append(int(np.all(finds[-len(VIEWS) :], 0).sum()))
    in_sight, found = np.array(sights), np.array(finds)
    errors = np.array(offsets)[found]
    distance = np.linalg.norm(errors, axis=-1)
    right = errors[distance <= WRONG_DETECTION_PX]
    median, p95, p99 = np.percentile(distance, (50, 95, 99)).tolist()
    bias_x, bias_y = right.mean(0).tolist()
    return Detection(
        scene=scene,
        pictures=len(VIEWS) * pairs,
        markers=found.shape[1],
        in_sight=float(in_sight.mean()),
        found=float(found.mean()),
        found_in_sight=float(found[in_sight].mean()),
        error_px=(median, p95, p99, float(distance.max())),
        rms_px=rms(right),
        bias_px=(bias_x, bias_y),
        false=int((distance > WRONG_DETECTION_PX).sum()),
        detections=int(found.sum()),
        usable=(min(usable), float(np.median(usable))),
    )


def truth(eyes: RenderedEyes, view: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the true image of each ball, (N, 2) px, and whether the renderer shows the centre of its face, (N,)."""
    pair = "lr" if view in "lr" else "LR"
    base, camera = eyes.world.T_world_demo if pair == "lr" else eyes.world.T_world_own, eyes.cameras[view]
    points = eyes.world.points_world(eyes.theta[pair], base)
    image, inside = camera.project(points.T)
    with np.errstate(divide="ignore"):
        surface = 1 / eyes.studio.arms(camera, eyes.theta["lr"], eyes.theta["LR"]).inverse_depth.astype(float)
    last = np.array(surface.shape) - 1
    row, column = np.clip((SAMPLES * image[::-1]).astype(int), 0, last[:, None])
    depth = (points - camera.T_world_camera[:3, 3]) @ camera.T_world_camera[:3, 2]
    return image.T, inside & (np.abs(surface[row, column] - depth) < MAX_FACE_DEPTH * eyes.markers.radius)


def table(found: Detection) -> str:
    """Lay out the detection for people."""
    median, p95, p99, largest = found.error_px
    bias_x, bias_y = found.bias_px
    fewest, typical = found.usable
    return f"""{found.pictures} pictures of {found.scene}, {found.markers} markers an arm, random postures
  in sight                     {found.in_sight:8.1%}
  found, of all                {found.found:8.1%}
  found, of those in sight     {found.found_in_sight:8.1%}
  error of the middle          median {median:.3f} px, 95 % {p95:.3f}, 99 % {p99:.3f}, most {largest:.2f}
  of a coordinate              rms {found.rms_px:.3f} px, mean {bias_x:+.3f}, {bias_y:+.3f}
  false identities             {found.false} of {found.detections}
  in all four pictures         median {typical:.0f}, fewest {fewest}"""


def main(words: list[str] | None = None) -> None:
    """Print how well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", default="panda")
    parser.add_argument("--runs", type=int, default=200, help="pairs of postures")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args(words)
    print(table(detect(asked.scene, asked.runs, asked.seed)))


if __name__ == "__main__":
    main()
