"""The page's panels: functions that declare widgets and drawings. What a visitor did becomes commands.

`PANELS` is the page in the order in which it is built; a panel is one function, and one line here.
"""

from collections.abc import Callable

from ..model.page_model import PageModel
from .actions import actions
from .arms import demonstrator, learner, start
from .display import display, enlarge, offer_of_the_lab, still, views
from .duel import duel
from .experiments import experiments
from .guide import glossary, lessons
from .help import keys
from .images import images
from .landscape import landscape
from .method import disturbances, method
from .motions import motions
from .panel import Layout
from .playback import copy, history, situation
from .plots import curves, equations
from .points import points
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
    offer_of_the_lab,
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
