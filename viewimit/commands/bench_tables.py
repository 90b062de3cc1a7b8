"""The tables that `viewimit bench` prints for people."""

import math
from collections.abc import Sequence

from ..experiments.bench import claims, compared, following, robots, robustness, scenes, speed, success, tracks
from ..experiments.bench.intervals import Interval
from ..experiments.executors.study import Study

MILLION, CORES = 1_000_000, 64


def speed_table(found: speed.Benchmark) -> str:
    """The figures for people, each block against its first row, and with cond(A) against ours with it."""
    timed = "all postures" if found.loop_postures == found.postures else f"{found.loop_postures} postures, scaled"
    return "\n".join(
        [
            f"E over {found.postures} postures of {found.scene}, {found.points} points",
            "with kinematics and projection (CPU time on one thread, medians)",
            *_landscape_rows(found, timed),
            "one posture: fit, recovery, residual and E of given images, without kinematics and projection",
            *_posture_rows(found),
            f"one motion: a whole step with kinematics and projection, median of {speed.MOTIONS} from the start",
            *(
                f"  {f'{name}, {servo}':<60} {seconds * 1e6:9.0f} µs"
                for name, times in found.motion_s.items()
                for servo, seconds in times.items()
            ),
            "largest relative difference",
            f"  {'E to the batch, all postures':<60} {found.batch_agreement:9.1e}",
            f"  {f'E to the loop, {found.loop_postures} postures':<60} {found.loop_agreement:9.1e}",
            f"  {'cond(A) to the batch, all postures':<60} {found.condition_agreement:9.1e}",
        ]
    )


def _landscape_rows(found: speed.Benchmark, timed: str) -> list[str]:
    def row(what: str, seconds: float, against: float = found.landscape_s["epipolar"]) -> str:
        return f"  {what:<60} {seconds * 1e3:9.1f} ms  {seconds / against:8.1f} x"

    cv, with_condition = found.opencv, found.condition_s
    return [
        *(row(name, seconds) for name, seconds in found.landscape_s.items()),
        row("numpy batch: eigh and solve", found.batch_s),
        row(f"numpy loop: eigh and lstsq ({timed})", found.loop_s),
        row(f"OpenCV loop: perspective, another E ({timed})", cv.loop_s) if cv else f"  {found.opencv_why_not}",
        row("epipolar with cond(A)", with_condition, with_condition),
        row("numpy batch, without cond(A)", found.batch_s, with_condition),
        row("numpy batch with cond(A), eigvalsh of its AᵀA", found.batch_condition_s, with_condition),
        "the same postures, points on the robot's surface, beside the same transfer above",
        *(row(f"{name}, {speed.MANY} points", s, found.landscape_s[name]) for name, s in found.many_s.items()),
    ]


def _posture_rows(found: speed.Benchmark) -> list[str]:
    def row(what: str, seconds: float, against: float = found.fit_s["epipolar"][1]) -> str:
        return f"  {what:<60} {seconds * 1e6:9.0f} µs  {seconds / against:8.1f} x"

    cv = found.opencv
    return [
        *(row(name, times[1]) for name, times in found.fit_s.items()),
        row("numpy batch of one: eigh and solve", found.batch_posture_s),
        row("numpy loop: eigh and lstsq", found.loop_posture_s),
        row("OpenCV: perspective, another E", cv.posture_s) if cv else f"  {found.opencv_why_not}",
        *(
            row(f"{name}, {count} postures together", seconds)
            for name, times in found.fit_s.items()
            for count, seconds in times.items()
            if count > 1
        ),
    ]


