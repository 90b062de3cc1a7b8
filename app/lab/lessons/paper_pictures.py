"""Pictures of a handout: the camera images of a step, both arms from outside, maps of E, in black and white."""

from collections.abc import Collection, Sequence

import numpy as np
from contourpy import contour_generator
from numpy.typing import NDArray

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.drawing.export.engine_scene import engine_scene
from viewimit.geometry.affine import LINE_VIEWS, POINT_VIEWS
from viewimit.simulation.appearance import Silhouettes
from viewimit.simulation.robot import link_meshes

from .sheet import FILL, GREY, INK, PALE, Canvas, text_width
from .situation import Situation

VIEWS = "lrLR"
MARGIN_SHARE = 0.12  # of an arm's size, around it
MIN_SIZE_PX = 60.0
LEVELS = (3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)  # px², of contours
MAP_STEP_DEG = 2.0
LABEL_PT = 7.5
RAY = 1.25  # length of a ray that is drawn, times its way to the mark
AZIMUTH, ELEVATION = np.radians(-62.0), np.radians(24.0)  # of the view from outside
Array = NDArray[np.float64]
Box = tuple[float, float, float, float]  # left, top, width, height [mm]


class Frame:
    """A rectangle on the paper that shows a part of a plane; its axes may point either way."""

    def __init__(
        self, left: float, top: float, width: float, height: float, lower: Array, upper: Array, up: bool = False
    ):
        self.left, self.top, self.width, self.height = left, top, width, height
        size = np.maximum(np.asarray(upper, float) - lower, 1e-9)
        self.scale = min(width / size[0], height / size[1])  # mm for each unit
        self._middle, self._up = (np.asarray(lower, float) + upper) / 2, up

    def place(self, points: Array) -> list[tuple[float, float]]:
        """Points (…, 2) of the plane → mm on the paper."""
        away = (np.atleast_2d(points) - self._middle) * self.scale
        x = self.left + self.width / 2 + away[:, 0]
        y = self.top + self.height / 2 + (-away[:, 1] if self._up else away[:, 1])
        return list(zip(x.tolist(), y.tolist()))

    def border(self, canvas: Canvas, name: str = "") -> None:
        """Draw its edge, and a name in its corner."""
        right, bottom = self.left + self.width, self.top + self.height
        corners = [(self.left, self.top), (right, self.top), (right, bottom), (self.left, bottom)]
        canvas.path(corners, INK, 0.3, closed=True)
        if name:
            canvas.text((self.left + 1.6, self.top + 4.6), name, 11, True)

    def line(self, canvas: Canvas, line: Array, dashed: bool = False, name: str = "") -> None:
        """Draw a line a x + b y + c = 0 of the plane across the frame."""
        normal = line[:2] / np.hypot(*line[:2])
        foot = self._middle - normal * (normal @ self._middle + line[2] / np.hypot(*line[:2]))
        along = np.array([-normal[1], normal[0]])
        ends = self._clipped(self.place(foot)[0], (along[0], -along[1] if self._up else along[1]))
        if ends is None:
            return
        canvas.path(ends, INK, 0.4, dashes=(2.0, 1.2) if dashed else None)
        if name:
            (x0, y0), (x1, y1) = ends
            share = 0.2 if dashed else 0.8
            length = np.hypot(x1 - x0, y1 - y0)
            offset = np.array([y1 - y0, x0 - x1]) / length * (1.6 if x1 > x0 else -1.6)
            x, y = x0 + share * (x1 - x0) + offset[0], y0 + share * (y1 - y0) + offset[1]
            x = min(max(x - text_width(name, LABEL_PT) / 2, self.left + 1), self.left + self.width - 14)
            canvas.text((x, y - abs(y1 - y0) / length * text_width(name, LABEL_PT) / 2), name, LABEL_PT, colour=GREY)

    def _clipped(self, at: tuple[float, float], along: tuple[float, float]) -> list[tuple[float, float]] | None:
        low, high = -1e9, 1e9
        for start, step, first, last in (
            (at[0], along[0], self.left, self.left + self.width),
            (at[1], along[1], self.top, self.top + self.height),
        ):
            if abs(step) < 1e-12:
                if not first <= start <= last:
                    return None
                continue
            ends = sorted(((first - start) / step, (last - start) / step))
            low, high = max(low, ends[0]), min(high, ends[1])
        if low >= high:
            return None
        return [(at[0] + t * along[0], at[1] + t * along[1]) for t in (low, high)]


