"""The tab Experiments: run one, see its figure and what it comes to, take its files."""

from viser import Icon

from viewimit.experiments import EXPERIMENTS

from ..commands.tools import ChooseExperiment, ChooseMotion, Download, RunOrCancel, ShowImitation
from ..drawing.glossary import asks
from ..model.experiments import titles
from ..model.motions import NAMES
from ..model.state import PageState
from .panel import Layout, Panel
from .verdict import draw_progress, draw_verdict
from .widgets import put, put_html, put_label, put_visible

SEE, STOP = ("See it", Icon.MOVIE), ("Stop", Icon.PLAYER_STOP)  # what is imitated, in 3-D and in the images
POINTS_ONLY = '<div class="vi-points-only">Experiments look at projected points, not at camera images.</div>'


class ExperimentsPanel(Panel):
    inside = "Experiments"

    def build(self, layout: Layout, state: PageState) -> None:
        gui, queue, offered = layout.gui, layout.queue, list(titles().values())
        with layout.tab(self.inside):
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row"></span>')
                self._experiment = gui.add_dropdown("Experiment", offered, initial_value=offered[0])
                self._trajectory = gui.add_dropdown("Trajectory", list(NAMES.values()), visible=False)
                self._run = gui.add_button("Run", icon=Icon.PLAYER_PLAY)
            with gui.add_folder(None):
                gui.add_html('<span class="vi-row"></span>')
                self._progress = gui.add_html(draw_progress(None, ""))
                self._see = gui.add_button(SEE[0], icon=SEE[1], visible=False)
                self._download = gui.add_button("Download figure and data", icon=Icon.DOWNLOAD, disabled=True)
            self._note = gui.add_html("")
            self._figure = gui.add_html("")
            self._verdict = gui.add_html("")
            gui.add_html(asks(("Q", "bias", "basin")))
        queue.on_value(self._experiment, ChooseExperiment.parse)
        queue.on_value(self._trajectory, ChooseMotion.parse)
        queue.on_click(self._run, RunOrCancel())
        queue.on_click(self._see, ShowImitation())
        queue.on_click(self._download, Download())

    def depends_on(self, state: PageState) -> tuple:
        experiments, motion = state.experiments, state.motions.name
        runs = experiments.latest, experiments.shown
        seen = state.imitated is not None, experiments.sets_pictures_aside
        return state.generation, experiments.chosen, *runs, *seen, motion, state.refusals

    def show(self, state: PageState) -> None:
        experiments, scene = state.experiments, state.session.scene
        run, going_on = experiments.shown, experiments.going_on
        chosen = EXPERIMENTS[experiments.chosen]
        put(self._experiment, chosen.title)
        put(self._trajectory, NAMES[state.motions.name])
        put_visible(self._trajectory, "motion" in chosen.options)
        put_label(self._run, *(("Cancel", Icon.PLAYER_STOP) if going_on else ("Run", Icon.PLAYER_PLAY)))
        put_html(self._progress, draw_progress(experiments.latest if going_on else run, experiments.chosen))
        figure = run.figure if run is not None and run.figure else chosen.empty_figure(scene)
        put_html(self._note, POINTS_ONLY if experiments.sets_pictures_aside else "")
        put_html(self._figure, f'<div class="vi-panel">{figure}</div>')
        put_html(self._verdict, draw_verdict(run))
        put_visible(self._see, run is not None and run.imitation is not None)
        put_label(self._see, *(SEE if state.imitated is None else STOP))
        if self._download.disabled != (run is None or not run.archive):
            self._download.disabled = not self._download.disabled
