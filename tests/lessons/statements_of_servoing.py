"""Statements of the lesson about the image Jacobian, and of the eight questions."""

from functools import cache

import numpy as np
import oracles
import statements_of_failures as failures
import statements_of_geometry as geometry
from statements import DEFINITION, REPORT, Statements, fact, sampled, state, step_named
from viewimit.app.lab.lessons import design, facts, records
from viewimit.app.lab.lessons.situation import Situation

from viewimit import Settings

GAIN_PROBE_DEG, TURNED_PROBE_DEG = 15.0, 5.0  # of each joint, from which the first Jacobian is learned
TURNED_GAIN, TURNED_POINT = 0.3, 9


@cache
def gain(value: float) -> oracles.Servoing:
    one = state("jacobian/gain")
    return oracles.teach_by_showing(one, value, True, range(40), GAIN_PROBE_DEG)


@cache
def turned(roll_deg: float, update: bool) -> oracles.Servoing:
    coordinates = (4 * TURNED_POINT, 4 * TURNED_POINT + 1)
    one = state("jacobian/turned")
    return oracles.teach_by_showing(one, TURNED_GAIN, update, coordinates, TURNED_PROBE_DEG, roll_deg)


def on_a_limit(made: oracles.Servoing) -> bool:
    scene = state("jacobian/turned").scene
    last = made.postures[-1]
    return bool((np.abs(last - scene.lower) < 1e-6).any() or (np.abs(last - scene.upper) < 1e-6).any())


def turns_of_steps(roll_deg: float) -> np.ndarray:
    """Degrees from the way to the goal to each of the first steps, in the picture."""
    made = turned(roll_deg, False)
    ways, moves = made.goal - made.images[:6], np.diff(made.images[:7], axis=0)
    across = ways[:, 0] * moves[:, 1] - ways[:, 1] * moves[:, 0]
    return np.degrees(np.arctan2(across, np.einsum("ij,ij->i", ways, moves)))


def steps_go_sideways() -> bool:
    return bool((turns_of_steps(90) < -35).all() and (np.abs(turns_of_steps(0)) < 20).all())


def straight_spiral_or_away() -> int:
    made = turned(90, False)
    if made.off_px[-1] > made.off_px[0]:
        return 2
    return 1 if abs(made.turns) > 1 else 0


def fastest_gain() -> int:
    return int(np.nanargmin([gain(value).steps() for value in (0.1, 1.0, 2.2)]))


def a_tenth_goes_each_step() -> bool:
    ratios = gain(0.1).off_px[1:30] / gain(0.1).off_px[:29]
    return abs(float(np.median(ratios)) - 0.9) < 0.03


def beyond_the_goal_again_and_again() -> bool:
    """Each step's end lies on the other side of the goal: the offsets of successive images oppose each other."""
    off = gain(2.2).images[-10:] - gain(2.2).goal
    return bool((np.einsum("ij,ij->i", off[1:], off[:-1]) < 0).all())


def second_step_corrects() -> bool:
    off = gain(1.0).off_px
    return 2 < off[1] < 0.2 * off[0] and off[2] < 2


def jacobian_changes_with_the_pose() -> bool:
    """Columns of the ringed point's Jacobian in L change by a third of their length over 40°, in each sampled state."""
    for one in sampled("jacobian/knobs"):
        theta = one.start.theta_demo

        def jacobian(at: np.ndarray, world=one.world) -> np.ndarray:
            h = 1e-4
            seen = [world.own_images(at + s * h * e)[0][8, :2] for e in np.eye(2) for s in (1, -1)]
            return np.array([(seen[0] - seen[1]) / (2 * h), (seen[2] - seen[3]) / (2 * h)])

        here, there = jacobian(theta), jacobian(theta + np.radians([-20, 40]))
        if (np.linalg.norm(there - here, axis=1) < np.linalg.norm(here, axis=1) / 3).any():
            return False
    return True


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


@cache
def medians() -> tuple[float, float]:
    return tuple(fact("jacobian/forty", f"median steps of {name}") for name in ("the gradient law", "Broyden"))


def printed_gain_never_arrives() -> float:
    """Share of the race's starts from which the paper's own gain does not reach the goal."""
    made = [
        records.motions_to(records.run(one, "gradient"), design.RACE_GOAL)
        for one in design.race_starts(state("jacobian/forty"))
    ]
    return float(np.isnan(made).mean())


