"""Whatever stands in a file that the command line reads: a line or two, exit status 2, soon and in little memory."""

import json
import os
import signal
import struct
import subprocess
import sys
import threading
import time
import zipfile
import zlib

import pytest
from viewimit.assets import ROOT

from viewimit.estimation.views import VIEW_NAMES
from viewimit.options import option
from viewimit.sensing.files import MAX_ARRAY_BYTES

WITHIN_S, MOST_KB = 5.0, 500_000
PANDA = (ROOT / "robots/panda/panda.urdf").read_text()
SCENE = (ROOT / "scenes/panda.toml").read_text()
CSV = "frame,view,point,x,y,confidence\n"
NPY = b"\x93NUMPY\x01\x00"


def toml(folder, text, name="own.toml"):
    path = folder / name
    path.write_text(text)
    return path


def head(**fields):
    said = {"baseline": 0.1, "focal": 600.0, "image": [640, 240]} | fields
    lines = [f"{key} = {json.dumps(value) if isinstance(value, list) else value}" for key, value in said.items()]
    return 'extends = "panda"\n[head]\n' + "\n".join(lines)


@pytest.fixture
def refused(ask):
    """Runs a command in this process → what it says, which is short, in time and about bad input."""

    def run(*words):
        began = time.process_time()
        status, out, err = ask(*words)
        assert time.process_time() - began < WITHIN_S
        assert status == 2 and not out and err.count("\n") <= 2 and len(err) < 1_000, err
        return err

    return run


# A process begins with the most memory that the one had which began it, so a small one stands between.
SMALL = """
import json, resource, subprocess, sys
status = subprocess.run([sys.executable, "-I", "-m", "viewimit.commands.cli", *sys.argv[1:]]).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps([status, used.ru_utime + used.ru_stime, used.ru_maxrss]))
"""


def refused_apart(*words, home=None):
    """The same in a process of its own, whose memory is measured."""
    command = [sys.executable, "-I", "-c", SMALL, *map(str, words)]
    env = {**os.environ, **(home or {})}
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=env, start_new_session=True
    )
    watch = threading.Timer(30, os.killpg, (process.pid, signal.SIGKILL))  # with one that waits for a pipe
    watch.start()
    said = process.stdout.read()
    process.wait()
    watch.cancel()
    process.stdout.close()
    said, _, used = said.rstrip("\n").rpartition("\n")
    status, cpu_s, most_kb = json.loads(used)
    assert status == 2 and said.count("\n") <= 1, said
    assert cpu_s < WITHIN_S and most_kb < MOST_KB, used
    return said


SCENES = [
    ('extends = "own"', "build on itself"),
    ('extends = "other"', "build on itself"),
    ("a = " + "[" * 5_000 + "]" * 5_000, "nests too deeply"),
    ("a" + ".a" * 20_000 + " = 1", "a name of more than 32 parts"),
    ('"a"' + ' . "b c"' * 20_000 + " = 1", "a name of more than 32 parts"),
    ("[a" + ".a" * 20_000 + "]", "a name of more than 32 parts"),
    ('a = "\\""\n[a' + ".a" * 20_000 + "]", "a name of more than 32 parts"),
    ("a = '''it's # here'''\n" + "a" + ".'#'" * 20_000 + " = 1", "a name of more than 32 parts"),
    ('a = """x"""" # """\n' + "a" + ".a" * 20_000 + " = 1", "a name of more than 32 parts"),
    ("a = 1 #" + '"' * 3 * 100_000 + "\na" + ".a" * 20_000 + " = 1", "a name of more than 32 parts"),
    ("a = " + "[" * 400 + "]" * 400, "own.toml"),
    ('extends = "panda"\n[head]\nundistort = [11, 0]', "head.left: a distortion of k1 11, k2 0 is none of a lens"),
    ('extends = "panda"\n[head.right]\ndistortion = [0, 1e5]', "head.right: a distortion of k1 0, k2 100000 is none"),
    (head(focal=0), "head.focal must be more than 0"),
    (head(focal=-600.0), "head.focal must be more than 0"),
    (head(focal=1e-300), "head.focal must be more than 0"),
    (head(baseline=0), "head.baseline must be more than 0"),
    (head(baseline=-0.1), "head.baseline must be more than 0"),
    (head(baseline="nan"), "not a finite number"),
    (head(image=[0, 240]), "head.image must be 1 to"),
    (head(image=[640, -240]), "head.image must be 1 to"),
    (head(image=[100_000, 100_000]), "head.image must be 1 to"),
    (head(focal="1e308"), "head.focal is 1e+308, not within"),
    (head(position=[1e308, 0, 0]), "not within"),
    (head(focal="9" * 400), "not within"),
    ("a = 1\n" * 400_000, "more than 1"),
    (f'extends = "{"a" * 100_000}"', "File name too long"),
    (f'extends = "panda"\nrobot = "{"a" * 100_000}.urdf"', "File name too long"),
    ('extends = "\\u001b]0;a\\u0007\\u0000"', r"/\x1b]0;a\x07\x00.toml"),
]


