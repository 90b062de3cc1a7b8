"""The page's panels: functions that declare widgets and drawings. What a visitor did becomes commands.

`PANELS` is the page in the order in which it is built; a panel is one function, and one line here.
"""

from collections.abc import Callable

from ..model.page_model import PageModel
from .actions import actions
from .display import display, enlarge, points, views
from .duel import duel
from .experiments import experiments, motions
from .guide import glossary, keys, lessons
from .images import conflict, images
from .landscape import landscape, law
from .left import demonstrator, disturbances, history, learner, method, playback
from .panel import Layout
from .plots import curves, equations
from .share import save, share
from .status import status

PANELS: list[Callable[[Layout, PageModel], None]] = [
    playback,
    lessons,
    history,
    demonstrator,
    learner,
    method,
    disturbances,
    display,
    points,
    save,
    keys,
    glossary,
    status,
    share,
    views,
    images,
    conflict,
    landscape,
    law,
    curves,
    equations,
    duel,
    experiments,
    motions,
    actions,
    enlarge,  # in the tabs that those before it have made
]
