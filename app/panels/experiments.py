"""The tab Experiments: run one, see its figure, and what it comes to beside what the paper says; take its files."""

from html import escape

from viser import Icon

from viewimit.drawing import svg
from viewimit.drawing.theme import rgb
from viewimit.estimation.equations import MISSING, with_minus
from viewimit.experiments import EXPERIMENTS
from viewimit.experiments.paper.common import Claim, verdict

from ..drawing.overlays import asks
from ..jobs.experiments import Run
from ..model.motions import NAMES
from ..model.page_model import PageModel
from .panel import Layout, put, put_html, put_max

SEE, STOP = ("See it", Icon.MOVIE), ("Stop", Icon.PLAYER_STOP)  # the imitated motion, in 3-D and in the images
RUN, CANCEL = ("Run", Icon.PLAYER_PLAY), ("Cancel", Icon.PLAYER_STOP)
POINTS_ONLY = '<div class="vi-points-only">Experiments look at projected points, not at camera pictures.</div>'
PASS = (
    '<svg class="vi-mark" viewBox="0 0 16 16"><circle cx="8" cy="8" r="7" class="vi-mark-pass"/>'
    '<path d="M4.6 8.3l2.4 2.4 4.4-5" class="vi-mark-line"/></svg>pass'
)
MISS = (
    '<svg class="vi-mark" viewBox="0 0 16 16"><rect x="1.5" y="1.5" width="13" height="13" rx="2"'
    ' class="vi-mark-miss"/><path d="M5 5l6 6m0-6l-6 6" class="vi-mark-line"/></svg><b>miss</b>'
)
MARKS = {True: PASS, False: MISS, None: MISSING}


def experiments(layout: Layout, model: PageModel) -> None:
    with layout.tab("Experiments"):
        with layout.row():
            chosen = lambda model: EXPERIMENTS[model.experiments.chosen]
            titles = [experiment.title for experiment in EXPERIMENTS.values()]
            layout.dropdown("Experiment", titles, lambda model: chosen(model).title, "experiment")
            takes_motion = lambda model: "motion" in chosen(model).options
            name = lambda model: NAMES[model.motions.name]
            layout.dropdown("Trajectory", list(NAMES.values()), name, "motion", visible=takes_motion)
            layout.button(lambda model: CANCEL if model.experiments.going_on else RUN, "run")
        with layout.row():
            progress = layout.gui.add_html(draw_progress(None, ""))
            look = lambda model: SEE if model.displayed.playback is None else STOP
            imitated = lambda model: model.experiments.shown is not None and bool(model.experiments.shown.imitation)
            archived = lambda model: model.experiments.shown is not None and bool(model.experiments.shown.archive)
            layout.button(look, "imitation", visible=imitated)
            layout.button(("Download figure and data", Icon.DOWNLOAD), "download", enabled=archived)
        layout.html(lambda model: POINTS_ONLY if model.settings.sensor == "rendered" else "")
        figure, claims = layout.gui.add_html(""), layout.gui.add_html("")
        layout.gui.add_html(asks(("Q", "bias", "basin")))

        def draw(model: PageModel) -> None:
            chosen, run, latest = model.experiments.chosen, model.experiments.shown, model.experiments.latest
            put_html(progress, draw_progress(latest if model.experiments.going_on else run, chosen))
            drawn = run.figure if run is not None else ""
            drawn = drawn or EXPERIMENTS[chosen].empty_figure(model.session.scene)
            put_html(figure, f'<div class="vi-panel">{drawn}</div>')
            put_html(claims, draw_verdict(run))

        def key(model: PageModel) -> tuple:
            return model.generation, model.experiments.chosen, model.experiments.latest, model.experiments.shown

        layout.drawing(key, draw)


