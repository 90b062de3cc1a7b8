"""Makes examples/two_webcams: what two webcams see while one arm imitates another that wears the same printed markers.

    python -m viewimit.assets.build_recording [FOLDER]

Two Pandas stand side by side, 2.5 m before two cameras that do not move. Each wears flat cards with ArUco markers:
number k is on the learner where FIRST_OF_DEMONSTRATOR + k is on the demonstrator. The learner has mass and motors in
PyBullet, so it sags. The pictures are rendered, blurred, made noisy and compressed, as a webcam's. The learner sees
what OpenCV detects in them, and imitates by `Session.of`. The folder then holds a pair of pictures of each posture, and
truth.json: the angles of both arms, as commanded and as they were, and where each marker really was.
"""

import json
import sys
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ..estimation.views import FourViews
from ..experiments.bench.draws import surface_points
from ..loop.session import Session
from ..sensing.detection import FIRST_OF_DEMONSTRATOR, Fiducials
from ..simulation.arms import open_arm
from ..simulation.camera import Camera
from ..simulation.depth_buffer import DepthBuffer, Triangles
from ..simulation.rendering import SAMPLES, Room, Skin, _mean
from ..simulation.robot import BodyPoints, Markers, link_meshes
from ..simulation.scene import Scene, load_scene
from ..simulation.world import World
from . import ROOT

SCENE = """extends = "panda"
title = "Two Pandas before two webcams"
start_deg = [20, -50]

[head]
position = [-1.5, 0.2, 1.3]
baseline = 0.5
image = [1280, 720]
focal = 1250
centre = [640, 360]
gaze_demonstrator = [0.9, 0.2, 0.8]
gaze_learner = [0.9, 0.2, 0.8]

[demonstrator]
position = [0.9, 0.6, 0.4]
yaw_deg = 70

[learner]
position = [0.9, -0.6, 0.4]
yaw_deg = 70
"""
DEMONSTRATOR_DEG = (50.0, -95.0)
DICTIONARY = "4X4_50"
CELLS = 8  # of a card's side: 4 of the pattern, the marker's rim, and the paper around it
CELL_M = 0.0075  # a card of 60 mm with a marker of 45 mm
OFF_M = 0.012  # of a card from the surface
WHITE, BLACK = 0.95, 0.06
CARDS, APART_M = 20, 0.08  # on each arm; least distance of two, in any posture
SAMPLED, FACING = 1500, 0.6  # places on the surface; least cosine between a card's normal and the direction to a camera
BLUR_PX, NOISE, QUALITY = 0.6, 1.0, 80  # standard deviations, of 255; of WebP
LEVELS = 255

Floats = NDArray[np.float64]


class Cards:
    """Markers on flat cards, on both arms. places: their middles; normals: (N, 3) outwards, in the links' frames."""

    def __init__(self, places: BodyPoints, normals: Floats):
        self.places, self._normals = places, normals
        u = np.cross(normals, np.where(np.abs(normals[:, 2:]) < 0.9, [[0.0, 0, 1]], [[1.0, 0, 0]]))
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        self._axes = np.stack([u, -np.cross(normals, u)], 1)  # (N, 2, 3), right and down on the card, seen from outside
        corners = (np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) - CELLS / 2)[None, None]
        cells = np.stack(np.meshgrid(np.arange(CELLS), np.arange(CELLS)), -1)[:, :, None]
        self._grid = CELL_M * (corners + cells).reshape(-1, 2)  # (4 CELLS², 2) m: corners of all cells
        first = 4 * np.arange(CELLS**2)[:, None]
        self._faces = np.concatenate([first + [0, 2, 1], first + [0, 3, 2]])

    def at(self, T_world_links: Floats, first_number: int, fiducials: Fiducials) -> Triangles:
        """Return the cards of one arm; the first one has this number."""
        R = T_world_links[self.places.link, :3, :3]
        middles = self.places.at(T_world_links)
        u, v = np.moveaxis(self._axes @ np.swapaxes(R, 1, 2), 1, 0)
        vertices = middles[:, None] + self._grid[:, :1] * u[:, None] + self._grid[:, 1:] * v[:, None]
        normals = np.repeat((R @ self._normals[:, :, None])[..., 0][:, None], len(self._grid), 1)
        white = np.array([fiducials.cells(first_number + k, CELLS) for k in range(len(middles))])
        grey = np.repeat(np.where(white, WHITE, BLACK).reshape(len(middles), -1), 4, 1)
        faces = np.concatenate([self._faces + k * len(self._grid) for k in range(len(middles))])
        return Triangles(vertices.reshape(-1, 3), faces, normals.reshape(-1, 3), grey.ravel())


