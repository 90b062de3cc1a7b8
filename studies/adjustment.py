"""A plain bundle adjustment of the pictures that a run has seen, beside the learner's own estimate.

    python studies/adjustment.py --runs 80

It shares no code with the learner's: two pinhole cameras with square pixels, a chain of screws, points, and the
demonstrator as a similarity of the own body, solved by SciPy. So it knows more of the cameras than the learner does.
Drawn are poses of the default scene, with noise of 0.25 px in 25 frames. The last line has root mean squares.
"""

import argparse
from dataclasses import dataclass
from itertools import product

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from viewimit import Session, Settings, load_scene
from viewimit.loop.learner import demonstrator_average

Floats = NDArray[np.float64]
FOCALS = 0.4, 1.0  # of the picture's width: tried as a first guess
LOOSE = np.array([1.0, 200, 200, 1, 200, 200, *[0.5] * 5])  # standard deviations of the cameras' prior; focal: relative
PRIOR, UNIT_RATE = 0.1, 100.0  # weights of that prior, and of joints that turn by what is commanded
MOVED_SIGMA, MIN_MOVED_PX = 8.0, 0.02  # by how much more than noise a point moves with a joint
GRID, STARTS, MAX_NFEV = 13, 3, 60  # postures a joint, and those of them that are refined
NOISE_PX, FRAMES = 0.25, 25


def screw_motion(screw: Floats, angle: float) -> Floats:
    """Motion (4, 4) of a joint: rotation vector of unit rate, and velocity at the origin."""
    rate = np.linalg.norm(screw[:3]) + 1e-12
    x, y, z = screw[:3] / rate
    K, turn, T = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), angle * rate, np.eye(4)
    T[:3, :3] = np.eye(3) + np.sin(turn) * K + (1 - np.cos(turn)) * K @ K
    T[:3, 3] = (np.eye(3) * turn + (1 - np.cos(turn)) * K + (turn - np.sin(turn)) * K @ K) @ screw[3:] / rate
    return T


def projections(cameras: Floats) -> tuple[Floats, Floats]:
    """Matrices (3, 4) of focal and centre, for each; then rotation and direction of the right one from the left."""
    K = [np.array([[f, 0, x], [0, f, y], [0, 0, 1]]) for f, x, y in (cameras[:3], cameras[3:6])]
    right = np.column_stack([Rotation.from_rotvec(cameras[6:9]).as_matrix(), [-1, *cameras[9:]]])
    return K[0] @ np.eye(3, 4), K[1] @ right


def project(cameras: Floats, points: Floats) -> Floats:
    """Pictures (..., 4) px of points (..., 3)."""
    seen = [points @ P[:, :3].T + P[:, 3] for P in projections(cameras)]
    return np.concatenate([y[..., :2] / y[..., 2:] for y in seen], -1)


def triangulate(cameras: Floats, images: Floats) -> Floats:
    """Points (N, 3) of pictures (N, 4) px, by the direct linear transformation."""
    rows = [images[:, [2 * k + axis]] * P[2] - P[axis] for k, P in enumerate(projections(cameras)) for axis in range(2)]
    points = np.linalg.svd(np.stack(rows, 1))[2][:, 3]
    return points[:, :3] / points[:, 3:]


def similarity(source: Floats, target: Floats) -> tuple[Floats, float, Floats]:
    """Rotation, scale and translation from (N, 3) to (N, 3), by Umeyama (1991)."""
    a, b = source - source.mean(0), target - target.mean(0)
    U, s, V = np.linalg.svd(b.T @ a)
    D = np.diag([1, 1, np.linalg.det(U @ V)])
    R, scale = U @ D @ V, float((s * np.diag(D)).sum() / (a**2).sum())
    return R, scale, target.mean(0) - scale * R @ source.mean(0)


