"""Statements of the lessons about why the method fails, carried motions, methods of one's own, and claims."""

from functools import cache

import numpy as np
import oracles
from statements import DEFINITION, REPORT, Statements, fact, sampled, state, step_named
from viewimit.app.lab.lessons import design, facts, records, sign
from viewimit.app.lab.lessons.circle import DRAWS, Followed, follow_circle
from viewimit.app.lab.lessons.situation import Situation

from viewimit.analysis.construction import CHI2_95, construct
from viewimit.analysis.landscape import conflict_at
from viewimit.analysis.observability import residual_jacobian, sample_estimates
from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.views import FourViews

FAR = 10.0  # times the distance
CROSSING_POINT = 6
SIGMAS = 4.0


def exponent(share: float) -> float:
    """p, where a quantity falls with the p-th power of the distance, to this share at FAR."""
    return float(-np.log(share) / np.log(FAR))


def both_arms_stay_as_large() -> bool:
    one = state("limits/minimum")
    far = one.with_eyes(distance=FAR)
    spread = [np.concatenate([x.start.views.demo, x.start.views.own], 1).std(0).mean() for x in (one, far)]
    return abs(spread[1] / spread[0] - 1) < 0.15


def bias_everywhere_the_same_without_noise() -> bool:
    """Two looks with different seeds see the same."""
    one = state("limits/minimum")
    return one.with_settings(seed=1).start.E == one.with_settings(seed=2).start.E


def biases() -> np.ndarray:
    return np.array(records.biases(state("limits/minimum"))["degrees"]["epipolar"])


def crossing(baseline: float) -> tuple[float, float, float]:
    """Angle of the lines [deg], px that a pixel moves their crossing, and cond(A)."""
    one = state("limits/crossing-angle").with_eyes(baseline=baseline)
    moves = float(np.linalg.norm(oracles.crossing_moves(one, CROSSING_POINT)))
    return oracles.crossing_angle(one, CROSSING_POINT), moves, float(one.start.transfer.condition)


def wider_is_steeper() -> bool:
    angle, moves, condition = np.array([crossing(cm) for cm in np.arange(5, 61, 5)]).T
    return bool((np.diff(angle) > 0).all() and (np.diff(moves) < 0).all() and (np.diff(condition) < 0).all())


def crossing_slides_along_both() -> bool:
    """Its way makes a smaller angle with either line than 5°: many pixels along them for one across."""
    one = state("limits/crossing-angle").with_eyes(baseline=10)
    way = oracles.crossing_moves(one, CROSSING_POINT)
    lines = oracles.lines_in_L(one, CROSSING_POINT)
    across = np.abs(lines[:, :2] @ way) / np.linalg.norm(way)
    return bool(across.max() < np.sin(np.radians(5)) and np.linalg.norm(way) > 10)


def ellipse_holds_95_percent() -> bool:
    one = state("limits/crossing-angle").with_eyes(baseline=10)
    made, views = construct(one.start, CROSSING_POINT), one.start.views
    drawn = views.demo[CROSSING_POINT] + np.random.default_rng(1).normal(0, 1, (20_000, 4))
    off = one.start.transfer.recover(drawn[:, :2], drawn[:, 2:])[:, :2] - made.recovered[0]
    c, s = np.cos(made.direction[0]), np.sin(made.direction[0])
    inside = ((off @ np.array([[c, -s], [s, c]]) / made.half_axes[0]) ** 2).sum(1) <= 1
    return abs(inside.mean() - 0.95) < SIGMAS * np.sqrt(0.95 * 0.05 / len(drawn)) and CHI2_95 > 5


@cache
def few() -> oracles.Matches:
    return oracles.matches(state("limits/four-points"))


def largest(count: int) -> float:
    return float(np.nanmax(few().by_count[count].E))


def one_bottom_near(count: int) -> bool:
    found = few().by_count[count].local_minima()
    return len(found) == 1 and records.degrees_off(found[0], state("limits/four-points").start.theta_demo) < 5


def plane_breaks_up() -> bool:
    condition, all_of_them = few().plane.condition, few().by_count[10].condition
    return len(few().plane.local_minima()) > 5 and np.nanmedian(condition) > 3 * np.nanmedian(all_of_them)


def flat_steeper_or_rougher() -> int:
    return 1 if largest(4) < 1e-9 * largest(10) else 0 if largest(4) > largest(10) else 2