class Studio:
    """Renders both arms with their cards."""

    def __init__(self, world: World, cards: Cards, seed: int = 0):
        self.world, self.cards, self.fiducials = world, cards, Fiducials(DICTIONARY)
        self._skin = Skin(link_meshes(world.scene.robot), Markers(radius=0.01, balls=()))
        self._rooms = [Room(world.scene).seen_by(camera) for camera in world.own_cameras]
        self._rng = np.random.default_rng(seed)

    def pictures(self, theta_demo: Floats, theta_own: Floats) -> list[NDArray[np.uint8]]:
        """Take the left and the right picture, compressed: two files."""
        return [self._picture(side, theta_demo, theta_own) for side in (0, 1)]

    def _picture(self, side: int, theta_demo: Floats, theta_own: Floats) -> NDArray[np.uint8]:
        world, (behind, room) = self.world, self._rooms[side]
        buffer = DepthBuffer(world.own_cameras[side], SAMPLES)
        for theta, base, first in (
            (theta_own, world.T_world_own, 0),
            (theta_demo, world.T_world_demo, FIRST_OF_DEMONSTRATOR),
        ):
            frames = world.link_frames(theta, base)
            buffer.add_triangles(self._skin.at(frames))
            buffer.add_triangles(self.cards.at(frames, first, self.fiducials))
        sharp = _mean(np.where(buffer.inverse_depth > behind, buffer.colours, room))[..., 0].astype(float)
        seen = cv2.GaussianBlur(sharp, (0, 0), BLUR_PX) + NOISE * self._rng.standard_normal(sharp.shape)
        return cv2.imencode(
            ".webp", np.clip(np.round(seen), 0, LEVELS).astype(np.uint8), [cv2.IMWRITE_WEBP_QUALITY, QUALITY]
        )[1]

    def truth(self, theta: Floats, base: Floats, camera: Camera) -> Floats:
        """Return where the markers' middles are in a picture, (N, 2) px."""
        points = self.cards.places.at(self.world.link_frames(theta, base))
        return camera.project(points.T)[0].T


def choose_cards(world: World, postures: Floats) -> Cards:
    """Choose places that face both cameras in the most postures, (G, m) rad, and are apart from each other."""
    links = range(len(world.robot.joints) + 1)
    found, normals = surface_points(world.scene.robot, links, SAMPLED, np.random.default_rng(2))
    places = BodyPoints(found.link, found.local + OFF_M * normals)
    tips = BodyPoints(found.link, places.local + normals)
    seen = np.zeros((2, SAMPLED))
    where = np.array([places.at(world.link_frames(theta, world.T_world_own)) for theta in postures])
    for arm, base in enumerate((world.T_world_own, world.T_world_demo)):
        for theta in postures:
            frames = world.link_frames(theta, base)
            at = places.at(frames)
            for camera in world.own_cameras:
                towards = camera.T_world_camera[:3, 3] - at
                facing = ((tips.at(frames) - at) * towards).sum(1) / np.linalg.norm(towards, axis=1)
                seen[arm] += (facing > FACING) & _clear(world, camera, frames, at)
    score, chosen = seen.min(0) + 1e-6 * seen.sum(0), list[int]()
    for link in links:  # some on every link, and then the best
        _add(chosen, np.flatnonzero(places.link == link), score, where, 2)
    _add(chosen, np.arange(SAMPLED), score, where, CARDS - len(chosen))
    chosen.sort(key=lambda k: places.link[k])
    return Cards(BodyPoints(places.link[chosen], places.local[chosen]), normals[chosen])


def _add(chosen: list[int], among: NDArray[np.intp], score: Floats, where: Floats, count: int) -> None:
    """Add places with the highest scores. where: (G, K, 3) m in the postures."""
    for k in among[np.argsort(-score[among], kind="stable")]:
        if count == 0 or score[k] < 1:
            return
        if (np.linalg.norm(where[:, chosen] - where[:, [k]], axis=-1) > APART_M).all():
            chosen.append(int(k))
            count -= 1