def image(canvas: Canvas, box: Box, situation: Situation, view: str, layers: Collection[str]) -> Frame:
    """Draw one of the four images with the layers that paper can show. box: left, top, width, height [mm]."""
    k, moment = VIEWS.index(view), situation.start
    pair, eye = divmod(k, 2)
    bodies = _silhouettes(situation).bodies(moment)
    arm = (bodies.demo, bodies.own)[pair]
    hulls, points = arm.hulls[eye], (moment.views.demo, moment.views.own)[pair][:, 2 * eye : 2 * eye + 2]
    found = moment.recovered[:, 2 * eye : 2 * eye + 2] if pair else points
    ghost = _silhouettes(situation).bodies(_at_demonstrator(situation)).own.hulls[eye] if "ghost" in layers else None
    shown = [hulls.reshape(-1, 2), points, *([found] if pair and "recovered points" in layers else [])]
    room = np.concatenate([*shown, *([] if ghost is None else [ghost.reshape(-1, 2)])])
    margin = max(float(np.ptp(room, axis=0).max()), MIN_SIZE_PX) * MARGIN_SHARE
    frame = Frame(*box, np.nanmin(room, 0) - margin, np.nanmax(room, 0) + margin)
    if ghost is not None:
        for hull in ghost:
            canvas.path(frame.place(hull), GREY, 0.25, closed=True, dashes=(1.0, 0.8))
    for hull in hulls:
        canvas.path(frame.place(hull), PALE, 0.2, FILL, closed=True)
    chosen = situation.chosen
    if "chosen" in layers or "own chosen" in layers:
        at = frame.place(points[chosen or 0])[0]
        canvas.circle(at, 0.7, "", fill=INK)
        canvas.circle(at, 2.2, INK, 0.4)
    if "goal" in layers:
        goal, _ = situation.world.own_images(situation.start.theta_demo)
        for at in frame.place(np.asarray(goal)[:, 2 * eye : 2 * eye + 2]):
            canvas.circle(at, 1.1, GREY, 0.3)
    if {"points", "own points", "five points"} & set(layers):
        for at in frame.place(points):
            canvas.circle(at, 0.8, INK, 0.2, INK if pair else "#ffffff")
    if "recovered points" in layers or "crossing" in layers:
        which = range(len(found)) if "recovered points" in layers else [chosen or 0]
        for i in which:
            _diamond(canvas, frame.place(found[i])[0])
            if "arrows" in layers:
                canvas.path(frame.place(np.array([found[i], points[i]])), INK, 0.35)
    lines = moment.epipolar_lines(chosen or 0) if chosen is not None else None
    for name, source in (("line from l", 0), ("line from r", 1)):
        if name in layers and lines is not None:
            frame.line(
                canvas, lines[int(np.flatnonzero((LINE_VIEWS == k) & (POINT_VIEWS == source))[0])], bool(source), name
            )
    frame.border(canvas, view)
    return frame


def _diamond(canvas: Canvas, at: tuple[float, float], size: float = 1.5) -> None:
    x, y = at
    canvas.path([(x - size, y), (x, y - size), (x + size, y), (x, y + size)], INK, 0.35, closed=True)


def _silhouettes(situation: Situation) -> Silhouettes:
    meshes = {link: mesh.vertices for link, mesh in link_meshes(situation.scene.robot).items()}
    return Silhouettes(meshes, situation.world)


def _at_demonstrator(situation: Situation):
    session = situation.session()
    return session.observe(situation.start.theta_demo, situation.start)


