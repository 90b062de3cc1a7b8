"""Drawings of a state, with a link to the lab in it where the lab can show it."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.docutils import SphinxDirective

from viewimit import Session
from viewimit.analysis.construction import construct
from viewimit.analysis.landscape import Landscape, landscape
from viewimit.analysis.self_assessment import assess
from viewimit.drawing import curves, status
from viewimit.drawing import landscape as landscapes
from viewimit.drawing.export.panels import Appearance
from viewimit.drawing.images.panel import draw_images
from viewimit.drawing.images.rectified import draw_rectified
from viewimit.simulation.appearance import Bodies

from . import states

STEP_DEG, SLOW_STEP_DEG = 1.0, 3.0  # of landscapes; SLOW: of the transfer that takes ten times as long
SLOW = "projective"
ASK = re.compile(r'<button type="button" class="vi-ask"[^>]*></button>')


@dataclass(frozen=True)
class Drawing:
    """state: of `states.STATES`; draw: HTML of it."""

    state: str
    draw: Callable[[Session, int], str]


def _bodies(session: Session) -> Bodies:
    return _appearance(session).of(session.snapshot)[0]


@cache
def _appearance(session: Session) -> Appearance:
    return Appearance(session.world)


def _images(session: Session, chosen: int) -> str:
    now = session.snapshot
    bodies, windows = _appearance(session).of(now)
    return draw_images(now, bodies, windows, chosen, construction=construct(now, chosen), goal=True)


@cache
def _landscape(session: Session) -> Landscape:
    return landscape(session, SLOW_STEP_DEG if session.settings.transfer == SLOW else STEP_DEG)


def _bowl(session: Session, chosen: int) -> str:
    """The landscape with the path on it."""
    picture = landscapes.LandscapePicture(_landscape(session), session.scene, session.snapshot)
    return f'<div class="over">{picture.html}{picture.draw_path(session.history, session.cursor)}</div>'


def _curves(session: Session, chosen: int) -> str:
    now = session.snapshot
    E_true = session.observe(now.theta_demo, now).E
    errors = [float(np.degrees(np.abs(past.theta - past.theta_demo).max())) for past in session.history]
    return curves.draw_curves(session.history, session.cursor, E_true, session.scene.moving_joints, errors_deg=errors)


def _claim(session: Session, chosen: int) -> str:
    """What the learner says, what only the viewer knows, and what a pixel of noise costs at each joint."""
    now, joints = session.snapshot, session.scene.moving_joints
    said = status.describe(now, list(session.history)[:-1], False, assess(session), joints)
    strip = status.draw_status(said, status.describe_truth(joints, now.theta, now.theta_demo))
    return f'<div class="strip">{strip}</div>{_bowl(session, chosen)}'


DRAWINGS = {
    "overview": Drawing("begin", _images),
    "servo": Drawing("best", _curves),
    "arrived": Drawing("best", _claim),
    "unobservable": Drawing("unobservable", _claim),
    "rectification": Drawing("toed-in", lambda session, chosen: draw_rectified(session.snapshot, _bodies(session))),
}


class DrawingDirective(SphinxDirective):
    """A drawing by its name; the words below it are its caption."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        name = self.arguments[0]
        if name not in DRAWINGS:
            raise ExtensionError(f"{self.env.docname}, line {self.lineno}: no drawing {name!r}")
        drawing = DRAWINGS[name]
        inside = drawing.draw(states.session(drawing.state), states.chosen(drawing.state))
        inside = ASK.sub("", inside)
        figure = nodes.container("", classes=["figure", f"figure-{name}"])
        figure += nodes.raw("", f'<div class="drawn">{inside}</div>', format="html")
        words = nodes.container("", classes=["words"])
        self.state.nested_parse(self.content, self.content_offset, words)
        if lab := states.STATES[drawing.state].lab:
            link = f'<p><a class="open" href="../index.html#{lab}">Open the lab in this state</a></p>'
            words += nodes.raw("", link, format="html")
        figure += words
        return [figure]


def add_to(app: Sphinx) -> None:
    app.add_directive("drawing", DrawingDirective)
