"""The tab Experiments: run one, see its figure, take its files; record and replay the demonstrator's motion."""

from html import escape

from viser import Icon

from viewimit.drawing.glossary import asks
from viewimit.experiments import EXPERIMENTS

from ..control.commands.experiments import (
    ChooseExperiment,
    ChooseMotion,
    Download,
    LoadMotion,
    Record,
    Replay,
    RunOrCancel,
    SaveMotion,
    ShowFrame,
)
from ..control.experiments import titles
from ..control.motions import NAMES
from ..control.state import PageState
from .panel import Layout, Panel
from .verdict import draw_progress, draw_verdict
from .widgets import put, put_html, put_label, put_visible

POINTS_ONLY = '<div class="vi-points-only">Experiments look at projected points, not at camera images.</div>'


class ExperimentsPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        gui, queue, offered = layout.gui, layout.queue, list(titles().values())
        with layout.tab("Experiments"):
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row"></span>')
                self._experiment = gui.add_dropdown("Experiment", offered, initial_value=offered[0])
                self._trajectory = gui.add_dropdown("Trajectory", list(NAMES.values()), visible=False)
                self._run = gui.add_button("Run", icon=Icon.PLAYER_PLAY)
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row"></span>')
                self._progress = gui.add_html(draw_progress(None, ""))
                self._download = gui.add_button("Download figure and data", icon=Icon.DOWNLOAD, disabled=True)
            self._note = gui.add_html("")
            self._figure = gui.add_html("")
            with gui.add_folder("Demonstrator's motion", expand_by_default=False):
                self._build_motion(layout)
            self._verdict = gui.add_html("")
            gui.add_html(asks(("Q", "bias", "basin")))
        queue.on_value(self._experiment, ChooseExperiment.parse)
        queue.on_value(self._trajectory, ChooseMotion.parse)
        queue.on_click(self._run, RunOrCancel())
        queue.on_click(self._download, Download())

    def depends_on(self, state: PageState) -> tuple:
        experiments, motions = state.experiments, state.motions
        said = motions.name, motions.moment, motions.recording, motions.replaying, motions.describe()
        runs = experiments.latest, experiments.shown
        return state.generation, experiments.chosen, *runs, experiments.sets_pictures_aside, *said, state.refusals

    def show(self, state: PageState) -> None:
        self._show_run(state)
        self._show_motion(state)

    def _show_run(self, state: PageState) -> None:
        experiments, scene = state.experiments, state.session.scene
        run, going_on = experiments.shown, experiments.going_on
        chosen = EXPERIMENTS[experiments.chosen]
        put(self._experiment, chosen.title)
        put_visible(self._trajectory, "motion" in chosen.options)
        put_label(self._run, *(("Cancel", Icon.PLAYER_STOP) if going_on else ("Run", Icon.PLAYER_PLAY)))
        put_html(self._progress, draw_progress(experiments.latest if going_on else run, experiments.chosen))
        figure = run.figure if run is not None and run.figure else chosen.empty_figure(scene)
        put_html(self._note, POINTS_ONLY if experiments.sets_pictures_aside else "")
        put_html(self._figure, f'<div class="vi-panel">{figure}</div>')
        put_html(self._verdict, draw_verdict(run))
        if self._download.disabled != (run is None or not run.archive):
            self._download.disabled = not self._download.disabled

    def _show_motion(self, state: PageState) -> None:
        motions = state.motions
        for dropdown in (self._trajectory, self._motion):
            put(dropdown, NAMES[motions.name])
        put_label(self._record, *(("Stop", Icon.PLAYER_STOP) if motions.recording else ("Record", Icon.PLAYER_RECORD)))
        put_label(self._replay, *(("Stop", Icon.PLAYER_STOP) if motions.replaying else ("Replay", Icon.PLAYER_PLAY)))
        frame, last = motions.moment
        if self._moment.max != last:
            self._moment.max = last
        put(self._moment, frame)
        kind, sentence = motions.describe()
        put_html(self._said, f'<div class="vi-said">{escape(sentence) if kind == "ready" else ""}</div>')

    def _build_motion(self, layout: Layout) -> None:
        gui, queue = layout.gui, layout.queue
        with gui.add_folder(None):
            gui.add_html('<span class="vi-row"></span>')
            self._motion = gui.add_dropdown("Chosen motion", list(NAMES.values()))
            self._record = gui.add_button("Record", icon=Icon.PLAYER_RECORD, color="red")
            self._replay = gui.add_button("Replay", icon=Icon.PLAYER_PLAY)
        self._moment = gui.add_slider("Moment", 0, 1, 1, 0, hint="frame of the chosen motion")
        with gui.add_folder(None):
            gui.add_html('<span class="vi-row"></span>')
            self._said = gui.add_html("")
            save = gui.add_button("Save", icon=Icon.DOWNLOAD)
            load = gui.add_upload_button("Load", icon=Icon.UPLOAD, mime_type="application/json")
        queue.on_value(self._motion, ChooseMotion.parse)
        queue.on_value(self._moment, ShowFrame.parse)
        queue.on_click(self._record, Record())
        queue.on_click(self._replay, Replay())
        queue.on_click(save, SaveMotion())

        @load.on_upload
        async def _(event) -> None:
            queue.put(LoadMotion.parse(event.target.value.content))