def ruler(canvas: Canvas, frame: Frame, unit: str = "px") -> float:
    """Draw a ruler under a picture, in the picture's unit; return the height that it takes [mm]."""
    top, whole = frame.top + frame.height + 1.2, frame.width / frame.scale
    step = next(s for s in (1, 2, 5, 10, 20, 50, 100, 200, 500) if whole / s <= 60)
    for k in range(int(whole / step) + 1):
        x = frame.left + k * step * frame.scale
        canvas.path([(x, top), (x, top + (2.4 if k % 10 == 0 else 1.6 if k % 5 == 0 else 1.0))], INK, 0.15)
        if k % 10 == 0:
            words = f"{k * step:g}" if k else f"0 {unit}"
            shift = 0 if k == 0 else text_width(words, 6.5) / 2
            canvas.text((x - shift, top + 5.0), words, 6.5, colour=GREY)
    return 7.0


def posture_map(
    canvas: Canvas,
    box: Box,
    situation: Situation,
    with_E: bool,
    start: Sequence[float] | None,
) -> float:
    """Draw a map of both joints: empty, or with contours of E and its lowest place; return its height [mm]."""
    left, top, width, _ = box
    low, high = np.degrees(situation.scene.lower), np.degrees(situation.scene.upper)
    inside = 8.0, 4.0  # mm for the numbers of both axes
    room = width - inside[0] - 3.0
    height = room * float((high[0] - low[0]) / (high[1] - low[1]))
    lower, upper = np.array([low[1], low[0]]), np.array([high[1], high[0]])
    frame = Frame(left + inside[0], top, room, height, lower, upper, up=True)
    for axis, name in ((1, "x"), (0, "y")):
        for value in np.arange(np.ceil(low[axis] / 30) * 30, high[axis] + 1, 30.0):
            ends = [(value, low[0]), (value, high[0])] if name == "x" else [(low[1], value), (high[1], value)]
            placed = frame.place(np.array(ends))
            canvas.path(placed, PALE, 0.15)
            words = f"{value:g}°".replace("-", "−")
            if name == "x":
                canvas.text((placed[0][0] - text_width(words, 6.5) / 2, top + height + 3.4), words, 6.5, colour=GREY)
            else:
                canvas.text((placed[0][0] - text_width(words, 6.5) - 1, placed[0][1] + 0.9), words, 6.5, colour=GREY)
    if with_E:
        _contours(canvas, frame, situation)
    elif start is not None:
        at = frame.place(np.array([start[1], start[0]]))[0]
        canvas.circle(at, 0.9, INK, 0.2, INK)
        wide = text_width("start", LABEL_PT)
        is_inside = at[0] + 2.0 + wide < frame.left + frame.width
        canvas.text((at[0] + 1.6 if is_inside else at[0] - 1.6 - wide, at[1] + 0.9), "start", LABEL_PT)
    frame.border(canvas)
    upwards, right = (name.lower() for name in engine_scene(situation.scene)["names"])
    words = f"{right.capitalize()} to the right, {upwards} upwards."
    canvas.text((left + inside[0], top + height + 7.2), words, LABEL_PT, colour=GREY)
    return height + 9.0


def _contours(canvas: Canvas, frame: Frame, situation: Situation) -> None:
    world, moment = situation.world, situation.start
    views = moment.views
    found = landscape_over(world, moment.fit, views.demo, views.visible[:, :2], grid_axes(world, MAP_STEP_DEG))
    rows, columns = (np.degrees(axis) for axis in found.axes)
    generator = contour_generator(columns, rows, found.E)
    for level in LEVELS:
        for line in generator.lines(level):
            if len(line) > 2:
                canvas.path(frame.place(np.asarray(line)), GREY, 0.2)
    lowest = np.degrees(found.minimum)
    (x, y), (u, v) = frame.place(np.array([[lowest[1], lowest[0]], np.degrees(moment.theta_demo)[::-1]]))
    for dx, dy in ((1.6, 1.6), (1.6, -1.6)):
        canvas.path([(x - dx, y - dy), (x + dx, y + dy)], INK, 0.5)
    wide = text_width("lowest E", LABEL_PT)
    corners = [(x + 2.0, y - 4.0), (x + 2.8 + wide, y - 4.0), (x + 2.8 + wide, y - 0.8), (x + 2.0, y - 0.8)]
    canvas.path(corners, "", fill="#ffffff", closed=True)
    canvas.text((x + 2.4, y - 1.4), "lowest E", LABEL_PT)
    _diamond(canvas, (u, v))


