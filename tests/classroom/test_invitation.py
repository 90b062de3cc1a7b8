"""How students join: by the address that others can reach, without the secret; its code is large until one click."""

import re

import numpy as np
import pytest
from class_pages import SHARED, Class
from drawn import INVITATION
from quiet_page import QuietPage
from viewimit.app.classroom.classroom import Classroom
from viewimit.app.classroom.local_board import LocalBoard
from viewimit.app.control.classroom.attendance import Attendee
from viewimit.app.panels.qr import draw_qr
from viewimit.app.server import address

JOIN = f'class="{INVITATION}"'


def test_the_lecturer_sees_the_address_and_shows_it_large_until_the_next_click():
    of = Class(students=2)
    assert f"Students open <b>{SHARED}</b>" in of.lecturer.shown and JOIN not in of.lecturer.shown
    of.do("invite")
    assert JOIN in of.lecturer.shown and draw_qr(SHARED, "QR code of the address") in of.lecturer.shown
    assert "<b>2</b> here" in of.lecturer.shown
    assert not any(JOIN in student.shown or "Students open" in student.shown for student in of.students)
    of.do("invite")
    assert JOIN not in of.lecturer.shown


def test_where_nobody_else_comes_the_lecturer_is_told_how_they_could():
    classroom = Classroom(LocalBoard(), "alone")
    page = QuietPage(address="/touch/0.x", classroom=classroom, of_class=Attendee(lecturer=True))
    page.tick()
    assert "start the server with <code>--host 0.0.0.0</code>" in page.shown and "class/invite" not in page.shown


@pytest.mark.parametrize(
    "host, origin, others",
    [
        ("0.0.0.0", "http://localhost:8080", "http://192.0.2.9:8080"),
        ("0.0.0.0", "http://127.0.0.1:9000", "http://192.0.2.9:9000"),
        ("::", "http://[::1]:8080", "http://192.0.2.9:8080"),
        ("0.0.0.0", "http://lectern:8080", "http://192.0.2.9:8080"),
        ("0.0.0.0", "http://192.0.2.44:8080", "http://192.0.2.44:8080"),
        ("127.0.0.1", "https://class.example.org", "https://class.example.org"),
        ("192.0.2.8", "http://localhost", "http://192.0.2.8:80"),
        ("127.0.0.1", "http://localhost:8080", None),
        ("0.0.0.0", None, None),
    ],
)
def test_others_get_an_address_that_leads_from_elsewhere_to_this_machine(host, origin, others, monkeypatch):
    monkeypatch.setattr(address, "lan_address", lambda: "192.0.2.9")
    assert address.origin_for_others(host, origin) == others


def test_without_a_network_nobody_is_invited(monkeypatch):
    monkeypatch.setattr(address, "lan_address", lambda: None)
    assert address.origin_for_others("0.0.0.0", "http://localhost:8080") is None


def test_the_code_is_the_address():
    cv2 = pytest.importorskip("cv2")
    path = re.search(r'viewBox="0 0 (\d+) \d+".*?<path[^>]*class="qrline"[^>]*d="([^"]*)"', draw_qr(SHARED, ""))
    side, x, y = int(path[1]), 0.0, 0.0
    modules = np.full((side, side), 255, np.uint8)
    for verb, numbers in re.findall(r"([Mmh])([-\d. ]+)", path[2]):  # as segno draws: lines along the rows
        step = [float(number) for number in re.findall(r"-?[\d.]+", numbers)]
        if verb == "h":
            modules[int(y), int(x) : int(x + step[0])] = 0
            x += step[0]
        else:
            x, y = step if verb == "M" else (x + step[0], y + step[1])
    assert cv2.QRCodeDetector().detectAndDecode(np.kron(modules, np.ones((8, 8), np.uint8)))[0] == SHARED
