"""The tab Experiments: run one, see its figure, take its files; record and replay the demonstrator's motion."""

from html import escape

from viser import ClientHandle

from viewimit.experiments import EXPERIMENTS
from viewimit.simulation.scene import Scene

from ..control.experiments import Experiments
from ..control.inbox import Inbox, on_click, on_value, put, put_html, put_label
from ..control.motions import MOST_BYTES, NAMES, Motions
from .verdict import draw_progress, draw_verdict

POINTS_ONLY = '<div class="vi-points-only">Experiments look at projected points, not at camera images.</div>'


class ExperimentsTab:
    """Builds the tab in __init__, inside the container that is open; `show` writes what differs."""

    def __init__(self, client: ClientHandle, inbox: Inbox):
        self._gui, self._inbox = client.gui, inbox
        gui, titles = client.gui, [experiment.title for experiment in EXPERIMENTS.values()]
        with gui.add_folder(None):
            gui.add_html('<span class="vi-row"></span>')
            self._experiment = gui.add_dropdown("Experiment", titles, initial_value=titles[0])
            self._trajectory = gui.add_dropdown("Trajectory", list(NAMES.values()), visible=False)
            self._run = gui.add_button("Run", icon="player-play")
        with gui.add_folder(None):
            gui.add_html('<span class="vi-row"></span>')
            self._progress = gui.add_html(draw_progress(None, ""))
            self._download = gui.add_button("Download figure and data", icon="download", disabled=True)
        self._note = gui.add_html("")
        self._figure = gui.add_html("")
        with gui.add_folder("Demonstrator's motion", expand_by_default=False):
            self._build_motion()
        self._verdict = gui.add_html("")
        on_value(self._experiment, inbox, "experiment")
        on_value(self._trajectory, inbox, "motion")
        on_click(self._run, inbox, "run")
        on_click(self._download, inbox, "download")

    def show(self, experiments: Experiments, motions: Motions, scene: Scene) -> None:
        self._show_run(experiments, scene)
        self._show_motion(motions)

    def _show_run(self, experiments: Experiments, scene: Scene) -> None:
        run, going_on = experiments.shown, experiments.going_on
        chosen = EXPERIMENTS[experiments.chosen]
        put(self._experiment, chosen.title)
        if self._trajectory.visible != ("motion" in chosen.options):
            self._trajectory.visible = not self._trajectory.visible
        put_label(self._run, *(("Cancel", "player-stop") if going_on else ("Run", "player-play")))
        put_html(self._progress, draw_progress(experiments.latest if going_on else run, experiments.chosen))
        figure = run.figure if run is not None and run.figure else chosen.empty_figure(scene)
        put_html(self._note, POINTS_ONLY if experiments.sets_pictures_aside else "")
        put_html(self._figure, f'<div class="vi-panel">{figure}</div>')
        put_html(self._verdict, draw_verdict(run))
        if self._download.disabled != (run is None or not run.archive):
            self._download.disabled = not self._download.disabled

    def _show_motion(self, motions: Motions) -> None:
        for dropdown in (self._trajectory, self._motion):
            put(dropdown, NAMES[motions.name])
        put_label(self._record, *(("Stop", "player-stop") if motions.recording else ("Record", "player-record")))
        put_label(self._replay, *(("Stop", "player-stop") if motions.replaying else ("Replay", "player-play")))
        frame, last = motions.moment
        if self._moment.max != last:
            self._moment.max = last
        put(self._moment, frame)
        state, sentence = motions.describe()
        put_html(self._said, f'<div class="vi-said">{escape(sentence) if state == "ready" else ""}</div>')

    def _build_motion(self) -> None:
        gui, inbox = self._gui, self._inbox
        with gui.add_folder(None):
            gui.add_html('<span class="vi-row"></span>')
            self._motion = gui.add_dropdown("Chosen motion", list(NAMES.values()))
            self._record = gui.add_button("Record", icon="player-record", color="red")
            self._replay = gui.add_button("Replay", icon="player-play")
        self._moment = gui.add_slider("Moment", 0, 1, 1, 0, hint="frame of the chosen motion")
        with gui.add_folder(None):
            gui.add_html('<span class="vi-row"></span>')
            self._said = gui.add_html("")
            save = gui.add_button("Save", icon="download")
            load = gui.add_upload_button("Load", icon="upload", mime_type="application/json")
        on_value(self._motion, inbox, "motion")
        on_value(self._moment, inbox, "moment")
        on_click(self._record, inbox, "record")
        on_click(self._replay, inbox, "replay")
        on_click(save, inbox, "save motion")

        @load.on_upload
        async def _(event) -> None:
            data = event.target.value.content
            inbox.put("motion file", data if len(data) <= MOST_BYTES else len(data))