def rigid_joint() -> bool:
    """Turning the elbow alone moves all ten points by one rigid motion; turning the wrist does not."""
    one = state("limits/unobservable")

    def distances(theta_deg: tuple[float, float]) -> np.ndarray:
        points = one.world.points_world(np.radians(theta_deg), one.world.T_world_own)
        return np.linalg.norm(points[:, None] - points, axis=-1)

    elbow, wrist = (np.abs(distances((-115, 90)) - distances(other)).max() for other in ((-60, 90), (-115, 40)))
    return elbow < 1e-9 < 0.05 < wrist


def wrist_raises_E() -> bool:
    one = state("limits/unobservable")
    start, wrist = one.start, np.radians(np.linspace(95, 180, 10))
    theta = (np.full(10, start.theta_demo[0]), wrist)
    E = conflict_at(one.world, start.fit, start.views.demo, start.views.visible[:, :2], theta)[0]
    return bool((np.diff(E) > 0).all())


def unobservable_answer() -> int:
    return round(fact("limits/unobservable", "joint that can be anything")) - 1


def on_links(key: str) -> set[int]:
    return set(state(key).world.body.link.tolist())


def own_and_demo_noise() -> tuple[np.ndarray, np.ndarray]:
    """Degrees a pixel, by noise in the own images alone and by noise in the demonstrator's."""
    one, px = state("limits/noise"), 0.1
    both, own = (
        sample_estimates(
            one.world, one.start.fit, one.start.theta_demo, px, 1, 1_000, np.random.default_rng(1), noisy_demo=noisy
        ).var(0)
        for noisy in (True, False)
    )
    return np.degrees(np.sqrt(own)) / px, np.degrees(np.sqrt(both - own)) / px


def shows(joint: int) -> float:
    return records.shown_px(state("limits/noise"), joint, True)


def moves(joint: int) -> float:
    return records.shown_px(state("limits/noise"), joint, False)


def along_valley_arrows_hardly_grow() -> bool:
    """A degree along the valley of E adds less to the arrows than a fifth of the noise; across it, twice as much."""
    one = state("limits/noise")
    start = one.start
    demo, _ = one.world.demo_images(start.theta_demo)

    def at(postures: np.ndarray) -> np.ndarray:
        views = FourViews(demo, one.world.own_images(postures.T)[0], np.ones(1, bool))
        return start.fit(views).residual(views)

    J = np.radians(1) * residual_jacobian(at, start.theta_demo)
    along, across = np.sqrt(np.linalg.eigvalsh(J.T @ J) / (2 * len(demo)))
    return along < 0.2 * one.settings.noise_px and across > 1.9 * along


def cloud_is_along() -> int:
    return round(fact("limits/noise", "direction of the cloud")) - 1


def noise_cancels_by_the_root() -> bool:
    return abs(fact("limits/frames", "times the cloud shrinks") / 5 - 1) < SIGMAS / np.sqrt(records.RUNS)


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


def million_frames_fall_on_the_smallest_E() -> bool:
    """To a tenth of a degree, nearer than the cloud's middle is."""
    one = state("limits/bias-stays")
    noise_px = one.settings.noise_px / np.sqrt(1e6)
    quiet = sample_estimates(one.world, one.start.fit, one.start.theta_demo, noise_px, 1, 50, np.random.default_rng(1))
    lowest = records.minima(one.with_settings(noise_px=0.0)).theta[0]
    return records.degrees_off(quiet.mean(0), lowest) < 0.1


def bias_is_not_averaging() -> bool:
    """The middle is off by more than its standard error, and as far as without noise."""
    one = state("limits/bias-stays")
    averaged = records.clouds(one)[records.FRAMES[1]]
    off, error = averaged.mean(0) - one.start.theta_demo, averaged.std(0) / np.sqrt(records.RUNS)
    return bool((np.abs(off) > SIGMAS * error).any())


def swapped_answer() -> int:
    """E near 0, large at the right posture, large at a wrong one."""
    one = state("limits/swapped")
    if records.minima(one).E[0] < 1:
        return 0
    return 1 if records.bias_deg(one) < 5 else 2


def wrong_labels_lengthen_all_arrows() -> bool:
    """At the demonstrator's own posture, the eight right points have arrows too, and none without the swap."""
    one = state("limits/swapped").with_settings(start_deg=(45, -90))
    pairs = records.true_pairs(one)
    right = [k for k in range(10) if k not in pairs[0]]
    lengths = np.linalg.norm(oracles.arrows(one)[right], axis=-1)
    clean = np.linalg.norm(oracles.arrows(one.with_settings(swapped=0.0)), axis=-1)
    return bool(np.median(lengths) > 1 and clean.max() < 1e-3)