def test_scenes(tmp_path, refused):
    toml(tmp_path, 'extends = "own"', "other.toml")
    for text, why in SCENES:
        assert why in refused("imitate", "--scene", toml(tmp_path, text)), text[:80]


def test_a_chain_of_scenes_has_an_end(tmp_path, refused):
    for k in range(2_000):
        toml(tmp_path, f'extends = "s{k + 1}"', f"s{k}.toml")
    toml(tmp_path, SCENE, "s2000.toml")
    assert "more than 16 scenes" in refused("imitate", "--scene", tmp_path / "s0.toml")
    assert "more than 16 scenes" not in refused("imitate", "--scene", tmp_path / "s1990.toml", "--n-points", 11)


@pytest.mark.parametrize(
    "old, new, why",
    [
        ('xyz="0 0 0.333"', 'xyz="0 0 1e308"', "beyond 1e+06"),
        ('rpy="0 0 0"', 'rpy="1e308 0 0"', "beyond 1e+06"),
        ('xyz="0 0 1"', 'xyz="0 0 1e-200"', "its axis is zero"),
        ('lower="', 'lower="-1e308" was="', "beyond 1e+18"),
        ('xyz="0 0 1"', f'xyz="{"x" * 100_000}"', "is not numbers"),
    ],
    ids=lambda value: str(value)[:24],
)
def test_robots(tmp_path, refused, old, new, why):
    assert old in PANDA
    path = tmp_path / "own.urdf"
    path.write_text(PANDA.replace(old, new))
    assert why in refused("imitate", "--robot", path)


def test_robots_of_too_many_parts(tmp_path, refused):
    joint = '<joint name="{0}" type="fixed"><parent link="a"/><child link="l{0}"/></joint>'
    shape = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    for name, inside in (
        ("joints", "".join(joint.format(k) for k in range(100_000))),
        ("shapes", f'<link name="a">{shape * 100_000}</link>'),
    ):
        path = tmp_path / f"{name}.urdf"
        path.write_text(f'<robot name="r">{inside}</robot>')
        assert f"100000 {name}, more than" in refused("imitate", "--robot", path)


def test_meshes_that_no_arm_has_are_told_and_not_drawn(tmp_path):
    from viewimit.simulation.urdf.mesh_files import NotFound, load_mesh

    path = tmp_path / "far.stl"
    path.write_bytes(bytes(80) + struct.pack("<I12fH", 1, 0, 0, 1, 0, 0, 0, 3e38, 0, 0, 0, 3e38, 0, 0))
    with pytest.raises(NotFound, match="vertices beyond"):
        load_mesh(path)
    path = tmp_path / "point.obj"
    path.write_text("v 0 0 0\n" * 3 + "f 1 2 3\n")
    with pytest.raises(NotFound, match="without an area"):
        load_mesh(path)
    os.mkfifo(tmp_path / "pipe.stl")
    with pytest.raises(NotFound, match="a pipe or device"):
        load_mesh(tmp_path / "pipe.stl")


@pytest.mark.parametrize(
    "rows, why",
    [
        ("0,l,a,1e308,0,1\n", "is no pixel"),
        ("0,l,a,0,0,1e308\n", "is no pixel"),
        ("9" * 400 + ",l,a,0,0,1\n", "is not a whole number"),
        ("0,l," + "a" * 2_000_000 + ",0,0,1\n", "line 2 has more than"),
        ("0,l," + "a" * 200_000 + ",0,0,1\n", "line 2: field larger"),
        ("".join(f"{k},{v},p{k},0,0,1\n" for k in range(3_000) for v in "lrLR"), "3,000 frames times 3,000 points"),
    ],
    ids=lambda value: str(value)[:24],
)
def test_tables(tmp_path, refused, rows, why):
    path = tmp_path / "own.csv"
    path.write_text(CSV + rows)
    assert why in refused("evaluate", path)


def tracks_of(path):
    return [word for name in VIEW_NAMES.values() for word in (option(name), path)]


def test_a_line_of_digits(tmp_path, refused):
    (tmp_path / "own.csv").write_text("1" * 100_000)
    assert "no column point" in refused("evaluate", *tracks_of(tmp_path / "own.csv"))


def npy(shape, content=b"", descr="<f8"):
    header = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    return NPY + struct.pack("<H", len(header)) + header + content


