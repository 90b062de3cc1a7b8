"""Statements of the lessons about rays and lines, and of the tour."""

from functools import cache

import numpy as np
import oracles
from statements import DEFINITION, REPORT, Statements, fact, sampled, state, step_named
from viewimit.app.lab.lessons import design, records
from viewimit.app.lab.lessons.facts import widest_deg
from viewimit.app.lab.lessons.situation import Situation

from viewimit import FourViews, fit_affine_fundamental
from viewimit.analysis.landscape import grid_axes

RING = 8  # index of the ringed point
AFFINE_POINTS = 4  # that any two pictures fit
EYES_FAR = 50  # times the distance
SLIDER = np.linspace(0, 1, 21)  # from the same pose to the step's own
GOAL = 3.0  # px²


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


def off_the_ray_it_moves() -> bool:
    """A place beside the ray has another image in picture 1."""
    one = state("ray/shadow")
    first, _ = oracles.two_cameras(one)
    mark = one.world.points_world(one.start.theta_demo, one.world.T_world_demo)[RING]
    ray = mark - first.T_world_camera[:3, 3]
    beside = np.cross(ray, [0, 0, 1.0]) * 0.05
    return np.linalg.norm(oracles.project(first, mark + beside) - oracles.project(first, mark)) > 1


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


def angle_at(times: float) -> float:
    return oracles.ray_angles(state("ray/far"), times)[0]


def four_fit_anything() -> bool:
    """Any four matches, even random ones, have an affine geometry that fits exactly; five have none."""
    u = np.random.default_rng(1).uniform(0, 200, (20, AFFINE_POINTS + 1, 4))
    four, five = ([np.linalg.svd(one[:n] - one[:n].mean(0))[1][3] for one in u] for n in (4, 5))
    return max(four) < 1e-9 and float(np.median(five)) > 1


def turning_in_turn_reaches_the_goal() -> bool:
    """Each slider to where the misfit is least, in turn, six times at most, and never at an end of its range."""
    step, views = step_named("ray/pencil"), state("ray/pencil").start.views
    ranges = [np.arange(slider.low, slider.high + 1, slider.step) for slider in step.sliders]
    at = [slider.start for slider in step.sliders]

    def misfit(angles: list[float]) -> float:
        offsets = []
        for points, angle in zip((views.demo_left, views.own_left), np.radians(angles), strict=True):
            along = points @ [-np.sin(angle), np.cos(angle)]
            offsets.append(along - along.mean())
        s, t = offsets
        return float(np.sqrt(np.mean((t - s * (s @ t) / (s @ s)) ** 2)))

    for turn in range(12):
        if misfit(at) < step.ask.below:
            return turn > 2
        k, values = turn % 2, ranges[turn % 2]
        at[k] = float(min(values, key=lambda value, k=k: misfit([value if j == k else at[j] for j in (0, 1)])))
        if not values[10] < at[k] < values[-11]:
            return False
    return False


def fifth(alike: bool) -> np.ndarray:
    one = state("ray/pencil")
    return oracles.left_out_px(one, one.start.theta_demo if alike else np.radians([25.0, -45.0]))


def mark_in_r_moves_only_its_line() -> bool:
    """The line from l depends on l alone, so the crossing stays on it."""
    one = state("ray/two")
    views, lines = one.start.views, oracles.lines_in_L(one, RING)
    f, f33 = fit_affine_fundamental(views.demo_right, views.own_left)
    moved = views.demo_right[RING] + [0, 5.0]
    other = np.array([f[2], f[3], f33 + f[:2] @ moved]) / np.hypot(f[2], f[3])
    shifted = np.array([lines[0], other])
    away = oracles.cross(shifted) - oracles.cross(lines)
    return abs(lines[0] @ [*oracles.cross(shifted), 1]) < 1e-6 and np.linalg.norm(away) > 5


def crossing_is_equation_4(key: str) -> bool:
    one = state(key)
    return np.linalg.norm(oracles.cross(oracles.lines_in_L(one, RING)) - one.start.recovered[RING, :2]) < 0.05


