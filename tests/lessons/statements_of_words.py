"""Statements of the glossary."""

from functools import cache
from unittest import mock

import numpy as np
import oracles
import statements_of_failures as failures
import statements_of_geometry as geometry
import statements_of_servoing as servoing
from statements import DEFINITION, Statements, state
from viewimit.app.lab.lessons import facts, records

from viewimit import Session, Settings
from viewimit.analysis.landscape import conflict_at
from viewimit.drawing.glossary import glossary
from viewimit.estimation.transfers import TRANSFERS, projective
from viewimit.geometry.affine import MIN_POINTS
from viewimit.loop.settings import FIELDS
from viewimit.servo.gradient import PAPER
from viewimit.servo.trust_region.options import DEFAULTS, MAX_STD_PER_PX
from viewimit.simulation.scene import load_scene

RANDOM_STARTS = 40  # of 800 that the study has
AT_ONCE = 14  # motions after which the law's memory is halved


@cache
def example(key: str) -> Session:
    """The session that an entry shows, played to its end if the entry plays."""
    entry = glossary()[key]
    session = Session(entry.show)
    if entry.plays:
        session.run(200, patience=3)
    return session


def scale_begins_at(key: str, good: float, bad: float) -> bool:
    scale = glossary()[key].scale
    return scale is not None and (scale.good, scale.bad) == (good, bad)


def status_of(key: str) -> str:
    return str(example(key).snapshot.status)


def off_deg(key: str) -> float:
    last = example(key).snapshot
    return records.degrees_off(last.theta, last.theta_demo)


@cache
def random_starts() -> list[tuple[str, float]]:
    """How the default method ends from random starts: status and degrees off."""
    scene, ends = load_scene(), []
    rng = np.random.default_rng(3)
    low, high = np.array(scene.range_deg, float).T
    while len(ends) < RANDOM_STARTS:
        demo, start = rng.uniform(low, high, (2, 2))
        session = Session(Settings(demonstrator_deg=tuple(demo), start_deg=tuple(start)))
        result = session.run(60)
        ends.append((str(result.status), records.degrees_off(result.theta, np.radians(demo))))
    return ends


def basin() -> float:
    return records.landscape(servoing.USUAL, 1.0).basin_fraction()


def joints_are_free(points: str) -> bool:
    fields = {"five": {"points": 5}, "forearm": {"scene": "panda-forearm", "start_deg": (-50, 60)}}[points]
    return str(Session(Settings(**fields)).run(60).status) == "unobservable"


def a_large_price_makes_it_linear() -> bool:
    views = state("tour/feel").start.views
    with mock.patch.object(projective, "PRIOR", 1e6):
        found = TRANSFERS["projective"](views).conflict(views)
    linear, exact = (TRANSFERS[name](views).conflict(views) for name in ("linear", "projective"))
    return abs(found / linear - 1) < 1e-3 and abs(exact / linear - 1) > 1e-3


def residuals_are_hundreds_at_first() -> bool:
    one = geometry.state("tour/feel")
    return one.start.E > 200


def hidden_points_do_not_count() -> bool:
    now = example("points_seen").snapshot
    return np.array_equal(now.usable, now.views.visible.all(-1)) and not now.usable.all()


def swapped_makes_one_long() -> bool:
    lengths = np.linalg.norm(example("largest_e").snapshot.e.reshape(-1, 2), axis=1)
    return float(np.nanmax(lengths) / np.nanmean(lengths)) > 5


def hand_arrow_is_no_signpost() -> bool:
    return geometry.no_arrows_show_the_way() == 2


def size_falls_with_distance() -> bool:
    one = state("tour/carried")
    near, far = (oracles.carried_to(one, back, 0).start.views.demo.std(0).mean() for back in (0, 2))
    return far < near


def images_alone() -> bool:
    return geometry.lines_come_from_images_alone("tour/line")


def curved_in_both_directions() -> bool:
    """About the minimum of the usual scene, E rises in every direction, by more than 0.1 px² at 5°."""
    one = servoing.USUAL
    found, start = records.minima(one), one.start
    angles = np.linspace(0, 2 * np.pi, 36)
    ring = found.theta[0][:, None] + np.radians(5) * np.array([np.cos(angles), np.sin(angles)])
    E = conflict_at(one.world, start.fit, start.views.demo, start.views.visible[:, :2], ring)[0]
    return bool((E > found.E[0] + 0.1).all())


