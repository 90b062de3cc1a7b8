"""The page's panels: functions that declare widgets and drawings. What a visitor did becomes commands. `PANELS` is the
page in the order in which it is built; a panel is one function, and one line here."""

from collections.abc import Callable

from ..model.page_model import PageModel
from .actions import actions
from .display import display, enlarge, points, still, views
from .experiments import experiments, motions
from .guide import glossary, keys, lessons
from .left import copy, demonstrator, disturbances, history, learner, method, situation, start
from .panel import Layout
from .plots import curves, duel, equations, images, landscape
from .share import save, share
from .status import status

PANELS: list[Callable[[Layout, PageModel], None]] = [
    lessons,
    situation,
    demonstrator,
    copy,
    history,
    learner,
    start,
    method,
    disturbances,
    points,
    display,
    save,
    keys,
    glossary,
    status,
    share,
    still,
    views,
    images,
    landscape,
    curves,
    equations,
    duel,
    experiments,
    motions,
    actions,
    enlarge,  # in the tabs that those before it have made
]