def along_over_across(key: str) -> bool:
    """1/tan of the angle between the lines, along the line that stays; across it the crossing does not move."""
    one = state(key)
    moved, line = oracles.crossing_moves(one, RING), oracles.lines_in_L(one, RING)[0]
    return abs(moved @ line[:2]) < 1e-6 and np.linalg.norm(moved) > 4


def only_the_demonstrator_s_pictures_change() -> bool:
    one = state("tour/eyes")
    bent = one.with_settings(demonstrator_deg=(62, -30)).start.views
    seen = one.start.views
    return np.array_equal(bent.own, seen.own) and np.abs(bent.demo - seen.demo).max(0).min() > 10


def same_body_from_elsewhere() -> bool:
    """In the same pose, L is what a camera elsewhere sees of the demonstrator itself."""
    one = state("tour/line")
    _, second = oracles.two_cameras(one)
    body = one.world.points_world(one.start.theta_demo, one.world.T_world_demo)
    return np.abs(oracles.project(second, body) - one.start.views.own_left).max() < 1e-9


def own_point_off_line(key: str) -> float:
    """px in L from the learner's ringed point to the line from l."""
    one = state(key)
    return float(abs(oracles.lines_in_L(one, RING)[0] @ [*one.start.views.own_left[RING], 1]))


def crossing_to_own(key: str, point: int = RING) -> float:
    return float(np.linalg.norm(oracles.arrows(state(key))[point, 0]))


def ghost_lines_meet_on_its_points() -> bool:
    """To the perspective that is left, 1.5 px: a tenth of a percent of the picture's width would be 0.6."""
    alike = oracles.between(state("tour/assumption"), 0)
    return np.linalg.norm(oracles.arrows(alike), axis=-1).max() < 2


def E_grows_all_the_way() -> bool:
    one = state("tour/assumption")
    E = [oracles.between(one, float(share)).start.E for share in SLIDER]
    return bool((np.diff(E) > 0).all()) and E[-1] > 100 * E[0]


def crossing_goes_with_the_own_hand() -> bool:
    """Nearer to the own hand than to the ghost's, over the slider's second half as well, but not on it."""
    one = state("tour/assumption")
    for share in SLIDER[10:]:
        here = oracles.between(one, float(share))
        own = np.linalg.norm(oracles.arrows(here)[RING, 0])
        if not 2 < own < 0.5 * oracles.to_ghost(here)[RING, 0]:
            return False
    return True


def fitted_through_own_points() -> bool:
    """The centroid of the diamonds is the own points' centroid."""
    return np.abs(np.nanmean(state("tour/assumption").start.e, axis=0)).max() < 1e-9


def arrow_px(point: int) -> float:
    """Of the longer one in L and R."""
    return float(np.linalg.norm(oracles.arrows(state("tour/signpost"))[point], axis=-1).max())


def way_px(point: int) -> float:
    return float(np.linalg.norm(oracles.ways(state("tour/signpost"))[point], axis=-1).max())


def on_link(point: int) -> int:
    return int(state("tour/signpost").world.body.link[point])


def no_arrows_show_the_way() -> int:
    """Index of the right answer: all, those on the hand, none."""
    one = state("tour/signpost")
    hand = np.flatnonzero(one.world.body.link >= 4)
    if oracles.cosine(one) > 0.7:
        return 0
    return 1 if oracles.cosine(one, hand) > 0.7 else 2


def E_at_places() -> np.ndarray:
    return np.array([E_carried(*place) for place in oracles.PLACES])


def E_carried(back: float, aside: float) -> float:
    return oracles.carried_to(state("tour/carried"), back, aside).start.E


def times_by_place() -> float:
    """The largest E over the smallest, of the places that the figure shows."""
    E = [E_carried(*place) for place in ((0, 0), (0, 0.5), (0.5, 0), (1, 1), oracles.NEARER)]
    return max(E) / min(E)


def far_eyes_do_not_notice() -> bool:
    one = state("tour/carried")
    head = one.with_eyes(distance=EYES_FAR).scene.head
    far = one.with_scene({"head": {"position": list(head.position), "focal": head.focal}})
    E = [oracles.carried_to(far, *place).start.E for place in (*oracles.PLACES, oracles.NEARER)]
    return bool(np.ptp(E) < 0.01 * far.start.E)