def swap_explains_everything() -> bool:
    session = records.run(state("limits/swapped"), "trust-region")
    last = session.snapshot
    return last.exchanged == records.true_pairs(state("limits/swapped")) and last.E < 1e-3


def toed_answer() -> int:
    return round(fact("limits/toed-in", "what puts it right")) - 1


def row_difference(rectified: bool) -> float:
    """px between the rows of a point in both pictures, the largest."""
    one = state("limits/toed-in")
    views, found = one.start.views, records.rectified(one)["rectified"].start.rectification
    images = [found.apply(image) if rectified else image for image in (views.demo, views.own)]
    return float(max(np.abs(image[:, 1] - image[:, 3]).max() for image in images))


def straight_eyes_see_equal_rows() -> bool:
    views = state("limits/minimum").start.views
    return max(np.abs(image[:, 1] - image[:, 3]).max() for image in (views.demo, views.own)) < 1e-9


def perspective_differs() -> bool:
    """Without depth, by affine cameras, these eyes would have no E."""
    alike = state("limits/toed-in").with_settings(start_deg=(45, -90))
    return oracles.without_depth(alike) < 1e-9 < alike.start.E


def toed_in_with_different_lenses() -> bool:
    head = state("limits/toed-in").scene.head
    left, right = head.lens(head.left), head.lens(head.right)
    return head.toe_in_deg > 0 and left.focal != right.focal and left.centre != right.centre


def early(key: str) -> Followed:
    return follow_circle(state(key)).early


def right(key: str) -> Followed:
    return follow_circle(state(key)).right


def early_draws() -> int:
    return DRAWS.index(early("motion/frozen").draws)


def near_where_it_was_frozen() -> bool:
    """The early loop's middle is nearer to the hand's place at the start than to the circle's middle."""
    one = early("motion/frozen")
    hand = one.side[:, -1].mean(0)
    world = state("motion/frozen").world
    frozen = world.link_frames(one.frozen.theta, np.eye(4))[-1, [0, 2], 3]
    return np.linalg.norm(hand - frozen) < np.linalg.norm(hand - one.demo_side[:, -1].mean(0))


def lines_fit_neither() -> bool:
    return state("motion/frozen").start.E > 5 * right("motion/frozen").frozen.E


def overlap_says_nothing() -> bool:
    """The overlap is as good with the wrong lines as with the right ones, and the hands are ten times as far apart."""
    wrong, good = early("motion/overlap"), right("motion/overlap")
    overlaps = [float(np.median(one.overlap_px)) for one in (wrong, good)]
    return overlaps[0] < 1.2 * overlaps[1] and wrong.hand_mm > 10 * good.hand_mm


def true_path_is_elsewhere() -> bool:
    one = early("motion/overlap")
    return np.median(one.truth_px) > 10 * np.median(one.overlap_px)


def learner_comes_near() -> bool:
    return fact("motion/alike", "off at rest") < 4


def learner_sees_images_only(key: str) -> bool:
    """What a servo is given has no posture: the learner's angles are displacements from its start."""
    session = situation_session(key)
    seen = session.observation(session.snapshot)
    moved = session.snapshot.commanded - session.settings.start_rad
    return np.array_equal(seen.displacement, moved) and seen.own.shape == (10, 4)


def situation_session(key: str):
    return records.run(state(key), "trust-region")


@cache
def rounds(key: str = "design/design") -> list[dict[str, list]]:
    return [records_of["runs"] for records_of in map(design.rounds_record, sampled(key))]


def median_off(name: str) -> np.ndarray:
    """Degrees off at the end, the median over starts, in each sampled scene."""
    return np.array([np.median([off for off, _ in runs[name]]) for runs in rounds()])


def best_known_choice() -> bool:
    """None ends nearer in the median, in any sampled scene."""
    page = "/".join(design.PAGE_CHOICE)
    return all((median_off(page) <= median_off(name) + 1e-9).all() for name in rounds()[0])


def exact_for_near_eyes(transfer: str) -> bool:
    """No bias in the lesson's scene, whose eyes are near."""
    return records.bias_deg(state("design/design").with_settings(noise_px=0.0), transfer) < 1e-3


def exact_for_far_eyes(transfer: str) -> bool:
    return records.bias_deg(state("design/design").with_settings(noise_px=0.0).with_eyes(distance=30), transfer) < 0.2


