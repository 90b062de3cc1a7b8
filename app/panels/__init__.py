"""One file a panel: what it is built of, and what it shows of a page's state. What a visitor did becomes commands.

`PANELS` is the page in the order in which it is built; a panel is one class in one file, and one line here.
"""

from .actions import ActionsPanel
from .curves import CurvesPanel
from .demonstrator import DemonstratorPanel
from .display import DisplayPanel
from .disturbances import DisturbancesPanel
from .duel import DuelPanel
from .equations import ConflictPanel, EquationsPanel, LawPanel
from .experiments import ExperimentsPanel
from .guide.glossary import GlossaryPanel
from .guide.keys import KeysPanel
from .guide.lessons import LessonsPanel
from .guide.share import SharePanel
from .history import HistoryPanel
from .images import ImagesPanel
from .landscape import LandscapePanel
from .larger import LargerPanel
from .learner import LearnerPanel
from .method import MethodPanel
from .motions import MotionsPanel
from .panel import Panel
from .playback import PlaybackPanel
from .points.folder import PointsPanel
from .save import SavePanel
from .status import StatusPanel
from .views import ViewsPanel

PANELS: list[type[Panel]] = [
    PlaybackPanel,
    LessonsPanel,
    HistoryPanel,
    DemonstratorPanel,
    LearnerPanel,
    MethodPanel,
    DisturbancesPanel,
    DisplayPanel,
    PointsPanel,
    SavePanel,
    KeysPanel,
    GlossaryPanel,
    StatusPanel,
    SharePanel,
    ViewsPanel,
    ImagesPanel,
    ConflictPanel,
    LandscapePanel,
    LawPanel,
    CurvesPanel,
    EquationsPanel,
    DuelPanel,
    ExperimentsPanel,
    MotionsPanel,
    ActionsPanel,
    LargerPanel,  # in the tabs that those before it have made
]