def smaller_pictures_make_E_smaller() -> bool:
    one = state("tour/carried")
    middle = one.start.views.demo.mean(0)
    shrunk = [oracles.E_of_images(one, middle + share * (one.start.views.demo - middle)) for share in (1, 0.8, 0.5)]
    return bool((np.diff(shrunk) < 0).all())


def shifting_a_picture_does_not_change_E() -> bool:
    one = state("tour/carried")
    moved = oracles.E_of_images(one, one.start.views.demo + [30, -5, 12, 8])
    return abs(moved - one.start.E) < 1e-6 * one.start.E


def shape_alone_changes_E() -> float:
    """E of the step's pose over that of the same pose."""
    one = state("tour/carried")
    return one.start.E / oracles.between(one, 0).start.E


def E_is_the_mean_square() -> bool:
    lengths = np.linalg.norm(oracles.arrows(state("tour/number")), axis=-1)
    return abs((lengths**2).mean() - state("tour/number").start.E) < 1e-9 * state("tour/number").start.E


def part_of_a_doubled_arrow() -> float:
    """How many times as large an arrow's part of the mean square is, twice as long."""
    arrows = oracles.arrows(state("tour/number"))
    longer = arrows.copy()
    longer[0, 0] *= 2
    return float(((longer**2).sum() - (arrows**2).sum()) / (arrows[0, 0] ** 2).sum() + 1)


@cache
def widths(key: str) -> list[float]:
    """Degrees off of the farthest posture with E below the goal, in each sampled state."""
    return [widest_deg(one, GOAL) for one in sampled(key)]


def E_is_a_valley() -> bool:
    """The postures below the goal spread farther along one direction than across it, in most sampled states."""
    ratios = []
    for one in sampled("tour/claim"):
        found = records.landscape(one, 1.0)
        below = np.argwhere(found.E < GOAL)
        spread = np.linalg.eigvalsh(np.cov(below.T)) if len(below) > 3 else np.array([1.0, 1.0])
        ratios.append(np.sqrt(spread[1] / max(spread[0], 0.1)))
    return bool(np.median(ratios) > 1.5)


def one_bowl() -> bool:
    return all(len(records.minima(one)) == 1 for one in sampled("tour/bowl"))


def biases() -> np.ndarray:
    return np.array([records.bias_deg(one) for one in sampled("tour/bowl")])


@cache
def steps(servo: str) -> np.ndarray:
    """Motions to the goal in each sampled state."""
    return np.array([records.motions_to(records.run(one, servo), GOAL) for one in sampled("tour/feel")])


def who_needs_fewer() -> int:
    """Index of the right answer: the law of E, those that learn the pictures, all the same."""
    law = np.nan_to_num(steps("gradient-retuned"), nan=np.inf)
    pictures = np.maximum(steps("broyden"), steps("trust-region"))
    return 1 if (pictures < law).all() else 0 if (pictures > law).all() else 2


