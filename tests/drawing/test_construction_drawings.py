"""The chosen point's construction, drawn stage by stage."""

import pytest
from drawn import CHOSEN_POINT, EPIPOLAR_LINE, FROM_LEFT, FROM_RIGHT, IMAGE_L, SPREAD, marked, parsed

from viewimit.analysis.construction import construct
from viewimit.drawing.images.panel import draw_images
from viewimit.drawing.images.planes import image_windows
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.appearance import Silhouettes, points_in_images

POINT = 3


def drawn(transfer, stage, whole=False):
    session = Session(Settings.paper(transfer=transfer))
    snapshot = session.snapshot
    bodies = Silhouettes({}, session.world).bodies(snapshot.theta_demo, snapshot.theta, snapshot.transfer)
    windows = image_windows(points_in_images(bodies), session.scene.head.image)
    found = construct(snapshot, POINT)
    html = draw_images(snapshot, bodies, windows, POINT, whole, construction=found, stage=stage)
    return {view: marked(parsed(html), "svg", IMAGE_L[:-1] + view)[0] for view in "lrLR"}


def count(boxes, views, tag, kind):
    return [len(marked(boxes[view], tag, kind)) for view in views]


@pytest.mark.parametrize(
    "stage, rings, lines, ellipses",
    [(0, "l", [], 0), (1, "l", [FROM_LEFT], 0), (2, "lr", [FROM_LEFT], 0), (3, "lr", [FROM_LEFT, FROM_RIGHT], 0),
     (4, "lr", [FROM_LEFT, FROM_RIGHT], 1), (5, "lrLR", [FROM_LEFT, FROM_RIGHT], 1)],
)  # fmt: skip
def test_each_stage_adds_to_the_one_before(stage, rings, lines, ellipses):
    boxes = drawn("epipolar", stage)
    assert [view for view in "lrLR" if marked(boxes[view], "circle", CHOSEN_POINT)] == list(rings)
    for view in "LR":
        assert [path.get("class") for path in marked(boxes[view], "path", EPIPOLAR_LINE)] == lines
    assert count(boxes, "lr", "path", EPIPOLAR_LINE) == [0, 0]
    assert count(boxes, "LR", "ellipse", SPREAD) == [ellipses] * 2