STATEMENTS: Statements = {
    "glossary/E": {
        "sentence": {
            "The mean square of the residuals": geometry.E_is_the_mean_square,
            "Where they are not, no lines fit all points": geometry.E_grows_all_the_way,
        },
        "good": {"Near 0": lambda: state("tour/line").with_settings(transfer="projective").start.E < 1e-6},
        "bad": {"the transfer does not fit these views": lambda: failures.biases()[0] > 1},
    },
    "glossary/mean_e": {
        "sentence": DEFINITION,
        "good": {"Below 0.5 px": lambda: scale_begins_at("mean_e", 0.5, 2)},
        "bad": {"Above 2 px": lambda: scale_begins_at("mean_e", 0.5, 2)},
    },
    "glossary/largest_e": {
        "sentence": DEFINITION,
        "good": {"About twice the mean": lambda: scale_begins_at("largest_e", 2.5, 5)},
        "bad": {"Many times the mean: two points are taken for each other": swapped_makes_one_long},
    },
    "glossary/condition": {
        "sentence": {"large where lines cross at a small angle": failures.wider_is_steeper},
        "good": {"Below 40": lambda: scale_begins_at("condition", 40, 200)},
        "bad": {
            "High from 40, too high from 200": lambda: scale_begins_at("condition", 40, 200),
            "A low one does not say that the points tell every joint": lambda: (
                state("limits/unobservable").with_settings(transfer="epipolar").start.transfer.condition < 40
            ),
        },
    },
    "glossary/flatness": {
        "sentence": DEFINITION,
        "good": {"Below 40": lambda: scale_begins_at("flatness", 40, 200)},
        "bad": {
            "High from 40, too high from 200": lambda: scale_begins_at("flatness", 40, 200),
            "the points nearly lie in a plane": lambda: example("flatness").snapshot.flatness > 200,
        },
    },
    "glossary/points_seen": {
        "sentence": {"Only a point that is seen in all four images": hidden_points_do_not_count},
        "good": DEFINITION,
        "bad": {
            "Below five": lambda: MIN_POINTS == 5,
            "four of which fit any images": lambda: failures.largest(4) < 1e-9,
        },
    },
    "glossary/cost": {
        "sentence": DEFINITION,
        "good": {"A few degrees": lambda: 1 < np.degrees(records.costs(servoing.USUAL)).max() < 10},
        "bad": {"From 20° a pixel the joint is not observable": lambda: round(np.degrees(MAX_STD_PER_PX), 9) == 20},
    },
    "glossary/bias": {
        "sentence": {
            "Perspective is its main cause": lambda: oracles.without_depth(state("limits/minimum")) < 1e-9,
            "averaging does not remove it": servoing.averaging_leaves_perspective,
        },
        "good": {"Up to 4°, as the paper's own": lambda: facts.PAPER_BIAS_DEG == 4},
        "bad": {
            "a perfect servo ends that far off": lambda: (
                records.minima(state("limits/minimum")).E[0] < state("limits/minimum").start.E
            )
        },
    },
    "glossary/basin": {
        "sentence": DEFINITION,
        "good": {"99 % and more": lambda: basin() >= 0.99},
        "bad": {"ends in another hollow": lambda: records.landscape(verged(), 1.0).basin_fraction() < 0.99},
    },
    "glossary/frames": {
        "sentence": {"noise falls with the root of their number": failures.noise_cancels_by_the_root},
        "good": {"25": lambda: Settings().frames == 25},
        "bad": {"1, where images are noisy": lambda: FIELDS["frames"].bounds[0] == 1},
    },
    "glossary/lambda": {
        "sentence": {"the nearer this transfer comes to the linear one": a_large_price_makes_it_linear},
        "good": {"1 px², against hundreds of px² of residuals at first": residuals_are_hundreds_at_first},
        "bad": {
            "the transfer is then the linear one": a_large_price_makes_it_linear,
            "with its bias": lambda: records.bias_deg(state("limits/minimum"), "linear") > 1,
        },
    },
    "glossary/Q": {
        "sentence": {"Near its least value E is a bowl": geometry.one_bowl},
        "good": {"Both eigenvalues well above 0": curved_in_both_directions},
        "bad": {"One near 0: a valley": lambda: failures.unobservable_answer() == 0},
    },
    "glossary/rho": {
        "sentence": {"at 0.95 what was learned 14 steps ago counts half": lambda: abs(0.95**AT_ONCE - 0.5) < 0.02},
        "good": {"0.95, as printed": lambda: PAPER.forgetting == 0.95},
        "bad": {
            "Where steps shrink with E, nothing new is learned": lambda: servoing.printed_gain_never_arrives() > 0.7
        },
    },
    "glossary/D": {
        "sentence": DEFINITION,
        "good": {"Tens of degrees": lambda: np.degrees(DEFAULTS.first_radius) > 10},
        "bad": DEFINITION,
    },
    "glossary/own_views": {
        "sentence": {"They stay close to the dots and follow them": servoing.marks_stay_near_the_own_points}
    },
    "glossary/demo_views": {
        "sentence": {
            "That and L, R are all that the learner has": lambda: failures.learner_sees_images_only("motion/alike")
        }
    },
    "glossary/transfer": {
        "sentence": {
            "from matched points alone: no calibration, no 3-D": lambda: geometry.lines_come_from_images_alone(
                "tour/line"
            )
        },
        "good": {
            "E is 0 at the demonstrator's posture": lambda: (
                state("tour/line").with_settings(transfer="projective").start.E < 1e-6
            )
        },
        "bad": {"affine transfers with a head that looks inwards": lambda: records.bias_deg(verged()) > 4},
    },
    "glossary/servo": {
        "sentence": {"It knows its own steps and images": lambda: failures.learner_sees_images_only("motion/alike")},
        "good": {"A handful of steps": lambda: servoing.medians()[1] < 8},
        "bad": {"mostly without converging": lambda: servoing.printed_gain_never_arrives() > 0.7},
    },
    "glossary/probe": {
        "sentence": DEFINITION,
        "good": {"One a joint, at the start": lambda: [one.probe for one in example("probe").history].count(True) == 2},
    },
    "glossary/converged": {
        "sentence": {"E rises in every direction": lambda: failures.rises_all_around(9) and failures.verified(9)},
        "good": {
            "true from all of 800 random starts": lambda: all(
                status == "converged" and off < 1 for status, off in random_starts()
            )
        },
        "bad": {"it is not said": lambda: status_of("converged") != "converged"},
    },
    "glossary/unobservable": {
        "sentence": {
            "by 20° or more": lambda: round(np.degrees(MAX_STD_PER_PX), 9) == 20,
            "E is a valley": lambda: failures.unobservable_answer() == 0,
        },
        "bad": {
            "With five points": lambda: joints_are_free("five"),
            "with all points on the forearm": lambda: joints_are_free("forearm"),
        },
    },
    "glossary/settled": {
        "sentence": {"Broyden's law looks for none": lambda: broyden_makes_no_claim()},
        "bad": {"It may be degrees away": lambda: records.degrees_off(*five_points_broyden()) > 2},
    },
    "glossary/no-progress": {"sentence": DEFINITION, "bad": DEFINITION},
    "glossary/too-few-points": {
        "sentence": {
            "Fewer than five points": lambda: MIN_POINTS == 5,
            "four fit any images exactly": lambda: failures.largest(4) < 1e-9,
        }
    },
    "glossary/truth": {
        "sentence": DEFINITION,
        "good": {"Below 1°": lambda: scale_begins_at("truth", 1, 4)},
        "bad": DEFINITION,
    },
    "glossary/epipolar-line": {"sentence": {"another camera sees this ray as a line": geometry.one_dot_and_a_line}},
    "glossary/epipole": {
        "sentence": {
            "so all their lines pass through it": geometry.all_lines_pass_the_epipole,
            "the lines are nearly parallel": lambda: geometry.angle_at(10) < 1,
        }
    },
    "glossary/correspondence": {
        "sentence": {"each must carry the right label": lambda: failures.swapped_answer() == 2},
    },
    "glossary/fundamental-matrix": {
        "sentence": {
            "For far cameras there are four of them, and four correspondences fix them": geometry.four_fit_anything,
            "A fifth one tests them": lambda: geometry.fifth(False).min() > geometry.fifth(True).max(),
        }
    },
    "glossary/affine-camera": {"sentence": {"all epipolar lines are parallel": lambda: geometry.angle_at(1000) < 0.01}},
    "glossary/perspective": {
        "sentence": {
            "The size of a thing in a picture falls with its distance": size_falls_with_distance,
            "so the lowest E is beside the true pose": lambda: failures.biases()[0] > 1,
        }
    },
    "glossary/baseline": {
        "sentence": {"The wider it is, the more steeply the two lines of a point cross": failures.wider_is_steeper}
    },
    "glossary/triangulation": {
        "sentence": {"The point is where the lines cross": lambda: geometry.crossing_is_equation_4("ray/two")}
    },
    "glossary/rectification": {
        "sentence": {
            "as eyes that look straight ahead would see them": failures.straight_eyes_see_equal_rows,
            "Matched points alone say how": lambda: failures.row_difference(rectified=True) < 1e-3,
        }
    },
    "glossary/residual": {"sentence": {"it does not show where the point has to go": hand_arrow_is_no_signpost}},
    "glossary/image-jacobian": {
        "sentence": {"The learner finds it by trying": servoing.jacobian_learned_from_turns_predicts}
    },
    "glossary/visual-servoing": {"sentence": DEFINITION},
    "glossary/noise": {
        "sentence": {
            "Averaging n pictures divides it by the square root of n": failures.noise_cancels_by_the_root,
            "It does not change the bias": servoing.averaging_leaves_perspective,
        }
    },
    "glossary/fixed-geometry": {
        "sentence": {
            "They are right only if both arms were in the same pose when they were fitted": lambda: (
                failures.early_draws() != 0 and failures.right("motion/frozen").draws == "the circle"
            )
        }
    },
}


@cache
def verged():
    """The verged head of the shipped scene, whose images are not rectified."""
    return servoing.USUAL.with_settings(scene="panda-verged", rectify="off")


def broyden_makes_no_claim() -> bool:
    last = records.run(servoing.USUAL, "broyden").snapshot
    return last.certificate is None and str(last.status) == "settled"


def five_points_broyden() -> tuple[np.ndarray, np.ndarray]:
    last = records.run(servoing.USUAL.with_settings(points=5), "broyden").snapshot
    return last.theta, last.theta_demo
