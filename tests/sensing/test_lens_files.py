"""Lenses of calibration files, as ROS, OpenCV, Kalibr and Anipose write them."""

import json

import numpy as np
import pytest

from viewimit.commands.cli import main
from viewimit.sensing.lens_files import CalibratedLens, lenses_of, read_lenses

K = [[500.25, 0.0, 322.5], [0.0, 501.5, 238.0], [0.0, 0.0, 1.0]]
D = [-0.301, 0.122, 1e-3, -2.5e-4, 0.0]
LENS = CalibratedLens((500.25, 501.5), (322.5, 238.0), tuple(D), (640, 480))
FLAT = sum(K, [])


def ros():
    matrix = lambda rows, cols, data: {"rows": rows, "cols": cols, "data": data}
    return {
        "image_width": 640, "image_height": 480, "camera_name": "narrow", "camera_matrix": matrix(3, 3, FLAT),
        "distortion_model": "plumb_bob", "distortion_coefficients": matrix(1, 5, D),
        "rectification_matrix": matrix(3, 3, np.eye(3).ravel().tolist()), "projection_matrix": matrix(3, 4, [1.0] * 12),
    }  # fmt: skip


def message():
    return {"header": {"stamp": {"sec": 1}}, "height": 480, "width": 640, "distortion_model": "plumb_bob", "d": D,
            "k": FLAT, "r": [1.0] * 9, "p": [1.0] * 12, "roi": {"x_offset": 0, "do_rectify": False}}  # fmt: skip


def kalibr():
    one = {"cam_overlaps": [1], "camera_model": "pinhole", "distortion_model": "radtan", "distortion_coeffs": D[:4],
           "intrinsics": [K[0][0], K[1][1], K[0][2], K[1][2]], "resolution": [640, 480], "rostopic": "/cam0/image_raw",
           "T_cn_cnm1": np.eye(4).tolist()}  # fmt: skip
    return {"cam0": one, "cam1": {**json.loads(json.dumps(one)), "intrinsics": [900.0, 900.0, 320.0, 240.0]}}


@pytest.mark.parametrize("flow", [None, True, False])
@pytest.mark.parametrize("kind", [ros, message, kalibr])
def test_yaml_of_ros_and_kalibr(tmp_path, kind, flow):
    yaml = pytest.importorskip("yaml")
    path = tmp_path / "calibration.yaml"
    path.write_text("# calibrated today\n---\n" + yaml.safe_dump(kind(), default_flow_style=flow))
    found = list(read_lenses(path).values())
    assert found[0].focal == LENS.focal and found[0].centre == LENS.centre and found[0].size == LENS.size
    assert found[0].coefficients[:4] == LENS.coefficients[:4]
    assert [lens.focal[0] for lens in found[1:]] == ([900.0] if kind is kalibr else [])


@pytest.mark.parametrize("ending", ["yml", "xml", "json"])
@pytest.mark.parametrize(
    "keys",
    [(("camera_matrix", "distortion_coefficients"),), (("M1", "D1"), ("M2", "D2")),
     (("K_left", "D_left"), ("K_right", "D_right"))],
)  # fmt: skip
def test_opencvs_file_storage(tmp_path, ending, keys):
    cv2 = pytest.importorskip("cv2")
    path = tmp_path / f"stereo.{ending}"
    file = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    file.write("calibration_time", "Sat 28 Nov: noon")
    file.write("image_width", 640)
    file.write("image_height", 480)
    for matrix, distortion in keys:
        file.write(matrix, np.array(K))
        file.write(distortion, np.array([D]))
    file.write("R", np.eye(3))
    file.release()
    assert list(read_lenses(path).values()) == [LENS] * len(keys)


def test_anipose(tmp_path):
    path = tmp_path / "calibration.toml"
    camera = f"size = [ 640, 480,]\nmatrix = {K}\ndistortions = {D}\nrotation = [0.1, 0.2, 0.3]\n"
    path.write_text(f'[cam_0]\nname = "A"\n{camera}[cam_1]\nname = "B"\n{camera}[metadata]\nadjusted = false\n')
    assert read_lenses(path) == {"A": LENS, "B": LENS}
    path.write_text(path.read_text().replace("name", "fisheye = true\nname"))
    with pytest.raises(ValueError, match="fisheye"):
        read_lenses(path)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"distortion_model": "equidistant"}, "equidistant"),
        ({"is_fisheye": 1}, "fisheye"),
        ({"lens_type": "Kannala-Brandt"}, "fisheye.undistortPoints"),
        ({"distortion_coefficients": {"data": D[:3]}}, "k1, k2, k3"),
        ({"distortion_coefficients": {"data": [*D, 0.1, 0.2, 0.3]}}, "8 coefficients"),
        ({"camera_matrix": {"data": np.transpose(K).ravel().tolist()}}, "transposed"),
        ({"camera_matrix": {"data": [1.0, 2.0]}}, "9 numbers"),
        ({"camera_matrix": {"data": np.diag([-1.0, 1, 1]).ravel().tolist()}}, "none of a lens"),
        ({"camera_matrix": None}, "no camera matrix"),
    ],
)
def test_what_is_not_understood_is_refused(tmp_path, change, message):
    path = tmp_path / "calibration.json"
    path.write_text(json.dumps({**ros(), **change}))
    with pytest.raises(ValueError, match=message):
        read_lenses(path)