def middle_does_not_win(one: Situation) -> bool:
    axes = grid_axes(one.world, 1.0)
    return records.landscape(one, 1.0).E[len(axes[0]) // 2, len(axes[1]) // 2] > GOAL


STATEMENTS: Statements = {
    "ray": {"about": DEFINITION},
    "ray/shadow": {
        "title": {"The ray and its shadow": one_dot_and_a_line},
        "text": {"picture **1** would look exactly the same": one_dot_and_a_line},
        "say": {
            "one dot in the camera's own picture and a line in another": one_dot_and_a_line,
        },
        "note": {"it would not move at all": one_dot_and_a_line},
        "question": DEFINITION,
        "close": {"picture 1 stays the same and picture 2 draws a line": one_dot_and_a_line},
        "far": {"Only places on one straight line look the same to camera 1": off_the_ray_it_moves},
        "elsewhere 1": DEFINITION,
    },
    "ray/far": {
        "title": DEFINITION,
        "text": {"Each ray becomes a line": one_dot_and_a_line},
        "after": REPORT,
        "say": {
            "From far away, all epipolar lines are parallel": lambda: angle_at(10) < 1 < 10 < angle_at(0.4),
            "four numbers for all points": four_fit_anything,
        },
        "question": DEFINITION,
        "answers": lambda: 1 if all_lines_pass_the_epipole() and angle_at(0.4) > 10 else 0,
        "because 1": {
            "all lines pass through its image": all_lines_pass_the_epipole,
            "From far away, you would be nearly right": lambda: angle_at(10) < 1,
        },
        "because 2": {"all lines pass through its image": all_lines_pass_the_epipole},
        "because 3": {"its image lies on each of them": all_lines_pass_the_epipole},
    },
    "ray/pencil": {
        "title": DEFINITION,
        "text": {"Both arms are in the same pose": lambda: same_pose("ray/pencil")},
        "after": {
            "enough to fit any four points": four_fit_anything,
            "Here the fifth fits too": lambda: fifth(alike=True).max() < 1,
            "it would have been off by up to": lambda: fifth(alike=False).max() > 10 * fifth(alike=True).max(),
        },
        "say": {
            "Four points fix it, and the fifth tests it": lambda: fifth(alike=False).min() > fifth(alike=True).max()
        },
        "question": {
            "Bring every point of L onto its line": lambda: oracles.least_misfit_px(state("ray/pencil")) < 0.1,
            "Turn l until they are as short as they get, then L, then l again": turning_in_turn_reaches_the_goal,
        },
    },
    "ray/two": {
        "title": {"two lines": lambda: crossing_is_equation_4("ray/two")},
        "text": {"Each picture gives a line in **L**": mark_in_r_moves_only_its_line},
        "after": {
            "One pixel of error across the lines becomes": lambda: along_over_across("ray/two"),
        },
        "say": {"two give a point": lambda: crossing_is_equation_4("ray/two")},
        "note": REPORT,
        "question": DEFINITION,
        "close": {"the crossing slides along the line from l": mark_in_r_moves_only_its_line},
        "on_line": {"decides where on it the point lies": mark_in_r_moves_only_its_line},
        "far": {"must lie on both lines": lambda: crossing_is_equation_4("ray/two")},
    },
    "tour": {"about": DEFINITION},
    "tour/eyes": {
        "title": DEFINITION,
        "text": DEFINITION,
        "after": {"L and R do not change": only_the_demonstrator_s_pictures_change},
        "say": {"the other robot in l and r, and myself in L and R": only_the_demonstrator_s_pictures_change},
        "question": DEFINITION,
        "answers": lambda: 0 if only_the_demonstrator_s_pictures_change() else 2,
        "because 1": {"Only l and r show the demonstrator": only_the_demonstrator_s_pictures_change},
        "because 2": {"L and R show the learner": only_the_demonstrator_s_pictures_change},
        "because 3": {"Only two change": only_the_demonstrator_s_pictures_change},
    },
    "tour/line": {
        "title": {"The same body from elsewhere": same_body_from_elsewhere},
        "text": {
            "they are in the same pose": lambda: same_pose("tour/line"),
            "L shows the same body as l, seen from another place": same_body_from_elsewhere,
        },
        "after": {"no angles, no lengths, no calibration": lambda: lines_come_from_images_alone("tour/line")},
        "say": {
            "one body seen from two places": same_body_from_elsewhere,
            "a point in l becomes an **epipolar line** in L": lambda: own_point_off_line("tour/line") < 2,
        },
        "question": DEFINITION,
        "answers": lambda: 1 if own_point_off_line("tour/line") < 2 and not same_pixel() else 0,
        "because 1": {"A pixel belongs to the camera": lambda: not same_pixel()},
        "because 2": {"Near or far, all candidates line up": one_dot_and_a_line},
        "because 3": {"That leaves one line, not the whole picture": one_dot_and_a_line},
    },
    "tour/crossing": {
        "title": DEFINITION,
        "text": {"Both arms are still in the same pose": lambda: same_pose("tour/crossing")},
        "say": {"they cross on my own point": lambda: crossing_to_own("tour/crossing") < 2},
        "note": REPORT,
        "question": DEFINITION,
        "close": {"cross on the learner's own point": lambda: crossing_to_own("tour/crossing") < 2},
        "on_line": {"The second eye decides": mark_in_r_moves_only_its_line},
        "far": {"has to lie on both lines": lambda: crossing_is_equation_4("tour/crossing")},
    },
    "tour/assumption": {
        "title": DEFINITION,
        "text": {
            "Lines fitted there meet on its points": ghost_lines_meet_on_its_points,
            "the blue arm is really in another pose": lambda: not same_pose("tour/assumption"),
        },
        "after": {"**E** grows from": E_grows_all_the_way},
        "say": {
            "no lines can fit all points": lambda: state("tour/assumption").start.E > 100,
            "The misfit that remains is **the conflict**": E_is_the_mean_square,
        },
        "note": REPORT,
        "question": DEFINITION,
        "close": {"the crossing follows its own hand, but not exactly": crossing_goes_with_the_own_hand},
        "far": {"close to the blue hand": crossing_goes_with_the_own_hand},
        "elsewhere 1": {
            "the crossing follows its hand, but not exactly": crossing_goes_with_the_own_hand,
            "fitted through the learner's own points": fitted_through_own_points,
        },
        "elsewhere 2": {"gone along with the blue hand": crossing_goes_with_the_own_hand},
    },
    "tour/signpost": {
        "title": DEFINITION,
        "text": DEFINITION,
        "after": {
            "the dot named “hand” has an arrow of": lambda: on_link(9) == 7 and arrow_px(9) < 0.1 * way_px(9),
            "The one named “base” has an arrow of": lambda: on_link(3) <= 1 and arrow_px(3) > 50,
            "nowhere to go": lambda: way_px(3) < 1e-9,
        },
        "say": {
            "**a contradiction, not a signpost**": lambda: no_arrows_show_the_way() == 2,
            "combined in E, show how strong the contradiction is": E_grows_all_the_way,
        },
        "question": DEFINITION,
        "answers": no_arrows_show_the_way,
        "because 1": {
            "Even the base has long arrows, and the base never moves": lambda: arrow_px(3) > 50 and way_px(3) < 1e-9
        },
        "because 2": {
            "one of them is only": lambda: arrow_px(9) < 0.1 * way_px(9),
        },
        "because 3": {
            "They point nearly across it": lambda: abs(oracles.cosine(state("tour/signpost"))) < np.cos(np.radians(80)),
            "Over many random pairs of poses, its median is": lambda: 0 < fact("tour/signpost", "median cosine") < 0.5,
        },
    },
    "tour/carried": {
        "title": DEFINITION,
        "text": {
            "the two poses stay as different as they were": lambda: np.array_equal(
                oracles.carried_to(state("tour/carried"), 1, 1).start.theta_demo, state("tour/carried").start.theta_demo
            )
        },
        "after": {
            "Sideways it is": lambda: abs(E_carried(0, 0.5) / state("tour/carried").start.E - 1) < 0.5,
            "farther away": lambda: E_carried(2, 0) < E_carried(0.5, 0) < state("tour/carried").start.E,
            "nearer": lambda: E_carried(*oracles.NEARER) > state("tour/carried").start.E,
            "Over all places shown, the largest E is": lambda: 1.5 < times_by_place() < 2.5,
            "Shape alone takes E from": lambda: shape_alone_changes_E() > 100,
            "With far cameras, carrying would not change it": far_eyes_do_not_notice,
        },
        "say": {
            "**shape, not about place**": lambda: shape_alone_changes_E() > 50 * np.ptp(np.log(E_at_places())),
            "each picture is compared about its own centre: the mean place of its points is subtracted first": (
                shifting_a_picture_does_not_change_E
            ),
        },
        "question": DEFINITION,
        "answers": lambda: 1 if 1.5 < times_by_place() < 2.5 else 0,
        "because 1": {
            "Farther away, E even falls": lambda: (
                E_carried(2, 0) < E_carried(1, 0) < E_carried(0.5, 0) < E_carried(0, 0)
            ),
            "partly because the demonstrator's pictures get smaller": smaller_pictures_make_E_smaller,
        },
        "because 2": {
            "moves all points of a picture together, and the lines allow that": shifting_a_picture_does_not_change_E,
            "Another shape makes a factor of": lambda: shape_alone_changes_E() > 100,
        },
        "because 3": {
            "Only equal shapes give zero": lambda: shape_alone_changes_E() > 100,
            "Right beside the learner": lambda: min(E_carried(0, -0.6), E_carried(0, -1.0)) > 100,
        },
    },
    "tour/number": {
        "title": DEFINITION,
        "text": {"take the mean over both pictures and all points": E_is_the_mean_square},
        "after": REPORT,
        "say": {
            "E is the mean of the squared arrow lengths": E_is_the_mean_square,
            "Long arrows count far more than short ones": lambda: part_of_a_doubled_arrow() > 2,
        },
        "question": DEFINITION,
        "answers": lambda: (2, 4, 8).index(round(part_of_a_doubled_arrow())),
        "because 1": DEFINITION,
        "because 2": {"twice the length, four times the square": lambda: abs(part_of_a_doubled_arrow() - 4) < 1e-9},
        "because 3": DEFINITION,
    },
    "tour/servo": {
        "title": DEFINITION,
        "text": {
            "You see these two pictures and one number": lambda: all(map(middle_does_not_win, sampled("tour/servo")))
        },
        "after": REPORT,
        "say": {"It does not tell you that you have arrived": lambda: min(widths("tour/servo")) > 1},
        "question": {
            "Bring E below the goal": lambda: all(
                records.minima(one).E[0] < design.LEAST_E for one in sampled("tour/servo")
            )
        },
    },
    "tour/claim": {
        "title": DEFINITION,
        "text": DEFINITION,
        "after": REPORT,
        "say": {"How much it leaves open depends on the points": lambda: five_points_leave_more_open()},
        "question": {
            "how many degrees off could an arm be": lambda: all(1 < width < 90 for width in widths("tour/claim"))
        },
        "close": REPORT,
        "far": {"E is a valley, longer than it is wide": E_is_a_valley},
        "less": {"along its valley, E hardly rises": E_is_a_valley},
    },
    "tour/bowl": {
        "title": {"The bowl": one_bowl},
        "text": REPORT,
        "say": {
            "E is a single bowl": one_bowl,
            "Its lowest spot is near the demonstrator's pose": lambda: biases().max() < 10,
            "not always on it": lambda: biases().max() > 1,
        },
        "note": REPORT,
        "question": DEFINITION,
        "close": {"your hands have learned the bowl": one_bowl},
        "far": {"you walked down this bowl": one_bowl},
    },
    "tour/feel": {
        "title": DEFINITION,
        "text": {"all forty picture coordinates": lambda: state("tour/feel").start.views.own.size == 40},
        "after": {
            "the gradient law would be slower still": lambda: gradient_is_slower(),
        },
        "say": {"The pictures say what": lambda: who_needs_fewer() == 1},
        "question": DEFINITION,
        "answers": who_needs_fewer,
        "because 1": {"The others get forty": lambda: state("tour/feel").start.views.own.size == 40},
        "because 2": {"lets them work out E before they move": lambda: who_needs_fewer() == 1},
        "because 3": {"they learn different things from a step": lambda: who_needs_fewer() == 1},
    },
}


def same_pose(key: str) -> bool:
    return np.array_equal(state(key).start.theta, state(key).start.theta_demo)


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


def five_points_leave_more_open() -> bool:
    one = state("tour/claim")
    return widest_deg(one.with_settings(points=5), GOAL) > 2 * widest_deg(one, GOAL)


def gradient_is_slower() -> bool:
    """In the median over the sampled states; it mostly never gets there."""
    printed, retuned = (np.nan_to_num(steps(servo), nan=np.inf) for servo in ("gradient", "gradient-retuned"))
    return bool((printed >= retuned).all())