def _clear(world: World, camera: Camera, T_world_links: Floats, at: Floats) -> NDArray[np.bool_]:
    """Whether nothing of the arm is before these places, (N, 3) m."""
    buffer = DepthBuffer(camera, 1)
    buffer.add_triangles(Skin(link_meshes(world.scene.robot), Markers(radius=0.01, balls=())).at(T_world_links))
    (x, y), inside = camera.project(at.T)
    depth = (at - camera.T_world_camera[:3, 3]) @ camera.T_world_camera[:3, 2]
    row, column = np.clip(y.astype(int), 0, camera.height - 1), np.clip(x.astype(int), 0, camera.width - 1)
    return inside & (buffer.inverse_depth[row, column] < 1 / (depth - OFF_M / 2))


class SimulatedWebcams:
    """Arm and eyes of `Session.of`, which keep what they did and saw."""

    noise_px = 0.05

    def __init__(self, scene: Scene, demonstrator_deg: tuple[float, ...]):
        self.world = World(scene, 10)
        grid = np.radians([(a, b) for a in (15, 35, 55) for b in (-110, -80, -45)])
        self.studio = Studio(self.world, choose_cards(self.world, grid))
        self.lower, self.upper, self.start = scene.lower, scene.upper, np.radians(scene.start_deg)
        self._body = open_arm("pybullet", scene)
        self.demonstrator = self._body.settle(np.radians(demonstrator_deg))
        self.commanded = self.start
        self.theta = self._body.settle(self.start)
        self.kept: list[dict] = []

    def move(self, theta: Floats) -> Floats:
        self.theta = self._body.drive((), self.start, self.theta, self.commanded, theta)
        self.commanded = theta
        return theta  # the learner knows where it sent the arm, not how far that sags

    def look(self) -> FourViews:
        files = self.studio.pictures(self.demonstrator, self.theta)
        pair = [self.studio.fiducials.detect(cv2.imdecode(file, cv2.IMREAD_COLOR)) for file in files]
        moment = {"commanded": self.commanded, "theta": self.theta, "files": files}
        if not self.kept or not np.array_equal(self.kept[-1]["commanded"], self.commanded):
            self.kept.append(moment)
        own, unseen = range(len(self.studio.cards.places)), np.full(2, np.nan)
        return FourViews.from_images(
            *([seen.get(first + k, unseen) for k in own] for first in (FIRST_OF_DEMONSTRATOR, 0) for seen in pair)
        )


def main(folder: Path) -> None:
    robot = SimulatedWebcams(load_scene(SCENE), DEMONSTRATOR_DEG)
    result = Session.of(robot, robot, frames=1).run(40)
    folder.mkdir(parents=True, exist_ok=True)
    for path in (*folder.glob("*.webp"), *folder.glob("truth.json")):
        path.unlink()
    world, frames = robot.world, []
    for number, moment in enumerate(robot.kept):
        for side, file in zip(("left", "right"), moment["files"]):
            folder.joinpath(f"{number:02}_{side}.webp").write_bytes(file.tobytes())
        markers = {
            name: {
                f"{arm}_{side}": robot.studio.truth(theta, base, camera).round(2).tolist()
                for side, camera in zip(("left", "right"), world.own_cameras)
            }
            for name, arm, theta, base in (
                ("learner", "own", moment["theta"], world.T_world_own),
                ("demonstrator", "demo", robot.demonstrator, world.T_world_demo),
            )
        }
        frames.append(
            {
                "commanded_deg": np.degrees(moment["commanded"]).round(4).tolist(),
                "learner_deg": np.degrees(moment["theta"]).round(4).tolist(),
                "markers_px": {**markers["demonstrator"], **markers["learner"]},
            }
        )
    truth = {
        "status": str(result.status),
        "motions": result.motions,
        "moving_joints": world.scene.moving_joints,
        "demonstrator_deg": np.degrees(robot.demonstrator).round(4).tolist(),
        "dictionary": DICTIONARY,
        "first_of_demonstrator": FIRST_OF_DEMONSTRATOR,
        "frames": frames,
    }
    folder.joinpath("truth.json").write_text(json.dumps(truth, separators=(",", ":")) + "\n", "utf-8")
    error = np.abs(np.degrees(result.theta) - truth["demonstrator_deg"]).max()
    print(
        f"{result.status} after {result.motions} motions, {error:.2f}° off; {len(frames)} pairs of pictures in {folder}"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT.parent / "examples" / "two_webcams")
