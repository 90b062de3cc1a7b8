"""The right answer to each question with answers is computed from the state that its step shows."""

from functools import cache

import numpy as np
import oracles
import pytest
from viewimit.app.lab.lessons import facts, records, sign, step_data
from viewimit.app.lab.lessons.format import Choice, Number
from viewimit.app.lab.lessons.situation import Situation
from viewimit.app.lab.lessons.source import questions, shipped

from viewimit import FourViews, Settings, fit_affine_fundamental
from viewimit.analysis.observability import sample_estimates

RING = 8  # index of the ringed point
GOAL = 3.0  # px²
SIGMAS = 4.0
GAIN_PROBE_DEG, TURNED_PROBE_DEG = 15.0, 5.0  # of each joint, from which the first Jacobian is learned
TURNED_GAIN, TURNED_POINT = 0.3, 9
USUAL = Situation(Settings.paper(demonstrator_deg=(45, -90), start_deg=(25, -25)))
SAME = Situation(Settings.paper(demonstrator_deg=(62, -118), start_deg=(62, -118)))
STEPS = {f"{name}/{step.id}": (lesson, step) for name, lesson in shipped().items() for step in lesson.step}


@cache
def state(key: str) -> Situation:
    """The fixed state of "lesson/step"."""
    return step_data.situation_of(*STEPS[key])


@cache
def sampled(key: str) -> list[Situation]:
    """The sampled states of "lesson/step", as the page has them."""
    return step_data.sampled_situations(*STEPS[key])


@cache
def ray_images(shares: tuple[float, ...] = (0.5, 0.7, 0.9, 1.0, 1.2, 1.6)) -> tuple[np.ndarray, np.ndarray]:
    """px in pictures 1 and 2 of places on the ray of camera 1 through the ringed mark."""
    one = state("ray/shadow")
    first, second = oracles.two_cameras(one)
    mark = one.world.points_world(one.start.theta_demo, one.world.T_world_demo)[RING]
    places = oracles.along_ray(first, mark, np.array(shares))
    return oracles.project(first, places), oracles.project(second, places)


def one_dot_and_a_line() -> bool:
    first, second = ray_images()
    return (
        np.ptp(first, axis=0).max() < 1e-9 and oracles.straightness(second) < 1e-9 and np.ptp(second, axis=0).max() > 50
    )


def all_lines_pass_the_epipole() -> bool:
    """For every point, near or far: its ray's image contains camera 1's image."""
    one = state("ray/far")
    points = one.world.points_world(one.start.theta_demo, one.world.T_world_demo)
    for times in (0.4, 1, 10):
        first, second = (oracles.dollied(camera, points.mean(0), times) for camera in oracles.two_cameras(one))
        epipole = oracles.project(second, first.T_world_camera[:3, 3])
        for point in points:
            line = oracles.project(second, oracles.along_ray(first, point, np.array([0.8, 1.2])))
            if (
                oracles.straightness(np.concatenate([line, epipole[None]]))
                > 1e-6 * np.ptp(line - epipole, axis=0).max()
            ):
                return False
    return True


def only_the_demonstrator_s_pictures_change() -> bool:
    one = state("tour/eyes")
    bent = one.with_settings(demonstrator_deg=(62, -30)).start.views
    seen = one.start.views
    return np.array_equal(bent.own, seen.own) and np.abs(bent.demo - seen.demo).max(0).min() > 10


def own_point_off_line(key: str) -> float:
    """px in L from the learner's ringed point to the line from l."""
    one = state(key)
    return float(abs(oracles.lines_in_L(one, RING)[0] @ [*one.start.views.own_left[RING], 1]))


def no_arrows_show_the_way() -> int:
    """Index of the right answer: all, those on the hand, none."""
    one = state("tour/signpost")
    hand = np.flatnonzero(one.world.body.link >= 4)
    if oracles.cosine(one) > 0.7:
        return 0
    return 1 if oracles.cosine(one, hand) > 0.7 else 2


def times_by_place() -> float:
    """The largest E over the smallest, of the places that the figure shows."""
    one = state("tour/carried")
    E = [oracles.carried_to(one, *place).start.E for place in ((0, 0), (0, 0.5), (0.5, 0), (1, 1), oracles.NEARER)]
    return max(E) / min(E)


def part_of_a_doubled_arrow() -> float:
    """How many times as large an arrow's part of the mean square is, twice as long."""
    arrows = oracles.arrows(state("tour/number"))
    longer = arrows.copy()
    longer[0, 0] *= 2
    return float(((longer**2).sum() - (arrows**2).sum()) / (arrows[0, 0] ** 2).sum() + 1)