def projective_scatters_most() -> bool:
    """With noise and five points, its estimates scatter more than those of the linear transfer."""
    one = state("design/design").with_settings(points=5, start_deg=(25, -25))
    scatter = {
        name: sample_estimates(
            one.world, TRANSFERS[name], np.radians([45.0, -90]), 0.1, 1, 200, np.random.default_rng(1)
        ).std(0)
        for name in ("linear", "projective")
    }
    return bool((scatter["projective"] > scatter["linear"]).any())


def linear_is_a_weighted_sum() -> bool:
    """Transferred places are an affine function of the places in l and r: of any, not only of the fitted points."""
    transfer = TRANSFERS["linear"](state("tour/feel").start.views)
    l, r = np.random.default_rng(1).uniform(0, 200, (2, 50, 2))
    found, places = transfer.recover(l, r), np.column_stack([l, r, np.ones(50)])
    return np.abs(places @ np.linalg.lstsq(places, found, rcond=None)[0] - found).max() < 1e-6


def three_more_numbers() -> bool:
    """With its three numbers p at 0, the projective transfer is linear in the same coordinates."""
    return TRANSFERS["projective"](state("tour/feel").start.views).p.shape == (3,)


def steps_are_short_of_the_gradient_law() -> bool:
    """It makes all the steps it has, and is not there: the others rest before."""
    return all(
        np.median([motions for _, motions in runs["epipolar/gradient"]]) == design.ROUND_MOTIONS
        and np.median([motions for _, motions in runs["projective/trust-region"]]) < design.ROUND_MOTIONS
        for runs in rounds()
    )


def accuracy_comes_from_the_transfer() -> bool:
    """With the same servo, the projective transfer ends nearer than the others in each sampled scene."""
    others = [median_off(f"{name}/trust-region") for name in ("epipolar", "linear", "rank3")]
    return bool((median_off("projective/trust-region") < np.min(others, axis=0)).all())


def run_of(number: int) -> dict:
    return sign.runs_record()[number - 1]


def bet_of_half() -> float:
    return float(np.mean([oracles.brier([0.5], [outcome]) for outcome in (True, False)]))


def right_pose_by_other_poses(number: int) -> bool:
    """E below 0.01 px² at postures more than 10° off."""
    one = sign.signed_runs()[number - 1].situation
    return facts.widest_deg(one, 0.01) > 10


def E_of_run(number: int) -> float:
    return float(run_of(number)["E"][-1])


def off_of_run(number: int) -> float:
    return float(max(run_of(number)["offDeg"]))


def claims(number: int) -> bool:
    return run_of(number)["certificate"] is not None


def least_is_beside(number: int) -> bool:
    one: Situation = sign.signed_runs()[number - 1].situation
    return records.bias_deg(one) > 1 and E_of_run(number) < 1.05 * records.minima(one).E[0]


def verified(number: int) -> bool:
    return bool(sign.signed_runs()[number - 1].session.snapshot.certificate.verified)


def rises_all_around(number: int, away_deg: float = 2.0) -> bool:
    """Whether E is more than (0.1 px)² larger at 16 postures around the one where a run ended."""
    session = sign.signed_runs()[number - 1].session
    ways = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    around = session.snapshot.theta + np.radians(away_deg) * np.c_[np.cos(ways), np.sin(ways)]
    return all(session.observe(there, session.snapshot).E > session.snapshot.E + 0.1**2 for there in around)