@dataclass(frozen=True)
class Problem:
    """Own pictures (V, N, 4) px at displacements (V, m) rad, and the demonstrator's (N, 4) px with their noise."""

    displacement: Floats
    own: Floats
    demo: Floats
    noise_px: float
    demo_noise_px: float
    first: Floats  # (11,): cameras to begin with
    moved_by: NDArray[np.int_]  # (N,): how many joints move each point, of a chain

    def split(self, p: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Cameras (11,), screws (m, 6), points (N, 3), and what is left."""
        m, n = self.displacement.shape[1], self.own.shape[1]
        cameras, screws, points, rest = np.split(p, np.cumsum([11, 6 * m, 3 * n]))
        return cameras, screws.reshape(m, 6), points.reshape(n, 3), rest

    def posed(self, screws: Floats, points: Floats, angles: Floats) -> Floats:
        """Points (N, 3) at joint angles."""
        T, found = np.eye(4), points.copy()
        for joint, (screw, angle) in enumerate(zip(screws, angles)):
            T = T @ screw_motion(screw, angle)
            beyond = self.moved_by > joint
            found[beyond] = points[beyond] @ T[:3, :3].T + T[:3, 3]
        return found

    def own_residuals(self, p: Floats) -> Floats:
        """Of the own pictures, over their noise, and of the prior."""
        cameras, screws, points, _ = self.split(p)
        seen = [project(cameras, self.posed(screws, points, angles)) for angles in self.displacement]
        loose = LOOSE * [self.first[0], 1, 1, self.first[3], *[1] * 7]
        rates = np.linalg.norm(screws[:, :3], axis=1)
        prior = [PRIOR * (cameras - self.first) / loose, UNIT_RATE * (rates - 1)]
        return np.concatenate([((np.array(seen) - self.own) / self.noise_px).ravel(), *prior])

    def demo_residuals(self, p: Floats, pose: Floats) -> Floats:
        """Of the demonstrator's pictures. pose: rotation vector, translation, logarithm of the scale, angles."""
        cameras, screws, points, _ = self.split(p)
        body = np.exp(pose[6]) * self.posed(screws, points, pose[7:]) @ Rotation.from_rotvec(pose[:3]).as_matrix().T
        return ((project(cameras, body + pose[3:6]) - self.demo) / self.demo_noise_px).ravel()

    def first_body(self) -> Floats:
        """Cameras, and screws and points by triangulation, from visits that turned one joint more than another."""
        points, screws = triangulate(self.first, self.own[0]), list[Floats]()
        for joint, (visit, _) in enumerate(probes(self.displacement)):
            beyond, before = self.moved_by > joint, np.eye(4)
            for k in range(joint):
                before = before @ screw_motion(screws[k], self.displacement[visit, k])
            there = (triangulate(self.first, self.own[visit])[beyond] - before[:3, 3]) @ before[:3, :3]
            R, _, t = similarity(points[beyond], there)
            spin = Rotation.from_matrix(R).as_rotvec() / self.displacement[visit, joint]
            foot = np.linalg.lstsq(np.eye(3) - R, t, rcond=1e-3)[0]
            screws.append(np.concatenate([spin, np.cross(foot, spin)]))
        return np.concatenate([self.first, *screws, points.ravel()])


def probes(displacement: Floats) -> list[tuple[int, int]]:
    """For each joint: a visit, and the first or the last visit before it, between which it alone turned."""
    pairs = [(k, other) for k in range(1, len(displacement)) for other in (0, k - 1)]
    alone = lambda pair: np.abs(displacement[pair[0]] - displacement[pair[1]]) > 1e-9
    joints = range(displacement.shape[1])
    return [next(pair for pair in pairs if alone(pair).tolist() == [j == k for j in joints]) for k in joints]


def solve(
    displacement: Floats, own: Floats, demo: Floats, noise: tuple[float, float], limits: Floats, size: tuple[int, int]
) -> Floats:
    """Angles of the demonstrator, (m,) rad, as displacements. limits: (m, 2) rad; size: of the pictures [px]."""
    (width, height), m = size, displacement.shape[1]
    moves = [
        np.abs(own[a] - own[b]).max(1) > max(MOVED_SIGMA * noise[0], MIN_MOVED_PX) for a, b in probes(displacement)
    ]
    moved_by = np.max([np.where(moved, joint + 1, 0) for joint, moved in enumerate(moves)], 0)
    found = []
    for focal in FOCALS:
        first = np.array([focal * width, width / 2, height / 2] * 2 + [0.0] * 5)
        problem = Problem(displacement, own, demo, *noise, first, moved_by)
        body = least_squares(problem.own_residuals, problem.first_body(), x_scale="jac", max_nfev=MAX_NFEV)
        found.append((body.cost, problem, body.x))
    _, problem, body = min(found, key=lambda one: one[0])
    cameras, screws, points, _ = problem.split(body)
    target, starts = triangulate(cameras, demo), []
    for angles in map(np.array, product(*(np.linspace(low, high, GRID) for low, high in limits))):
        posed = problem.posed(screws, points, angles)
        R, scale, t = similarity(posed, target)
        pose = np.concatenate([Rotation.from_matrix(R).as_rotvec(), t, [np.log(scale)], angles])
        starts.append((float(((scale * posed @ R.T + t - target) ** 2).sum()), pose))
    of_pose = lambda pose: problem.demo_residuals(body, pose)
    best = [
        least_squares(of_pose, pose, x_scale="jac", max_nfev=MAX_NFEV)
        for _, pose in sorted(starts, key=lambda s: s[0])[:STARTS]
    ]
    pose = min(best, key=lambda one: one.cost).x

    def both(p: Floats) -> Floats:
        return np.concatenate([problem.own_residuals(p), problem.demo_residuals(p, problem.split(p)[3])])

    return least_squares(both, np.concatenate([body, pose]), x_scale="jac", max_nfev=MAX_NFEV).x[-m:]


def main() -> None:
    """Print each run, and the ratio of both errors."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--runs", type=int, default=80, help="number of drawn poses (%(default)s)")
    parser.add_argument("--seed", type=int, default=71, help="of the draws (%(default)s)")
    args = parser.parse_args()
    rng, scene = np.random.default_rng(args.seed), load_scene(Settings().scene)
    low, high = np.transpose(scene.range_deg)
    errors = []
    for number in range(args.runs):
        demonstrator, start = (tuple(rng.uniform(low, high)) for _ in range(2))
        noisy = Settings(noise_px=NOISE_PX, frames=FRAMES, seed=number)
        session = Session(msgspec.structs.replace(noisy, demonstrator_deg=demonstrator, start_deg=start))
        session.run()
        now, history = session.snapshot, list(session.history)
        noise_px = NOISE_PX / np.sqrt(FRAMES)
        average, average_px = demonstrator_average(now, noise_px, 0.0)
        demo, demo_px = (now.views.demo, noise_px) if average is None or average_px is None else (average, average_px)
        displacement = np.array([one.theta for one in history]) - history[0].theta
        own = np.array([one.views.own for one in history])
        limits = np.radians(scene.range_deg) - history[0].theta[:, None]
        theta = history[0].theta + solve(displacement, own, demo, (noise_px, demo_px), limits, scene.head.image)
        off = [float(np.degrees(np.abs(one - now.theta_demo).max())) for one in (now.theta, theta)]
        errors.append(off)
        print(f"run {number}: {now.status.value} after {now.motion} steps, {off[0]:.3f}° off; adjustment {off[1]:.3f}°")
    squares = np.square(errors)
    ours, plain = np.sqrt(squares.mean(0))
    drawn = squares[np.random.default_rng(0).integers(0, len(squares), (2000, len(squares)))].mean(1)
    low_, high_ = np.percentile(np.sqrt(drawn[:, 0] / drawn[:, 1]), [2.5, 97.5])
    print(f"rms: learner {ours:.3f}°, adjustment {plain:.3f}°; ratio {ours / plain:.2f} ({low_:.2f} to {high_:.2f})")


if __name__ == "__main__":
    main()