@cache
def steps(servo: str) -> np.ndarray:
    """Motions to the goal in each sampled state."""
    return np.array([records.motions_to(records.run(one, servo), GOAL) for one in sampled("tour/feel")])


def who_needs_fewer() -> int:
    """Index of the right answer: the law of E, those that learn the pictures, all the same."""
    law = np.nan_to_num(steps("gradient-retuned"), nan=np.inf)
    pictures = np.maximum(steps("broyden"), steps("likelihood"))
    return 1 if (pictures < law).all() else 0 if (pictures > law).all() else 2


def lines_come_from_images_alone(key: str) -> bool:
    """The lines of views without world, scene or settings are those of the step."""
    one = state(key)
    views = one.start.views
    alone = FourViews.from_images(views.demo_left, views.demo_right, views.own_left, views.own_right)
    f, f33 = fit_affine_fundamental(alone.demo_left, alone.own_left)
    line = np.array([f[2], f[3], f33 + f[:2] @ views.demo_left[RING]]) / np.hypot(f[2], f[3])
    found = oracles.lines_in_L(one, RING)[0]
    return bool(min(np.abs(line - found).max(), np.abs(line + found).max()) < 1e-6)


def same_pixel() -> bool:
    views = state("tour/line").start.views
    return bool(np.linalg.norm(views.demo_left[RING] - views.own_left[RING]) < 10)


def flat_steeper_or_rougher() -> int:
    by_count = oracles.matches(state("limits/four-points")).by_count
    few, all_ten = (float(np.nanmax(by_count[count].E)) for count in (4, 10))
    return 1 if few < 1e-9 * all_ten else 0 if few > all_ten else 2


def million_frames_fall_on() -> int:
    """Where estimates of pictures nearly without noise lie: the demonstrator, the cloud's middle, or scattered."""
    one = state("limits/bias-stays")
    noise_px = one.settings.noise_px / np.sqrt(1e6)
    rng = np.random.default_rng(1)
    quiet = sample_estimates(one.world, one.start.fit, one.start.theta_demo, noise_px, 1, 50, rng)
    averaged = records.clouds(one)[records.FRAMES[1]]
    if quiet.std(0).max() > 0.1 * averaged.std(0).min():
        return 2
    error = SIGMAS * averaged.std(0) / np.sqrt(records.RUNS)  # of the middle
    return 1 if (np.abs(quiet.mean(0) - averaged.mean(0)) < error).all() else 0


def swapped_answer() -> int:
    """E near 0, large at the right posture, large at a wrong one."""
    one = state("limits/swapped")
    if records.minima(one).E[0] < 1:
        return 0
    return 1 if records.bias_deg(one) < 5 else 2


@cache
def gain(value: float) -> oracles.Servoing:
    one = state("jacobian/gain")
    return oracles.teach_by_showing(one, value, True, range(40), GAIN_PROBE_DEG)


@cache
def turned(roll_deg: float, update: bool) -> oracles.Servoing:
    coordinates = (4 * TURNED_POINT, 4 * TURNED_POINT + 1)
    one = state("jacobian/turned")
    return oracles.teach_by_showing(one, TURNED_GAIN, update, coordinates, TURNED_PROBE_DEG, roll_deg)


def straight_spiral_or_away() -> int:
    made = turned(90, False)
    if made.off_px[-1] > made.off_px[0]:
        return 2
    return 1 if abs(made.turns) > 1 else 0


def fastest_gain() -> int:
    return int(np.nanargmin([gain(value).steps() for value in (0.1, 1.0, 2.2)]))


def jacobian_learned_from_turns_predicts() -> bool:
    """Broyden's model of random turns of ±10°, from nothing: its third prediction and later ones are off by less than
    half of what the dot moved, in the median of the sampled states."""
    shares = []
    for one in sampled("jacobian/knobs"):
        rng, theta = np.random.default_rng(1), one.start.theta.copy()
        J, y = np.zeros((2, 2)), one.world.own_images(theta)[0][8, :2]
        for turn in range(6):
            step = np.radians([[10, 0], [0, 10]][turn] if turn < 2 else rng.uniform(-10, 10, 2))
            there = np.clip(theta + step, one.scene.lower, one.scene.upper)
            moved, seen = there - theta, one.world.own_images(there)[0][8, :2]
            if moved @ moved > 0:
                if turn >= 2:
                    shares.append(np.linalg.norm(seen - y - J @ moved) / max(np.linalg.norm(seen - y), 1e-9))
                J = J + np.outer(seen - y - J @ moved, moved) / (moved @ moved)
            theta, y = there, seen
    return float(np.median(shares)) < 0.5


