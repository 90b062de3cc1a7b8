"""The tab Motions: record the demonstrator's motion, replay it, go through it, keep it in a file."""

from html import escape

from viser import Icon

from viewimit.drawing.theme import rgb

from ..model.motions import NAMES
from ..model.page_model import PageModel
from .panel import Layout, put, put_max

ABOUT = (
    '<div class="vi-about">Here the demonstrator moves along a path: choose one, record your own while you move it, or'
    " load one from a file. While the page plays, the learner follows it. Fig. 10 under Experiments imitates it.</div>"
)
RECORD, REPLAY = ("Record", Icon.PLAYER_RECORD), ("Move the demonstrator", Icon.PLAYER_PLAY)
STOP = "Stop", Icon.PLAYER_STOP


def motions(layout: Layout, model: PageModel) -> None:
    with layout.tab("Motions"):
        layout.gui.add_html(ABOUT)
        with layout.row():
            layout.dropdown("Chosen motion", list(NAMES.values()), lambda model: NAMES[model.motions.name], "motion")
            layout.button(lambda model: STOP if model.motions.recording else RECORD, "record", color=rgb("stopped"))
            layout.button(lambda model: STOP if model.motions.replaying else REPLAY, "replay")
        time = layout.slider(
            "Time s", 0.0, 1.0, 0.05, lambda model: model.motions.moment[0], "motion_time", hint="of the chosen motion"
        )
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
    async def _(event) -> None:
        layout.queue.call("load_motion", event.target.value.content)


def _said(model: PageModel) -> str:
    kind, sentence = model.motions.describe()
    return f'<div class="vi-said">{escape(sentence) if kind == "ready" else ""}</div>'
