"""Points that tell nothing are refused in one line, not evaluated to an E of nearly 0."""

import numpy as np
import pytest

from viewimit.estimation.views import VIEWS, FourViews, why_degenerate

RNG = np.random.default_rng(0)
SHAPE, SOLID = RNG.normal(0, 50, (10, 3)), RNG.normal(0, 1, (3, 8))


def frame(shape):
    """Affine views of ten points, (1, 10, …)"""
    images = shape @ SOLID + 200
    return FourViews(images[None, :, :4], images[None, :, 4:], np.ones((1, 10, 4), bool))


FLATTENED = {
    "": SHAPE,
    "one plane": SHAPE * (1, 1, 0),
    "one line": SHAPE * (1, 0, 0),
    "one place": SHAPE * 0,
    "only 4 points differ": SHAPE[[0, 1, 2, 3] + [3] * 6],
}


@pytest.mark.parametrize("reason, shape", FLATTENED.items(), ids=FLATTENED)
def test_degenerate_points_are_explained(reason, shape):
    (why,) = why_degenerate(frame(shape))
    assert reason in why and bool(why) == bool(reason)


def test_each_frame_and_each_body_is_checked():
    good, flat = frame(SHAPE), frame(FLATTENED["one plane"])
    demo, own = np.concatenate([good.demo, flat.demo, good.demo]), np.concatenate([good.own, good.own, flat.own])
    why = why_degenerate(FourViews(demo, own, np.ones((3, 10, 4), bool)))
    assert why == ["", "all points are in one plane in [l, r]", "all points are in one plane in [L, R]"]


@pytest.mark.parametrize("reason", [reason for reason in FLATTENED if reason])
@pytest.mark.parametrize("transfer", ["epipolar", "projective"])
def test_evaluate_refuses_degenerate_points(ask, ask_json, tmp_path, reason, transfer):
    path = tmp_path / "points.csv"
    with path.open("w") as file:
        file.write("frame,view,point,x,y\n")
        for number, shape in enumerate((FLATTENED[reason], SHAPE)):
            views = frame(shape)
            for view, image in zip(VIEWS, (*np.split(views.demo[0], 2, 1), *np.split(views.own[0], 2, 1))):
                file.writelines(f"{number},{view},{k},{x:.4f},{y:.4f}\n" for k, (x, y) in enumerate(image))
    status, out, err = ask("evaluate", path, "--transfer", transfer)
    assert status == 0 and "1 of 2 frames refused: frame 0: " in err and reason in err and err.count("\n") <= 3
    _, output = ask_json("evaluate", path, "--transfer", transfer)
    assert output["frames"][0]["E"] is None and reason in output["frames"][0]["refused"]
    assert output["frames"][1]["E"] < 0.01 and output["frames"][1]["refused"] is None
    rows = path.read_text().splitlines()
    path.write_text("\n".join([rows[0], *(row for row in rows if row.startswith("0,"))]) + "\n")
    status, out, err = ask("evaluate", path, "--transfer", transfer)
    assert status == 1 and reason in err