def lines_hold_across() -> bool:
    """Shifted by a pixel each, lines at 14° leave their crossing within 1 px across their bisector."""
    half = np.radians(7)
    normals = np.array([[np.sin(half), np.cos(half)], [-np.sin(half), np.cos(half)]])
    shifts = [np.linalg.solve(normals, [a, b]) for a in (-1, 1) for b in (-1, 1)]
    return max(abs(y) for _, y in shifts) < 1.1 and max(abs(x) for x, _ in shifts) > 4


def lines_cross_where_the_own_points_are() -> bool:
    """For the same pose only."""
    return records.minima(SAME).E[0] < 1 < SAME.with_settings(start_deg=(25, -45)).start.E


def marks_stay_near_the_own_points() -> bool:
    """In the median of random pairs of postures, diamonds go less than a fifth of the way to the goal."""
    shares, rng = [], np.random.default_rng(1)
    low, high = SAME.scene.lower, SAME.scene.upper
    while len(shares) < 200:
        demo, own = rng.uniform(low, high, (2, 2))
        one = SAME.with_settings(demonstrator_deg=tuple(np.degrees(demo)), start_deg=tuple(np.degrees(own)))
        if records.degrees_off(demo, own) > 20 and one.start.usable.all():
            back, way = -oracles.arrows(one), oracles.ways(one)
            shares.append((back * way).sum() / (way**2).sum())
    return abs(float(np.median(shares))) < 0.2


def any_elbow_has_a_small_E() -> bool:
    """For every elbow, some shoulder has an E below 0.3 px²."""
    one = sign.signed_runs()[1].situation
    return bool((np.nanmin(records.landscape(one).E, axis=0) < 0.3).all())


RIGHT = {  # index of the right answer
    "ray/far": lambda: 1 if all_lines_pass_the_epipole() and oracles.ray_angles(state("ray/far"), 0.4)[0] > 10 else 0,
    "tour/eyes": lambda: 0 if only_the_demonstrator_s_pictures_change() else 2,
    "tour/line": lambda: 1 if own_point_off_line("tour/line") < 2 and not same_pixel() else 0,
    "tour/signpost": no_arrows_show_the_way,
    "tour/carried": lambda: 1 if 1.5 < times_by_place() < 2.5 else 0,
    "tour/number": lambda: (2, 4, 8).index(round(part_of_a_doubled_arrow())),
    "tour/feel": who_needs_fewer,
    "limits/four-points": flat_steeper_or_rougher,
    "limits/bias-stays": million_frames_fall_on,
    "limits/swapped": swapped_answer,
    "jacobian/gain": fastest_gain,
    "jacobian/turned": straight_spiral_or_away,
    "questions/line": lambda: 0 if one_dot_and_a_line() else 3,
    "questions/line-needs": lambda: 0 if lines_come_from_images_alone("tour/line") else 1,
    "questions/flat": lambda: 0 if lines_hold_across() else 2,
    "questions/conflict": lambda: (
        0 if marks_stay_near_the_own_points() and lines_cross_where_the_own_points_are() else 1
    ),
    "questions/converse": lambda: 0 if facts.FACTS["open with five points"].of(USUAL) > 10 else 1,
    "questions/step": lambda: 0 if jacobian_learned_from_turns_predicts() else 2,
    "questions/bias": lambda: 0 if million_frames_fall_on() == 1 else 1,
    "questions/claim": lambda: 0 if any_elbow_has_a_small_E() else 1,
}
CHOICES = {key: step.ask.answers for key, (_, step) in STEPS.items() if isinstance(step.ask, Choice)}
CHOICES |= {f"questions/{item.id}": item.answers for item in questions().item}


@pytest.mark.parametrize("key", CHOICES)
def test_the_right_answer_is_computed(key):
    """A measure of the library that says which one is right needs no other: test_facts.py has its oracle."""
    ask = STEPS[key][1].ask if key in STEPS else None
    measure = ask.right if ask else None
    right = round(float(facts.FACTS[measure].of(state(key)))) - 1 if measure in facts.FACTS else RIGHT[key]()
    marked = [k for k, answer in enumerate(CHOICES[key]) if answer.right or answer.because.startswith("Right")]
    assert marked == [right]


@pytest.mark.parametrize("key", [key for key, (_, step) in STEPS.items() if isinstance(step.ask, Number)])
def test_a_number_that_is_asked_for_is_on_its_scale(key):
    ask = STEPS[key][1].ask
    for situation in sampled(key) or [state(key)]:
        if ask.truth in facts.FACTS:
            assert ask.low < float(facts.FACTS[ask.truth].of(situation)) < ask.high