def retuned_arrives() -> bool:
    return all(
        np.isfinite(records.motions_to(records.run(one, "gradient-retuned"), design.RACE_GOAL))
        for one in design.race_starts(state("jacobian/forty"))
    )


def sampled_truths_are_on_the_scale() -> bool:
    made = [records.motions_to(records.run(one, "gradient-retuned"), 3.0) for one in sampled("jacobian/forty")]
    return bool(np.nanmin(made) > 5 and np.nanmax(made) < 500)


USUAL = Situation(Settings.paper(demonstrator_deg=(45, -90), start_deg=(25, -25)))
SAME = Situation(Settings.paper(demonstrator_deg=(62, -118), start_deg=(62, -118)))


def four_px_at_14_degrees() -> bool:
    return round(1 / np.tan(np.radians(14))) == 4


def smaller_angle_moves_farther() -> bool:
    return bool((np.diff(1 / np.tan(np.radians(np.arange(2, 90, 4)))) < 0).all())


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


def perfect_cameras_show_marks() -> bool:
    return SAME.with_settings(start_deg=(25, -45), noise_px=0.0).start.E > 100


def where_the_other_stands_does_not_matter() -> bool:
    """The marks lie in L and R: carried, E stays about the same size."""
    one = SAME.with_settings(start_deg=(25, -45))
    return 0.5 < oracles.carried_to(one, 1, 1).start.E / one.start.E < 1


def any_rigid_object_gives_the_same_lines() -> bool:
    """The geometry of l and L fitted to other points of the same body in the same pose, with affine cameras, is equal:
    here to perspective, in direction within 2°."""

    def direction(points: int) -> float:
        views = SAME.with_settings(points=points).start.views
        f = np.linalg.svd(
            np.concatenate([views.demo_left, views.own_left], 1)
            - np.concatenate([views.demo_left, views.own_left], 1).mean(0)
        )[2][3]
        return np.degrees(np.arctan2(f[3], f[2])) % 180

    apart = abs(direction(10) - direction(20))
    return min(apart, 180 - apart) < 2


def joints_change_E_together() -> bool:
    """The best shoulder depends on the elbow: along E's smallest values it moves by more than 10°."""
    found = records.landscape(USUAL)
    best = np.degrees(found.axes[0][np.argmin(found.E, axis=0)])
    return float(np.ptp(best[15:45])) > 10


def averaging_leaves_perspective() -> bool:
    return failures.million_frames_fall_on() == 1


def noise_shrinks_tenfold() -> bool:
    drawn = np.random.default_rng(1).normal(0, 1, (4_000, 100)).mean(1).std()
    return abs(drawn - 0.1) < 4 * 0.1 / np.sqrt(2 * 4_000)


def hand_keeps_its_shape() -> bool:
    """The distances of the points on the hand are the same in every pose."""
    one = failures.sign.signed_runs()[1].situation
    shapes = []
    for theta in (np.radians([62, -118]), np.radians([10, -20])):
        points = one.world.points_world(theta, one.world.T_world_own)
        shapes.append(np.linalg.norm(points[:, None] - points, axis=-1))
    return np.abs(shapes[0] - shapes[1]).max() < 1e-9


def any_elbow_has_a_small_E() -> bool:
    """For every elbow, some shoulder has an E below 0.3 px²."""
    one = failures.sign.signed_runs()[1].situation
    return bool((np.nanmin(records.landscape(one).E, axis=0) < 0.3).all())


def elbow_is_free_without_noise() -> bool:
    return (
        failures.sign.signed_runs()[1].settings.noise_px == 0 and fact_of_questions("elbow off with hand points") > 90
    )


def fact_of_questions(name: str) -> float:
    return float(facts.FACTS[name].of(USUAL))


def assumed() -> bool:
    """Numbers that a question assumes need no check."""
    return True