def success_table(results: list[success.Success], pairs: str) -> str:
    """For people: a block a target, then motions and claims."""
    named = {"own_minimum": "to the transfer's own minimum", "demonstrator": "to the demonstrator"}
    lines = [
        f"{pairs}, at most {results[0].max_motions} motions",
        "share of runs, largest joint error (in brackets the 95 % confidence interval)",
    ]
    most = success.WITHIN_DEG[-1]
    for target in success.TARGETS:
        heads = [*(f"ended ≤{near:g}°" for near in success.WITHIN_DEG), f"came ≤{most:g}°"]
        lines.append(_line(named[target], "", *heads))
        for r in results:
            shares = (*r.ended[target].values(), r.came[target][most])
            lines.append(_line(r.transfer, r.servo, *map(_share, shares)))
    lines.append(_line("motions and claims", "", "median", "95 %", "claimed", f"falsely, >{success.FALSE_DEG:g}°"))
    for r in results:
        motions = f"{r.motions_median:.0f}", f"{r.motions_95:.0f}"
        lines.append(_line(r.transfer, r.servo, *motions, _share(r.claimed), _share(r.claimed_falsely)))
    lines.append("from the transfer's own minimum to the demonstrator")
    for r in {r.transfer: r for r in results}.values():
        lines.append(f"  {r.transfer:<12}median {r.bias_deg_median:.2f}°, 95 % within {r.bias_deg_95:.2f}°")
    return "\n".join(lines)


def _line(first: str, second: str, *cells: str) -> str:
    """A heading, which has no second word, or a row below it."""
    name = f"  {first:<12}{second:<18}" if second else f"{first:<32}"
    return name + "".join(f"{cell:>17}" for cell in cells)


def _share(share: success.Share) -> str:
    """97 % (93–99), the interval rounded outwards. All and none are said of all and none only."""
    text = f"{share.share:.0%}"
    if text == "100%" and share.count < share.runs:
        text = ">99%"
    elif text == "0%" and share.count > 0:
        text = "<1%"
    return f"{text[:-1]} % ({math.floor(100 * share.low)}–{math.ceil(100 * share.high)})"