def outside(canvas: Canvas, box: Box, situation: Situation, layers: Collection[str]) -> Frame:
    """Draw both arms and the eyes from outside, or with the layer "cameras" one arm and two cameras that look at it."""
    world, moment = situation.world, situation.start
    towards = np.array([np.cos(ELEVATION) * np.cos(AZIMUTH), np.cos(ELEVATION) * np.sin(AZIMUTH), np.sin(ELEVATION)])
    right = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0])
    plane = np.array([right, np.cross(towards, right)])
    postures = {"demonstrator": (moment.theta_demo, world.T_world_demo), "learner": (moment.theta, world.T_world_own)}
    l, r, own_left = (camera.T_world_camera for camera in (*world.demo_cameras, world.own_cameras[0]))
    if "cameras" in layers:  # camera 2 sees the demonstrator as L sees the learner
        del postures["learner"]
        cameras = {"camera 1": l, "camera 2": world.T_world_demo @ np.linalg.inv(world.T_world_own) @ own_left}
    else:
        cameras = {"left eye": l, "right eye": r}
    eyes = np.array([T[:3, 3] for T in cameras.values()]) @ plane.T
    arms = {name: _outlines(situation, *posture, plane) for name, posture in postures.items()}
    room = np.concatenate([*(hull for hulls in arms.values() for hull in hulls), eyes])
    mark, ray = None, np.empty((0, 2))
    if situation.chosen is not None:
        mark = world.points_world(moment.theta_demo, world.T_world_demo)[situation.chosen] @ plane.T
        ray = np.array([eyes[0], eyes[0] + RAY * (mark - eyes[0])])
        room = np.concatenate([room, ray])
    margin = 0.1 * float(np.ptp(room, axis=0).max())
    frame = Frame(*box, room.min(0) - margin, room.max(0) + margin, up=True)
    for name, hulls in arms.items():
        for hull in hulls:
            canvas.path(frame.place(hull), GREY, 0.2, FILL, closed=True)
        x, y = max(frame.place(np.concatenate(hulls)), key=lambda at: at[1])
        canvas.text((x - text_width(name, LABEL_PT) / 2, y + 3.4), name, LABEL_PT, colour=GREY)
    if "ray" in layers and len(ray):
        canvas.path(frame.place(ray), INK, 0.4)
    for name, at in zip(cameras, frame.place(eyes)):
        canvas.circle(at, 1.2, INK, 0.3, "#ffffff")
        canvas.text((at[0] - text_width(name, LABEL_PT) / 2, at[1] - 2.0), name, LABEL_PT)
    if mark is not None:
        at = frame.place(mark)[0]
        canvas.circle(at, 0.7, "", fill=INK)
        canvas.circle(at, 2.0, INK, 0.4)
    frame.border(canvas)
    return frame


def _outlines(situation: Situation, theta: Array, T_world_base: Array, plane: Array) -> list[Array]:
    """Outlines of an arm's links, (k, 2) m each, in a plane with two unit vectors as rows."""
    frames = situation.world.link_frames(theta, T_world_base)
    meshes = link_meshes(situation.scene.robot).items()
    return [
        _hull((np.asarray(mesh.vertices, float) @ frames[link][:3, :3].T + frames[link][:3, 3]) @ plane.T)
        for link, mesh in meshes
    ]


def _hull(points: Array) -> Array:
    """Corners of the convex hull of points in a plane, by Andrew's monotone chain."""
    ordered = sorted(set(map(tuple, points.tolist())))

    def half(chain: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
        found: list[tuple[float, ...]] = []
        for x, y in chain:
            while len(found) > 1:
                (ax, ay), (bx, by) = found[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                    break
                found.pop()
            found.append((x, y))
        return found[:-1]

    return np.array(half(ordered) + half(ordered[::-1]))
