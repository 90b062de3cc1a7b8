"""What is seen in the drawings, and how it is marked up: the only place where tests know a class's name, but for what
they point at in a browser.

What is seen is named by the classes that mark it, separated by spaces, as the attribute has them.
"""

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable

import numpy as np

# In an image
VIEW_NAME = "vi-name"
IMAGE_PLANE = "vi-plane"
CHOSEN_POINT = "vi-ring"
SPREAD = "vi-spread"  # ellipse, where it may be recovered
STEPS = "vi-steps"  # from the middle of all points to it
HOW = "vi-how"  # words
IMAGE_L = "vi-at-L"
EPIPOLAR_LINE = "vi-line"  # of any of the three other images
FROM_LEFT = "vi-line"
FROM_RIGHT = "vi-line vi-from-right"
FROM_PARTNER = "vi-line vi-partner"
OWN_POINTS = "vi-own"
DEMONSTRATORS_POINTS = "vi-seen"
RECOVERED_POINTS = "vi-found"
RESIDUALS = "vi-e"  # arrows
PHOTOGRAPH = "vi-photograph"
NOT_DETECTED = "vi-idle"

# In a landscape
LEVELS = "vi-contour"
LABELS = "vi-halo"  # that stand over the drawing
CENTRED = "vi-mid"
CELL_NUMBERS = "vi-mid"
SMALLEST_E = "vi-cross"
INSET = "vi-inset"  # frame, of what lies closest together
TO_THE_LEFT = "vi-end"  # of where it stands
START = "vi-basin-mark"
LEARNERS_PATH, OPPONENTS_PATH = "vi-line-own", "vi-line-opponent"

# In plots and figures
AXES = "vi-axis"
CURVE = "vi-x"
SOLID = "vi-x-solid"
E_CURVE = "vi-line-E"
TRUE = "vi-line-demo"  # the demonstrator's angles and its E, or the true path
OWN_TRACE = "vi-line-own"
BIASES_EPIPOLAR = "vi-x-fill-learner"  # dots
LED = "vi-lead"  # line to a label
CONFLICT = "vi-E"  # E, the largest figure below the images

# Marks and parts of the page
HIGH = "vi-amber"
BAR = "vi-bar"  # a joint of the learner with its angle
STATUS = "vi-status"
LESSON = "vi-lesson"  # what a preset shows
KEYS = "vi-keys"
ALL_TRANSFERS = "vi-transfers"
DUEL = "vi-duel"
HELP = "vi-help"
PANEL = "vi-panel"
CARD = "vi-card"
IMAGES, METRICS, LEGEND = "vi-images", "vi-metrics", "vi-legend"
VIEW_TABS = "vi-views"
EXPERIMENT = "vi-figure"
PROGRESS = "vi-progress"
VERDICT = "vi-claims"
MOTION = "vi-said"  # of the demonstrator, that is chosen
MOTIONS_MADE = "vi-count"
OFFER = "vi-offer"
DRAWING = "vi"  # any

JOINT_NAME = r"(?:Base|Shoulder|Upper arm|Elbow|Forearm|Wrist|Hand|Joint) (?=θ)"


def label(words: str | None) -> str:
    """A widget's label as tests write it: of a joint, the symbol; of a folder, not what it holds."""
    return re.sub(JOINT_NAME, "", words or "").split(": ")[0]


LAYOUT_ONLY = {EXPERIMENT, SOLID}  # classes of figures that need no style


def parsed(html: str) -> ElementTree.Element:
    return ElementTree.fromstring(f"<root>{html}</root>")


def classes(element: ElementTree.Element) -> set[str]:
    return set(element.get("class", "").split())


def only(root: ElementTree.Element, tag: str, seen: str) -> list[ElementTree.Element]:
    """The elements that are marked as this and as nothing else."""
    return [element for element in root.iter(tag) if classes(element) == set(seen.split())]


def marked(root: ElementTree.Element, tag: str, *seen: str) -> list[ElementTree.Element]:
    """The elements that are marked as all of this, whatever else they are."""
    wanted = set(" ".join(seen).split())
    return [element for element in root.iter(tag) if wanted <= classes(element)]


def path(root: ElementTree.Element, seen: str) -> str:
    """The first path that is marked as this and as nothing else, as it is written."""
    return only(root, "path", seen)[0].get("d", "")


def paths(html: str, *seen: str) -> list[str]:
    """All that are marked as all of this, as they are written, in order."""
    return [element.get("d", "") for element in marked(parsed(html), "path", *seen)]


def written_path(html: str, seen: str) -> str | None:
    """As `path`, in HTML that is no XML; None without one."""
    found = re.search(rf'class="{seen}" d="([^"]+)"', html)
    return found and found[1]


def view_name(plane: str) -> str:
    """Of one image's drawing."""
    found = re.search(rf'{VIEW_NAME}[^>]*">(\w)<', plane)
    assert found, "an image without a name"
    return found[1]


def learners_bars(contents: Iterable[str]) -> str:
    """Those among the page's parts, some of which are styles."""
    return next(html for html in contents if BAR in html and "<style" not in html)


def used(html: str) -> set[str]:
    """Every class in it."""
    return {name for group in re.findall(r'class="([^"]+)"', html) for name in group.split()}


def styled(css: str) -> set[str]:
    """Every class that a style sheet names."""
    return set(re.findall(r"\.(vi[\w-]*)", css))


def css(seen: str) -> str:
    """The selector."""
    return "".join(f".{name}" for name in seen.split())


def words(html: str) -> str:
    """All that is written in it."""
    return " ".join(parsed(html).itertext())


def numbers(text: str) -> np.ndarray:
    """All that are written in it, in order."""
    return np.array([float(word) for word in re.findall(r"-?\d+\.?\d*", text)])