@pytest.mark.parametrize(
    "name, text",
    [("a.yaml", "camera_matrix: [1, 2"), ("a.yaml", "a: 1\n  b"), ("a.yml", "- " * 9000), ("a.xml", "<a"),
     ("a.toml", "a ="), ("a.json", "{"), ("a.xml", "<!DOCTYPE a><a/>"), ("a.yaml", "a: [1] 2"), ("a.yaml", "a: [1}")],
)  # fmt: skip
def test_a_damaged_file_is_named(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(ValueError, match=name):
        read_lenses(tmp_path / name)


@pytest.mark.parametrize(
    "text",
    ["{t: 2020-01-01 12:30:00}", "{url: http://x, y:[1, {z:2},]}", "[C:/x, camera:0]", '["x, ]", {"a b": \'}, {\'}]'],
)
def test_whatever_stands_in_brackets_beside_the_matrix(tmp_path, text):
    (tmp_path / "a.yaml").write_text(f'cams: [{{"name": "x, ]", k: {K}, beside: {text}, D:{D}, size: [640, 480]}},]\n')
    assert read_lenses(tmp_path / "a.yaml") == {"x, ]": LENS}


def test_what_a_command_is_given_is_refused_with_the_remedy(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.json").write_text(json.dumps(ros()))
    refused = {"1,2,3": "may be left out", "0,1,2,3": "more than 0", "a,b": "or a file", "a.json#R": "no camera 'R'"}
    for text, message in refused.items():
        with pytest.raises(ValueError, match=message):
            lenses_of(text)


def test_points_that_its_pictures_do_not_have_speak_against_a_lens():
    far, near = np.array([[700.0, 100.0], [3.0, 5.0]]), np.array([[300.0, 400.0], [310.0, 470.0]])
    assert "pictures of 640 x 480 px" in next(LENS.doubts(far))
    assert "all points lie below" in next(LENS.doubts(near)) and not list(LENS.doubts(far * np.nan))


def table(path, by_camera):
    """Points of a cube that two lenses bend, as a table: each coordinate has its own camera's distortion."""
    cv2 = pytest.importorskip("cv2")
    corners = np.array([(x, y, z) for x in (-0.4, 0.1, 0.4) for y in (-0.3, 0.3) for z in (2.0, 2.5)], float)
    lines = ["frame,view,point,x,y"]
    for body, shift in (("demo", 0.0), ("own", 0.05)):
        for camera, side in (("left", 0.0), ("right", 0.2)):
            matrix, distortion = by_camera[camera]
            seen, _ = cv2.projectPoints(
                corners + [shift - side, 0, 0], np.zeros(3), np.zeros(3), np.array(matrix), np.array(distortion)
            )
            lines += [f"0,{body}_{camera},p{k},{x:.6f},{y:.6f}" for k, (x, y) in enumerate(seen[:, 0])]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_each_camera_has_its_own_lens(tmp_path, capsys):
    """Without the distortion E of two like bodies vanishes."""
    other = [[700.0, 0, 300.0], [0, 700.0, 250.0], [0, 0, 1]]
    points = table(tmp_path / "points.csv", {"left": (K, D), "right": (other, [0.1, -0.2, 0, 0.002, 0.05])})
    (tmp_path / "left.json").write_text(json.dumps({**ros(), "camera_name": "the left one"}))
    given = ["--lens-left", str(tmp_path / "left.json"), "--lens-right", "700,700,300,250,0.1,-0.2,0,0.002,0.05"]
    E = []
    for words in ([], given, [*given[:2], "--lens-right", given[1]]):
        assert main(["evaluate", str(points), *words, "--transfer", "projective", "--rectify", "off", "--json"]) == 0
        out = capsys.readouterr()
        E.append(json.loads(out.out)["frames"][0]["E"])
        assert "picture size" not in out.err
        assert ("--lens-right: the camera is named the left one" in out.err) == (words[-1:] == given[1:2])
    assert E[1] < 1e-6 < 1e-3 < min(E[0], E[2])