@pytest.mark.parametrize(
    "content",
    [npy((10**12, 9, 2)), npy((10**5, 9, 2)), npy("(" * 900 + ")" * 900), npy((2**62, 2**62)), npy((1,), b"1", "|O")],
    ids=range(5),
)
@pytest.mark.parametrize("suffix", [".npy", ".npz"])
def test_arrays_that_say_to_be_others(tmp_path, refused, content, suffix):
    path = tmp_path / f"own{suffix}"
    if suffix == ".npy":
        path.write_bytes(content)
    else:
        with zipfile.ZipFile(path, "w") as members:
            members.writestr("tracks.npy", content)
    assert "not an" in refused("evaluate", *tracks_of(path))
    assert "not an .npz file" in refused("imitate", "--calibration", path)


def zeros(path, megabytes):
    """An .npz of an array that unpacks to so much."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as members, members.open("tracks.npy", "w") as member:
        member.write(npy((megabytes << 17,)))
        for _ in range(megabytes):
            member.write(bytes(1 << 20))
    return path


def test_arrays_that_unpack_to_much(tmp_path):
    path = zeros(tmp_path / "bomb.npz", 500)
    assert path.stat().st_size < 2_000_000 < MAX_ARRAY_BYTES
    assert "it unpacks to 500 MB" in refused_apart("evaluate", *tracks_of(path))
    assert "it unpacks to 500 MB" in refused_apart("imitate", "--calibration", path)


def test_hdf5_without_content(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "own.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("tracks", (1, 2, 10, 100_000_000), "<f8", chunks=(1, 2, 10, 1_000))
        file["node_names"] = [b"a"] * 10
        file["track_names"] = [b"t"]
    assert "/tracks has 15,259 MB" in refused_apart("evaluate", *tracks_of(path))


def picture(path, width, height):
    """A PNG, all black."""
    row = bytes(1 + (width + 7) // 8)
    packing = zlib.compressobj(9)
    packed = b"".join(packing.compress(row * 100) for _ in range(height // 100)) + packing.flush()
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", packed) + chunk(b"IEND", b""))
    return path


def test_pictures_that_unpack_to_much(tmp_path):
    pytest.importorskip("cv2")
    path = picture(tmp_path / "a_l.png", 20_000, 19_000)
    assert path.stat().st_size < 369_000
    said = refused_apart("detect", path, "--out", tmp_path / "a.csv")
    assert "380 megapixels" in said or "more than 25 megapixels" in said


COMMANDS = {  # by the ending of what they read
    ".toml": ("imitate", "--scene", "{}"),
    ".urdf": ("imitate", "--robot", "{}"),
    ".csv": ("evaluate", "{}"),
    ".npz": ("imitate", "--calibration", "{}"),
    ".npy": ("evaluate", "--demo-left", "{}", "--demo-right", "{}", "--own-left", "{}", "--own-right", "{}"),
    ".h5": ("evaluate", "--demo-left", "{}", "--demo-right", "{}", "--own-left", "{}", "--own-right", "{}"),
    ".png": ("detect", "--demo-left", "{}", "--out", "/dev/null/none.csv"),
    ".mp4": ("detect", "--demo-left", "{}", "--out", "/dev/null/none.csv"),
    ".json": ("reproduce", "fig7", "--motion", "{}"),
    ".xml": ("imitate", "--robot", "{}"),
}


@pytest.mark.skipif(os.name != "posix", reason="devices and pipes of POSIX")
@pytest.mark.parametrize("endless", ["zero", "pipe", "huge"])
@pytest.mark.parametrize("suffix", COMMANDS)
def test_files_without_an_end(tmp_path, refused, suffix, endless):
    path = tmp_path / f"own{suffix}"
    if endless == "zero":
        path.symlink_to("/dev/zero")
    elif endless == "pipe":
        os.mkfifo(path)
    else:
        with path.open("wb") as file:
            file.truncate(1 << 40)  # of which nothing is kept
    refused(*(word.format(path) for word in COMMANDS[suffix]))


@pytest.mark.skipif(os.name != "posix", reason="devices of POSIX")
def test_a_device_takes_no_memory():
    assert "a pipe or device" in refused_apart("evaluate", "/dev/zero")


ORIGINS = [
    "class.example.org",
    "//class.example.org",
    "ftp://class.example.org",
    "https://",
    "https://a:b",
    "https://class.example.org/path",
    "https://me@class.example.org",
    "",
    "https://*",
    "https://a b",
    "https://*.example.org",
    "https://klasse.schüle.example",
]


def test_origins_that_no_browser_sends(refused):
    for origin in ORIGINS:
        assert "such as https://class.example.org" in refused("serve", "--origin", origin), origin