def draw_progress(run: Run | None, chosen: str) -> str:
    """One line. run: None before any; it is named unless it is of the experiment that is chosen."""
    title, state, percent, words = "experiment", "idle", 0, "not run yet"
    if run is not None:
        title, state, percent = EXPERIMENTS[run.name].short_title, run.state, round(100 * run.share)
        words = ("" if run.name == chosen else f"{title}: ") + _words(run, percent)
    title, words = svg.escape(title), svg.escape(words)
    bar = f'role="progressbar" aria-label="{title}" aria-valuemin="0" aria-valuemax="100" aria-valuenow="{percent}"'
    return (
        f'<div class="vi-progress vi-progress-{state}"><div class="vi-progress-bar" {bar}>'
        f'<i style="width:{percent}%"></i></div><span title="{words}">{words}</span></div>'
    )


def _words(run: Run, percent: int) -> str:
    match run.state:
        case "waiting":
            return "waiting for its turn"
        case "running":
            return f"{percent} %"
        case "writing":
            return "writing the files …"
        case "done":
            return f"done: {verdict(run.claims)}" if verdict(run.claims) else f"done in {run.seconds:.0f} s"
        case "cancelled":
            return f"cancelled at {percent} %"
    return f"failed: {with_minus(run.problem)}"


def draw_verdict(run: Run | None) -> str:
    """The table of an experiment's claims, or why it has failed; nothing as long as there is neither."""
    if run is not None and run.problem:
        failed = f"{EXPERIMENTS[run.name].short_title} failed: {with_minus(run.problem)}"
        return f'<div class="vi-claims"><p>{svg.escape(failed)}</p></div>'
    if run is None or not run.claims:
        return ""
    head = "".join(f"<th>{words}</th>" for words in ("claim", "paper", "here", "tolerance", "holds"))
    rows = "".join(map(_row, run.claims))
    said = f"<p><b>{svg.escape(verdict(run.claims))}</b></p>"
    return f'<div class="vi-claims">{said}<table><tr>{head}</tr>{rows}</table></div>'


def _row(claim: Claim) -> str:
    name = claim.name.split(": ", 1)[-1] if claim.name.startswith("Fig.") else claim.name
    cells = "".join(f"<td>{svg.escape(words)}</td>" for words in (name, claim.paper, claim.here, claim.tolerance))
    return f"<tr>{cells}<td>{MARKS[claim.holds]}</td></tr>"


ABOUT = (
    "Here the demonstrator moves along a path: choose one, record your own while you move it, or load one from a file."
    " While the page plays, the learner follows it. Fig. 10 under Experiments imitates it."
)
RECORD, REPLAY = ("Record", Icon.PLAYER_RECORD), ("Move the demonstrator", Icon.PLAYER_PLAY)


def motions(layout: Layout, model: PageModel) -> None:
    with layout.tab("Follow"):
        layout.gui.add_html(f'<div class="vi-about">{ABOUT}</div>')
        with layout.row():
            layout.dropdown("Chosen motion", list(NAMES.values()), lambda model: NAMES[model.motions.name], "motion")
            layout.button(lambda model: STOP if model.motions.recorder else RECORD, "record", color=rgb("stopped"))
            layout.button(lambda model: STOP if model.motions.replaying else REPLAY, "replay")
        shown = lambda model: model.motions.moment[0]
        time = layout.slider("Time (s)", 0.0, 1.0, 0.05, shown, "motion_time", hint="of the chosen motion")
        with layout.row():
            layout.html(_said)
            layout.button(("Save", Icon.DOWNLOAD), "save_motion")
            load = layout.gui.add_upload_button("Load", icon=Icon.UPLOAD, mime_type="application/json")

        def show_length(model: PageModel) -> None:
            seconds, last = model.motions.moment
            if time.step != model.motions.step_s:
                time.step = model.motions.step_s
            put_max(time, last)
            put(time, seconds)

        layout.drawing(lambda model: (model.motions.moment, model.motions.step_s), show_length)

    @load.on_upload
    async def take(event) -> None:
        layout.queue.call("load_motion", event.target.value.content)


def _said(model: PageModel) -> str:
    kind, sentence = model.motions.describe()
    return f'<div class="vi-said">{escape(sentence) if kind == "ready" else ""}</div>'