def robustness_table(outcomes: list[robustness.Outcome]) -> str:
    """For people: a row a case. Of claims: their rms; falsely: beyond 0.5° and three times the error that the servo
    expects."""
    heads = ("rms", "expected", "of claims", "ended ≤0.5°", "ended ≤1°", "motions", "95 %", "claimed", "falsely")
    widths = (9, 10, 11, 18, 18, 9, 7, 18, 16)
    lines = [" " * 46 + "".join(f"{head:>{width}}" for head, width in zip(heads, widths))]
    for o in outcomes:
        claims_rms = "–" if o.claimed_rms_deg is None else f"{o.claimed_rms_deg:.2f}°"
        errors = f"{o.rms_deg:.2f}°", f"{o.expected_deg:.2f}°", claims_rms, _share(o.ended[0.5]), _share(o.ended[1.0])
        motions = f"{o.motions_median:.0f}", f"{o.motions_95:.0f}"
        cells = (*errors, *motions, _share(o.claimed), _share(o.claimed_falsely))
        lines.append(f"  {o.case:<44}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths)))
    return "\n".join(lines)


def scenes_table(outcomes: Sequence[scenes.Outcome], heading: str) -> str:
    """For people: a row a kind of scenes. bound: of Cramér and Rao, with own images granted; as seen: with those that
    were seen."""
    heads = *(f"ended ≤{near:g}°" for near in success.WITHIN_DEG), "motions", "95 %", "most", "claimed"
    heads = *heads, f"off >{success.FALSE_DEG:g}°", f"and >{claims.TIMES:g} exp.", "rms"
    heads = *heads, *("bound", f"at best ≤{min(success.WITHIN_DEG):g}°", "as seen", "at best")
    widths = (18, 18, 18, 9, 7, 7, 18, 20, 20, 10, 10, 16, 10, 10)
    lines = [heading, " " * 46 + "".join(f"{head:>{width}}" for head, width in zip(heads, widths))]
    for o in outcomes:
        motions = f"{o.motions_median:.0f}", f"{o.motions_95:.0f}", f"{o.motions_most}"
        said = _share(o.claimed), _exact_share(o.beyond), _exact_share(o.falsely)
        cells = *map(_share, o.ended.values()), *motions, *said, f"{o.rms_deg:.3f}°"
        for bound_deg, at_most in ((o.bound_deg, o.at_most), (o.bound_as_seen_deg, o.at_most_as_seen)):
            cells = *cells, f"{bound_deg:.3f}°", f"{100 * min(at_most.items())[1]:.0f} %"
        lines.append(f"  {o.row:<44}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths)))
    return "\n".join(lines)


def claims_table(outcomes: Sequence[claims.Outcome]) -> str:
    """For people: a row a case. Shares of runs that end near, of those whose joints can be told, and of these that end
    near; of all again, and of those whose Cramér-Rao bound is within 1°, which claim; then of claims."""
    heads = (
        f"≤{claims.NEAR_DEG:g}°",
        "tellable",
        "of these",
        "claimed",
        f"if bound ≤{claims.FALSE_DEG:g}°",
        "not told",
        "stalled",
        "no end",
        "median",
        "95 %",
        "off >1°",
        "and >3 exp.",
        "within 2 exp.",
        "rms",
        "exp.",
    )
    widths = (17, 17, 17, 17, 17, 15, 15, 15, 8, 6, 20, 20, 20, 8, 8)
    names = max(36, *(len(o.case) for o in outcomes))
    lines = [" " * (names + 2) + "".join(f"{head:>{width}}" for head, width in zip(heads, widths))]
    for o in outcomes:
        of_runs = o.within, o.tellable, o.within_tellable, o.claimed, o.claimed_within_bound
        ends = o.unobservable, o.stalled, o.unended
        of_claims = o.beyond, o.falsely, o.covered
        cells = (
            *("–" if share is None else _share(share) for share in (*of_runs, *ends)),
            f"{o.motions_median:.0f}",
            f"{o.motions_95:.0f}",
            *("–" if share is None else _exact_share(share) for share in of_claims),
            *("–" if off is None else f"{off:.2f}°" for off in (o.rms_deg, o.expected_deg)),
        )
        lines.append(f"  {o.case:<{names}}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths)))
    return "\n".join(lines)


def compared_table(found: Sequence[compared.Compared]) -> str:
    """For people: a block a case, a row a law. In brackets 95 % confidence intervals."""
    near = compared.WITHIN_DEG[0]
    heads = (
        *(f"ended ≤{within:g}°" for within in compared.WITHIN_DEG),
        "motions",
        "95 %",
        "error",
        "95 %",
        "claimed",
        f"and >{success.FALSE_DEG:g}°",
        f"≤{near:g}°, more",
        "error less",
    )
    widths = (17, 17, 16, 16, 24, 24, 17, 13, 22, 22)
    lines = [
        "largest joint error at the end; more, less: than by the paper's law from the same draws, share and median of "
        "differences; in brackets 95 % confidence intervals"
    ]
    case = ""
    for o in found:
        if o.case != case:
            case = o.case
            lines.append(f"{case}, {o.runs} runs a law")
            lines.append(" " * 20 + "".join(f"{head:>{width}}" for head, width in zip(heads, widths)))
        cells = (
            *map(_share, o.within.values()),
            _interval(o.motions_median, 0),
            _interval(o.motions_95, 0),
            _interval(o.error_median, 2, "°"),
            _interval(o.error_95, 2, "°"),
            _share(o.claimed),
            _share(o.falsely),
            "–" if o.gained is None else _points(o.gained),
            "–" if o.error_less is None else _interval(o.error_less, 1, "°"),
        )
        lines.append(f"  {o.servo:<18}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths)))
    return "\n".join(lines)


def _interval(of: Interval, digits: int, unit: str = "") -> str:
    """0.02° (0.01–0.03), the interval rounded outwards."""
    scale = 10**digits
    low, high = math.floor(of.low * scale) / scale, math.ceil(of.high * scale) / scale
    between = "–" if low >= 0 else " to "
    return f"{of.value:.{digits}f}{unit} ({low:.{digits}f}{between}{high:.{digits}f})"


def _points(of: Interval) -> str:
    """A difference of shares in percentage points, the interval rounded outwards."""
    return f"{100 * of.value:+.0f} % ({math.floor(100 * of.low):+d} to {math.ceil(100 * of.high):+d})"


def cost_line(study: Study) -> str:
    """What the runs of a study took, and what a million of them would."""
    each = study.cpu_s / study.runs
    kept = f", {study.kept} of them kept before" if study.kept else ""
    hours = each * MILLION / 3600
    return (
        f"{study.runs} runs{kept}: {study.cpu_s:.1f} s of CPU on one core, {each * 1e3:.1f} ms a run; "
        f"{MILLION:,} such runs need {hours:.1f} h on one core, {hours / CORES:.2f} h on {CORES}"
    )


def _exact_share(share: success.Share) -> str:
    """0.5 % (0.2–1.2), the interval rounded outwards, as such shares are compared with small ones."""
    low, high = math.floor(1000 * share.low) / 10, math.ceil(1000 * share.high) / 10
    return f"{share.share:.1%} ({low:g}–{high:g})".replace("%", " %")


def following_table(outcomes: Sequence[following.Outcome]) -> str:
    """For people: a row a case."""
    rows = (f"  {o.case:<36}{o.rms_deg:8.2f}°{o.most_deg:8.2f}°" for o in outcomes)
    return "\n".join([f"{'demonstrator, learner':<38}{'rms':>9}{'most':>9}", *rows])


def tracks_table(outcomes: Sequence[tracks.Outcome]) -> str:
    """For people: a block a case, a row a transfer."""
    lines = ["median px rms of points held out: as `evaluate` leaves the images; as they are; rectified as matches ask"]
    for o in outcomes:
        lines.append(f"{o.case}: rectified {_share(o.rectified)}, matches alone would {_share(o.asked)}")
        rows = zip(o.error_px, o.error_px.values(), o.raw_px.values(), o.always_px.values())
        lines += [f"  {name:<11}" + "".join(f"{px:10.2f}" for px in each) for name, *each in rows]
    return "\n".join(lines)


def detection_table(found) -> str:
    """For people."""
    median, p95, p99, largest = found.error_px
    fewest, typical = found.usable
    return "\n".join(
        [
            f"{found.pictures} pictures of {found.scene}, {found.markers} markers an arm, random postures",
            f"  in sight                     {found.in_sight:8.1%}",
            f"  found, of all                {found.found:8.1%}",
            f"  found, of those in sight     {found.found_in_sight:8.1%}",
            f"  error of the middle          median {median:.3f} px, 95 % {p95:.3f}, 99 % {p99:.3f}, "
            f"most {largest:.2f}",
            f"  of a coordinate              rms {found.rms_px:.3f} px, mean {found.bias_px[0]:+.3f}, "
            f"{found.bias_px[1]:+.3f}",
            f"  false identities             {found.false} of {found.detections}",
            f"  in all four pictures         median {typical:.0f}, fewest {fewest}",
        ]
    )


def robot_line(found: robots.Found) -> str:
    """One URDF: its chain, what moves, and how its runs ended."""
    if found.refused is not None:
        return f"refused  {found.file}: {found.refused}"
    verdict = "arrived" if found.all_arrived else "MISSED"
    return (
        f"{verdict:<8} {found.file}: {found.chain[0]} to {found.chain[1]}, {', '.join(found.joints)} of {found.count}; "
        f"{found.arrived} of {found.runs} within {robots.ARRIVED_DEG:g}°, {found.claimed} claimed, "
        f"at most {found.error_deg:.3g}° off, median {found.motions:g} motions"
    )