STATEMENTS: Statements = {
    "jacobian": {"about": DEFINITION},
    "jacobian/knobs": {
        "title": DEFINITION,
        "text": DEFINITION,
        "after": REPORT,
        "say": {
            "Turns teach it": jacobian_learned_from_turns_predicts,
            "It changes with the pose": jacobian_changes_with_the_pose,
        },
        "question": {"You have 8 turns": lambda: step_named("jacobian/knobs").ask.times == 8},
    },
    "jacobian/gain": {
        "title": DEFINITION,
        "text": {"0.1, 1 or 2.2 times that step": lambda: fastest_gain() == 1},
        "after": {
            "Gain 0.1 took": lambda: gain(0.1).steps() > 5 * gain(1.0).steps(),
            "gain 1 took": lambda: gain(1.0).steps() < 5,
            "Gain 2.2 never arrived": lambda: np.isnan(gain(2.2).steps()),
            "it jumps to and fro": beyond_the_goal_again_and_again,
            "{px at 2.2} off": lambda: gain(2.2).off_px[-10:].min() > 20,
        },
        "say": {
            "If the gain is too small, the arm crawls": lambda: gain(0.1).steps() > 20,
            "If it is above two, the arm jumps to and fro across the goal and never arrives": lambda: (
                beyond_the_goal_again_and_again() and np.isnan(gain(2.2).steps())
            ),
        },
        "question": DEFINITION,
        "answers": fastest_gain,
        "because 1": {"Each one removes only a tenth of the distance that is left": a_tenth_goes_each_step},
        "because 2": {"misses, and the second corrects that": second_step_corrects},
        "because 3": {
            "It lands beyond the goal, turns back, and lands beyond it again": beyond_the_goal_again_and_again
        },
    },
    "jacobian/turned": {
        "title": DEFINITION,
        "text": {"turns its camera by 90° about its axis": lambda: straight_spiral_or_away() == 1},
        "after": {
            "The old Jacobian took": lambda: turned(90, False).steps() > 3 * turned(0, False).steps(),
            "It errs badly once": lambda: turned(90, True).off_px.max() > 1.5 * turned(90, True).off_px[0],
            "then gets within 2 px after": lambda: turned(90, True).steps() < turned(90, False).steps(),
            "with the camera turned the other way round, the arm runs into its limit": lambda: on_a_limit(
                turned(-90, False)
            ),
        },
        "say": {
            "if it **keeps learning** how its pictures react": lambda: (
                turned(90, True).steps() <= turned(0, False).steps() < turned(90, False).steps()
            )
        },
        "question": DEFINITION,
        "answers": straight_spiral_or_away,
        "because 1": {"each step comes out turned to one side, because the camera is turned": steps_go_sideways},
        "because 2": {
            "Each step goes off to the side, and so does the next one": lambda: abs(turned(90, False).turns) > 1
        },
        "because 3": {
            "At 180°, the dot flees": lambda: turned(180, False).off_px[-1] > 1.5 * turned(180, False).off_px[0],
            "At 90°, each step goes sideways": steps_go_sideways,
        },
    },
    "jacobian/forty": {
        "title": DEFINITION,
        "text": {
            "all forty coordinates of its ten points": lambda: state("jacobian/forty").start.views.own.shape == (10, 4)
        },
        "after": {"the medians were": lambda: medians()[0] > 10 * medians()[1]},
        "say": {"The pictures say what": lambda: medians()[0] > 10 * medians()[1]},
        "question": {
            "From most starts": sampled_truths_are_on_the_scale,
        },
        "close": DEFINITION,
        "less": {"It needs more": lambda: medians()[0] > medians()[1]},
        "far": {
            "It needs fewer, with a suitable gain": retuned_arrives,
            "With the gain printed in the paper, it usually never arrives": lambda: printed_gain_never_arrives() > 0.7,
        },
    },
    "questions/line": {
        "text": DEFINITION,
        "answers": lambda: 0 if geometry.one_dot_and_a_line() else 3,
        "because 1": {"All the places in that direction form a line": geometry.one_dot_and_a_line},
        "because 2": {"the object appears somewhere else": lambda: not geometry.same_pixel()},
        "because 3": {"One picture does not show that": geometry.one_dot_and_a_line},
        "because 4": {"it moves the mark along one line": geometry.one_dot_and_a_line},
    },
    "questions/line-needs": {
        "text": DEFINITION,
        "answers": lambda: 0 if geometry.lines_come_from_images_alone("tour/line") else 1,
        "because 1": {
            "Points matched in both pictures reveal that on their own": lambda: geometry.lines_come_from_images_alone(
                "tour/line"
            ),
            "four are enough, and a fifth tests them": lambda: (
                geometry.four_fit_anything() and geometry.fifth(True).max() < 1
            ),
        },
        "because 2": {"The line is all you can draw without it": geometry.one_dot_and_a_line},
        "because 3": {"Any rigid object gives the same ones": any_rigid_object_gives_the_same_lines},
        "because 4": {
            "Matched points already contain the effect of the lenses": lambda: geometry.lines_come_from_images_alone(
                "tour/line"
            )
        },
    },
    "questions/flat": {
        "text": DEFINITION,
        "answers": lambda: 0 if lines_hold_across() else 2,
        "because 1": {"At 14°, shifting a line by one pixel moves the crossing by four pixels": four_px_at_14_degrees},
        "because 2": {"The smaller the angle, the farther": smaller_angle_moves_farther},
        "because 3": {"Across the lines, both hold the crossing in place": lines_hold_across},
        "because 4": DEFINITION,
    },
    "questions/conflict": {
        "text": DEFINITION,
        "answers": lambda: 0 if marks_stay_near_the_own_points() and lines_cross_where_the_own_points_are() else 1,
        "because 1": {"The poses are not the same, so the marks are wrong": lines_cross_where_the_own_points_are},
        "because 2": {
            "That is true only once the poses agree": lines_cross_where_the_own_points_are,
            "the marks stay near the robot's own points and follow them": marks_stay_near_the_own_points,
        },
        "because 3": {"where the other robot stands in the room": where_the_other_stands_does_not_matter},
        "because 4": {"Perfect cameras would show the marks too": perfect_cameras_show_marks},
    },
    "questions/converse": {
        "text": DEFINITION,
        "answers": lambda: 0 if fact_of_questions("open with five points") > 10 else 1,
        "because 1": {
            "Four fit any pose": lambda: failures.largest(4) < 1e-9,
            "With E below 1 px², five points leave": lambda: (
                facts.OPEN_BELOW == 1
                and fact_of_questions("open with five points") > 5 * fact_of_questions("open with ten points") > 5
            ),
        },
        "because 2": {"a few points fit many poses": lambda: fact_of_questions("open with five points") > 10},
        "because 3": {"Only their shapes are compared": geometry.far_eyes_do_not_notice},
        "because 4": {"in the paper, by 4°": lambda: facts.PAPER_BIAS_DEG == 4},
    },
    "questions/step": {
        "text": {"E rises from 40 to 60": assumed},
        "answers": lambda: 0 if jacobian_learned_from_turns_predicts() else 2,
        "because 1": {"has seen how E, and the picture, react to this joint": jacobian_learned_from_turns_predicts},
        "because 2": {"both joints change E together": joints_change_E_together},
        "because 3": DEFINITION,
        "because 4": DEFINITION,
    },
    "questions/bias": {
        "text": {
            "4° off the right one": lambda: failures.biases()[0] > 4 > failures.biases()[2],
            "Averaging 100 pictures": averaging_leaves_perspective,
        },
        "answers": lambda: 0 if averaging_leaves_perspective() else 1,
        "because 1": {"The 4° come from perspective": lambda: oracles.without_depth(state("limits/minimum")) < 1e-9},
        "because 2": {"Dividing by the square root of 100 works for noise": noise_shrinks_tenfold},
        "because 3": DEFINITION,
        "because 4": {"More of the same pictures do not improve the model": averaging_leaves_perspective},
    },
    "questions/claim": {
        "text": {
            "E is 0.04 px²": lambda: round(failures.E_of_run(2), 2) == 0.04,
        },
        "answers": lambda: 0 if any_elbow_has_a_small_E() else 1,
        "because 1": {
            "Marks on one rigid part keep their shape in every pose": hand_keeps_its_shape,
            "with its elbow": lambda: fact_of_questions("elbow off with hand points") > 90,
        },
        "because 2": {"These marks allow any angle": any_elbow_has_a_small_E},
        "because 3": {"the hand has the same shape in every pose": hand_keeps_its_shape},
        "because 4": {"Even without any noise, the elbow could be at any angle": elbow_is_free_without_noise},
    },
}