STATEMENTS: Statements = {
    "limits": {"about": DEFINITION},
    "limits/minimum": {
        "title": {"The minimum is off": lambda: biases()[0] > 1},
        "text": {
            "The learner's pose is exactly right": lambda: np.array_equal(
                state("limits/minimum").start.theta, state("limits/minimum").start.theta_demo
            ),
            "still some arrows remain": lambda: state("limits/minimum").start.E > 1,
            "away from the truth": lambda: biases()[0] > 1,
            "In the paper it was": lambda: facts.PAPER_BIAS_DEG == 45 - 41 == 90 - 86,
            "both arms stay as large": both_arms_stay_as_large,
        },
        "after": {
            "Without it, E would be": lambda: oracles.without_depth(state("limits/minimum")) < 1e-9,
            "arrows and shift both shrink": lambda: fact("limits/minimum", "share of the arrows that is left") < 0.2,
            "the shift faster": lambda: (
                fact("limits/minimum", "share of the bias that is left")
                < 0.5 * fact("limits/minimum", "share of the arrows that is left")
            ),
        },
        "say": {
            "because the lines ignore **perspective**": lambda: oracles.without_depth(state("limits/minimum")) < 1e-9,
            "it is the same in every picture": bias_everywhere_the_same_without_noise,
            "Far cameras make it small": lambda: bool((np.diff(biases()) < 0).all()),
        },
        "note": REPORT,
        "question": DEFINITION,
        "close": {
            "nearly with the square of the distance": lambda: (
                1.5 < exponent(fact("limits/minimum", "share of the bias that is left")) < 2.2
            )
        },
        "far": {
            "The arrows shrink to": lambda: (
                0.8 < exponent(fact("limits/minimum", "share of the arrows that is left")) < 1.3
            ),
            "the shift falls nearly with the square of the distance": lambda: (
                1.5 < exponent(fact("limits/minimum", "share of the bias that is left")) < 2.2
            ),
        },
        "less": {"a little perspective remains": lambda: biases().min() > 0},
    },
    "limits/crossing-angle": {
        "title": {"Nearly parallel lines": lambda: crossing(10)[0] < 5},
        "text": {"the two lines of a point are nearly parallel": lambda: crossing(10)[0] < 5},
        "after": {
            "the crossing lies in the ellipse 95 % of the time": ellipse_holds_95_percent,
            "Small is good": wider_is_steeper,
        },
        "say": {
            "The smaller the angle between two lines, the farther a pixel moves their crossing": wider_is_steeper,
            "A wider **baseline** makes the lines cross more steeply": wider_is_steeper,
        },
        "note": REPORT,
        "question": {"How far does the crossing move then": lambda: 1 < crossing(10)[1] < 64},
        "close": {"the crossing slides along both lines": crossing_slides_along_both},
        "far": {"the lines would have to be flatter still": wider_is_steeper},
        "less": {"A pixel across the lines is many pixels along them": crossing_slides_along_both},
    },
    "limits/four-points": {
        "title": {"Four points fit anything": lambda: largest(4) < 1e-9},
        "text": {"It has one bottom, near the demonstrator": lambda: one_bottom_near(10)},
        "after": {"the map breaks up": plane_breaks_up},
        "say": {
            "Four points fit any pose": lambda: largest(4) < 1e-9,
            "It takes five or more": lambda: largest(5) > 1,
            "they must not lie in one plane": plane_breaks_up,
        },
        "note": REPORT,
        "question": DEFINITION,
        "answers": flat_steeper_or_rougher,
        "because 1": {"there are lines that fit exactly": lambda: largest(4) < 1e-9},
        "because 2": {"there are lines that fit exactly": lambda: largest(4) < 1e-9},
        "because 3": {
            "With six points, the bowl is still there, only shallower": lambda: (
                one_bottom_near(6) and largest(4) < largest(6) < 0.5 * largest(10)
            ),
            "there are lines that fit exactly": lambda: largest(4) < 1e-9,
        },
    },
    "limits/unobservable": {
        "title": DEFINITION,
        "text": {
            "all on the forearm and the hand": lambda: min(on_links("limits/unobservable")) >= 4,
        },
        "after": {
            "E stays below": lambda: (
                facts.valley_E(state("limits/unobservable"))
                <= fact("limits/unobservable", "largest E along the valley")
            )
        },
        "say": {"Otherwise it is **unobservable**": rigid_joint, "E is a valley": lambda: unobservable_answer() == 0},
        "question": DEFINITION,
        "answers": unobservable_answer,
        "because 1": {"the elbow swings all ten points together, as one rigid body": rigid_joint},
        "because 2": {"The shape changes, and E rises": wrist_raises_E},
        "because 3": {
            "both carry points": lambda: {4, 7} <= on_links("limits/unobservable"),
            "Only what moves all points together stays hidden: the elbow": lambda: unobservable_answer() == 0,
        },
        "because 4": {"the elbow moves all of them together": rigid_joint},
    },
    "limits/noise": {
        "title": {"A pixel costs degrees": lambda: np.degrees(records.costs(state("limits/noise"))).min() > 1},
        "text": {
            "each point is found about half a pixel off": lambda: state("limits/noise").settings.noise_px == 0.5,
            "near the right one": lambda: (
                records.degrees_off(records.clouds(state("limits/noise"))[1].mean(0), np.radians([45, -90])) < 2
            ),
        },
        "after": {
            "Noise in l and r shifts them more": lambda: bool(np.greater(*own_and_demo_noise()[::-1]).all()),
        },
        "say": {
            "most of them along the valley of E": lambda: cloud_is_along() == 0,
            "where arrows hardly grow": along_valley_arrows_hardly_grow,
        },
        "question": DEFINITION,
        "answers": cloud_is_along,
        "because 1": {
            "Along the valley, arrows hardly grow": along_valley_arrows_hardly_grow,
            "arrows show only": lambda: shows(0) < 0.3 * moves(0),
        },
        "because 2": {
            "Across them, E rises steeply": along_valley_arrows_hardly_grow,
            "adds only": lambda: shows(0) < shows(1),
        },
        "because 3": {"but the joints are not": lambda: shows(0) < 0.9 * shows(1)},
    },
    "limits/frames": {
        "title": DEFINITION,
        "text": {
            "averages **25** of them": lambda: records.FRAMES[1] == 25,
            "the noise in them partly cancels": noise_cancels_by_the_root,
        },
        "say": {
            "If you average 25 pictures, the **noise** becomes about five times smaller": noise_cancels_by_the_root,
            "the square root of their number": noise_cancels_by_the_root,
        },
        "note": REPORT,
        "question": DEFINITION,
        "close": {"Theory says five, the square root of 25": lambda: np.sqrt(25) == 5},
        "far": {"what is left shrinks with the square root of 25, and that is five": noise_cancels_by_the_root},
        "less": {"what is left shrinks with the square root of 25": noise_cancels_by_the_root},
    },
    "limits/bias-stays": {
        "title": DEFINITION,
        "text": {
            "The demonstrator is near again, as in the first step": lambda: (
                step_named("limits/bias-stays").scene == step_named("limits/minimum").scene
            ),
            "perspective is strong": lambda: fact("limits/bias-stays", "bias without noise") > 5,
            "runs with **25** pictures averaged": lambda: records.FRAMES[1] == 25,
        },
        "after": {
            "The middle of the cloud is": bias_is_not_averaging,
            "Without any noise, the lowest E is": lambda: (
                abs(
                    fact("limits/bias-stays", "middle of the cloud is off")
                    - fact("limits/bias-stays", "bias without noise")
                )
                < 0.2
            ),
        },
        "say": {"Averaging removes **noise**, not **bias**": lambda: million_frames_fall_on() == 1},
        "question": DEFINITION,
        "answers": million_frames_fall_on,
        "because 1": {"beside the diamond": lambda: fact("limits/bias-stays", "bias without noise") > 0.5},
        "because 2": {
            "on the cross, where E is smallest without noise": million_frames_fall_on_the_smallest_E,
            "Perspective is the same in all of them and stays": lambda: million_frames_fall_on() == 1,
        },
        "because 3": {"With enough pictures, the cloud shrinks to a spot": lambda: million_frames_fall_on() == 1},
    },
    "limits/swapped": {
        "title": DEFINITION,
        "text": {
            "mixed up two of the ten points": lambda: len(records.true_pairs(state("limits/swapped"))) == 1,
        },
        "after": {
            "On the whole map, E is never below": lambda: records.minima(state("limits/swapped")).E[0] > 10,
            "that pose is": lambda: records.bias_deg(state("limits/swapped")) > 10,
            "One swap explains everything": swap_explains_everything,
        },
        "say": {"If E stays large wherever you go, an assumption is wrong": lambda: swapped_answer() == 2},
        "question": DEFINITION,
        "answers": swapped_answer,
        "because 1": {
            "Two wrong labels lengthen the arrows of the other eight as well": wrong_labels_lengthen_all_arrows
        },
        "because 2": {"these lead to another pose": lambda: swapped_answer() == 2},
        "because 3": {"these lead to a wrong pose": lambda: swapped_answer() == 2},
    },
    "limits/toed-in": {
        "title": DEFINITION,
        "text": {
            "These eyes are turned inwards, have different lenses": toed_in_with_different_lenses,
            "perspective distorts their two pictures in different ways": perspective_differs,
            "the lowest **E** is far from the demonstrator": lambda: fact("limits/toed-in", "off as seen") > 10,
        },
        "after": {"is now": lambda: fact("limits/toed-in", "off rectified") < 1},
        "say": {"Matched points also reveal how the eyes are turned": lambda: row_difference(rectified=True) < 1e-3},
        "question": DEFINITION,
        "answers": toed_answer,
        "because 1": {
            "With twenty points instead of ten": lambda: records.MORE_POINTS == 20,
            "more points only repeat the same mistake": lambda: (
                abs(fact("limits/toed-in", "off with more points") / fact("limits/toed-in", "off as seen") - 1) < 0.1
            ),
        },
        "because 2": {
            "Eyes that look straight ahead see each point in equal rows": straight_eyes_see_equal_rows,
            "Bent so, these pictures are like those of such eyes": lambda: row_difference(rectified=True) < 1e-3,
        },
        "because 3": {
            "How far the matched points are from equal rows shows how the eyes are turned": lambda: (
                row_difference(rectified=False) > 1
            )
        },
    },
    "motion": {
        "about": {
            "carry a whole motion over, if that pose was the right one": lambda: (
                right("motion/frozen").draws == DRAWS[0]
            )
        }
    },
    "motion/alike": {
        "title": DEFINITION,
        "text": {"only if both arms are **in the same pose**": lambda: early_draws() != 0},
        "after": {
            "The learner was": learner_comes_near,
            "It never saw an angle or the room": lambda: learner_sees_images_only("motion/alike"),
        },
        "say": {"The learner finds that pose from points in four pictures": learner_comes_near},
        "note": REPORT,
        "question": DEFINITION,
        "close": DEFINITION,
        "far": DEFINITION,
    },
    "motion/frozen": {
        "title": DEFINITION,
        "text": {"once too early": lambda: early("motion/frozen").frozen.motion == 0},
        "after": {
            "if they were kept too early": lambda: early("motion/frozen").hand_mm > 10 * right("motion/frozen").hand_mm
        },
        "say": {"repeats that mistake all the way": lambda: early("motion/frozen").run.hand_m.min() > 0.1},
        "question": DEFINITION,
        "answers": early_draws,
        "because 1": {"Lines fitted to both fit neither": lines_fit_neither},
        "because 2": {"near the place where the hand was when the lines were kept": near_where_it_was_frozen},
        "because 3": {"comes over, in the wrong place": lambda: early_draws() == 1},
    },
    "motion/overlap": {
        "title": DEFINITION,
        "text": {
            "though **E** was only": lambda: early("motion/overlap").frozen.E < 5,
            "the hand follows the path that they give": lambda: np.median(early("motion/overlap").overlap_px) < 1,
        },
        "after": {"the overlap is no better": overlap_says_nothing},
        "say": {"It does not prove that the lines are right": overlap_says_nothing},
        "note": {"The learner cannot": lambda: learner_sees_images_only("motion/overlap")},
        "question": DEFINITION,
        "close": {"The true path is": true_path_is_elsewhere},
        "far": {"the true path is": true_path_is_elsewhere},
        "less": {"The true path is": true_path_is_elsewhere},
    },
    "design": {"about": {"the best known choice": best_known_choice}},
    "design/design": {
        "title": DEFINITION,
        "text": REPORT,
        "after": {
            "The other is projective with trust region": lambda: design.PAGE_CHOICE == ("projective", "trust-region")
        },
        "say": {"many of them": lambda: design.ROUNDS >= 10},
        "question": DEFINITION,
        "says epipolar": {
            "Assumes far cameras": lambda: exact_for_far_eyes("epipolar") and not exact_for_near_eyes("epipolar")
        },
        "says linear": {
            "a weighted sum of the places in l and r": linear_is_a_weighted_sum,
            "Assumes far cameras": lambda: exact_for_far_eyes("linear") and not exact_for_near_eyes("linear"),
        },
        "says rank3": {"Assumes far cameras": lambda: exact_for_far_eyes("rank3") and not exact_for_near_eyes("rank3")},
        "says projective": {
            "Adds three numbers to the linear one": three_more_numbers,
            "allow for the perspective of near cameras": lambda: exact_for_near_eyes("projective"),
        },
        "says gradient": DEFINITION,
        "says broyden": DEFINITION,
        "says trust-region": DEFINITION,
        "reason": DEFINITION,
        "reason 1": DEFINITION,
        "because 1": {
            "Only the projective transfer does": lambda: (
                [name for name in TRANSFERS if exact_for_near_eyes(name)] == ["projective"]
            ),
            "With noise and few points, its three further numbers cost accuracy": projective_scatters_most,
        },
        "reason 2": DEFINITION,
        "because 2": {
            "That is true of the transfers for far cameras": projective_scatters_most,
            "no average removes their bias": lambda: million_frames_fall_on() == 1,
        },
        "reason 3": DEFINITION,
        "because 3": {
            "That helps only while steps are short": steps_are_short_of_the_gradient_law,
            "The accuracy at the end comes from the transfer": accuracy_comes_from_the_transfer,
        },
        "reason 4": DEFINITION,
        "because 4": DEFINITION,
    },
    "sign": {"about": {"Ten finished runs": lambda: len(sign.signed_runs()) == 10}},
    "sign/sign": {
        "title": DEFINITION,
        "text": {
            "right or wrong": lambda: {one["holds"] for one in sign.runs_record()} == {True, False},
            "“Both joints are within 1°.”": lambda: records.CLAIM_DEG == 1,
        },
        "after": REPORT,
        "say": {
            "A small E is only as good as **the points behind it**": lambda: (
                E_of_run(8) < 1e-3 < 10 < off_of_run(8) and off_of_run(2) > 90 and off_of_run(9) < 0.01
            )
        },
        "note": {"50 %, costs 0.25 each time": lambda: bet_of_half() == 0.25},
        "question": DEFINITION,
    },
    "runs/1": {
        "name": {"ten points, half a pixel of noise": lambda: run_of(1)["noise"].startswith("0.5 px")},
        "because": {
            "the noise of 25 pictures averaged": lambda: sign.signed_runs()[0].settings.frames == 25,
            "that is enough for 1°": lambda: run_of(1)["holds"] and run_of(1)["certificate"] > 0.9,
        },
    },
    "runs/2": {
        "name": {"points on the hand only": lambda: "base" not in run_of(2)["points"]},
        "because": {"a small E says nothing about the arm": lambda: E_of_run(2) < 0.1 and off_of_run(2) > 90},
    },
    "runs/3": {
        "name": DEFINITION,
        "because": {
            "E is as small as it gets, but the lowest E lies beside the right pose": lambda: least_is_beside(3),
            "The learner makes no claim": lambda: not claims(3),
        },
    },
    "runs/4": {
        "name": {"five points": lambda: run_of(4)["points"].startswith("5")},
        "because": {
            "The pose is right": lambda: run_of(4)["holds"],
            "five points fit other poses as well": lambda: right_pose_by_other_poses(4),
            "The learner makes no claim": lambda: not claims(4),
        },
    },
    "runs/5": {
        "name": {"two pixels of noise": lambda: run_of(5)["noise"].startswith("2 px")},
        "because": {
            "The learner claims to have arrived": lambda: claims(5),
            "leave more than 1°": lambda: off_of_run(5) > 1,
            "Its certificate is not sure either": lambda: 0.4 < run_of(5)["certificate"] < 0.7,
        },
    },
    "runs/6": {
        "name": {"two points mixed up": lambda: sign.signed_runs()[5].settings.swapped > 0},
        "because": {
            "The learner found out which two points": lambda: (
                sign.signed_runs()[5].session.snapshot.exchanged == records.true_pairs(sign.signed_runs()[5].situation)
            ),
            "After that, E fell to 0": lambda: E_of_run(6) < 1e-3 < 10 < max(run_of(6)["E"]),
        },
    },
    "runs/7": {
        "name": DEFINITION,
        "because": {
            "E is larger than in run 3": lambda: E_of_run(7) > E_of_run(3),
            "this pose is right": lambda: run_of(7)["holds"] and not run_of(3)["holds"],
            "the lowest E happens to lie near it": lambda: records.bias_deg(sign.signed_runs()[6].situation) < 1,
        },
    },
    "runs/8": {
        "name": {"five points": lambda: run_of(8)["points"].startswith("5")},
        "because": {
            "E is 0": lambda: E_of_run(8) < 0.005,
            "the shoulder is far off": lambda: run_of(8)["offDeg"][0] > 10 > run_of(8)["offDeg"][1],
            "Five points fit many poses": lambda: right_pose_by_other_poses(8),
        },
    },
    "runs/9": {
        "name": {"no noise": lambda: run_of(9)["noise"] == "none"},
        "because": {
            "E is 0": lambda: E_of_run(9) < 0.005,
            "it rises in every direction": lambda: rises_all_around(9) and verified(9),
        },
    },
    "runs/10": {
        "name": DEFINITION,
        "because": {
            "E stays large": lambda: min(run_of(10)["E"]) > 10,
            "the demonstrator faces the learner": lambda: (
                sign.signed_runs()[9].situation.scene.demonstrator.yaw_deg == 180
            ),
        },
    },
}
