"""The page's panels: functions that declare widgets and drawings. What a visitor did becomes commands.

`PANELS` is the page in the order in which it is built; a panel is one function, and one line here.
"""

from collections.abc import Callable

from ..model.page_model import PageModel
from .actions import actions
from .arms import demonstrator, learner
from .display import display, enlarge, views
from .duel import duel
from .experiments import experiments
from .guide import glossary, lessons
from .help import keys
from .images import conflict, images
from .landscape import landscape, law
from .method import disturbances, method
from .motions import motions
from .panel import Layout
from .playback import history, playback
from .plots import curves, equations
from .points import points
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
