"""A class by its messages alone: who is here, what is asked and led, what survives, and what is refused."""

import contextlib
import csv
import io
import os
import re
import socket
import sqlite3
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest
from class_server import CODE, ClassServer, Lecturer, Student
from viewimit.assets import ROOT
from waiting import stays, wait_until
from websockets.exceptions import InvalidStatus

CLASS = [sys.executable, "-I", "-m", "viewimit.commands.cli", "class", "--port", "0"]
WITH_CODE = {**os.environ, "VIEWIMIT_LECTURER": CODE}
STATE = {"lesson": "tour", "step": "eyes", "theta": [0.1, 0.2]}


@pytest.fixture(scope="module")
def server():
    with ClassServer() as server:
        yield server


@pytest.fixture
def lecturer(server):
    lecturer = Lecturer(server)
    yield lecturer
    for what in ("lead", "frozen", "hidden"):
        lecturer.send("switch", what=what, on=False)
    lecturer.send("do", what="close")
    lecturer.send("do", what="new")
    lecturer.orders(lambda o: not o["asked"] and not o["lead"] and not o["hidden"])
    lecturer.close()


@pytest.fixture
def students(server):
    students = [Student(server, name=name) for name in ("Mira", "", "Ben")]
    yield students
    for one in students:
        one.close()


def people(lecturer):
    """Who is here as the lecturer's page has it, by place."""
    found = {}
    for message in lecturer.heard:
        if message["kind"] == "people":
            found = {} if message.get("all") else found
            found |= {one["place"]: one for one in message["people"]}
            found = {place: one for place, one in found.items() if place not in message["gone"]}
    return found


def test_the_lecturer_sees_who_is_here_and_at_which_step(lecturer, students):
    wait_until(lambda: len(people(lecturer)) == 3)
    assert sorted(one["name"] for one in people(lecturer).values()) == ["", "Ben", "Mira"]
    students[0].send("at", lesson="tour", step="line", number=2, count=9, motions=3, E=1.5, path=[0, 0, 0.1, 0.2])
    wait_until(lambda: any((one["at"] or {}).get("step") == "line" for one in people(lecturer).values()))
    students[2].send("self", name=" Benjamin \n", linked=True)
    wait_until(lambda: "Benjamin" in {one["name"] for one in people(lecturer).values()})
    students[1].close()
    wait_until(lambda: len(people(lecturer)) == 2)
    assert not any(message["kind"] in ("people", "count") for message in students[0].heard)


def test_tabs_of_one_browser_are_one_person_with_one_vote(server, lecturer):
    one = Student(server)
    other = Student(server, one.token)
    wait_until(lambda: len(people(lecturer)) == 1)
    round = lecturer.ask()
    assert one.vote(round, 0)["kind"] == other.vote(round, 1)["kind"] == "ack"
    lecturer.counted(total=1, counts=[0, 1])
    one.close()
    other.close()


def test_a_question_is_counted_revealed_asked_again_and_compared_with_the_first_round(lecturer, students):
    for times, choices in enumerate(((0, 1, 1), (0, 0, 1), (0, 0, 0)), 1):
        round = lecturer.ask()
        for student, choice in zip(students, choices):
            student.orders(lambda o, round=round: (o["asked"] or {}).get("round") == round)
            assert student.vote(round, choice, right=choice != 0)["kind"] == "ack", "what a page says does not count"
        lecturer.counted(total=3, right=times)
        assert students[0].last("orders")["asked"]["results"] is None
        lecturer.send("reveal")
        asked = students[1].orders(lambda o: (o["asked"] or {}).get("revealed"))["asked"]
        assert asked["times"] == times
        assert students[0].vote(round, 2)["kind"] == "refused", "after the reveal"
    found = asked["results"]
    assert found["moved"] == {"right": 2, "gained": 1, "lost": 0, "wrong": 0}
    assert found["moved_since_first"] == {"right": 1, "gained": 2, "lost": 0, "wrong": 0}
    assert [found[one]["right"] for one in ("first", "before", "now")] == [1, 2, 3]
    lecturer.send("do", what="close")
    assert not students[0].orders(lambda o: not o["asked"])["asked"]


ASKED = {  # lesson and step, answers, what the lecturer's page says is right, how many are
    "place": ("tour", "crossing", [{"place": [3, 4]}, {"place": [20, 0]}], {"truth": [[0, 0]], "near": 6}, 1),
    "line": ("ray", "shadow", [{"place": [5, 3]}, {"place": [30, 0]}], {"truth": [[0, 0], [9, 0], [9, 9]]}, 1),
    "number": ("tour", "claim", [{"number": 7}, {"number": 17}], {"truth": [[10]]}, 1),
    "posture": ("motion", "alike", [{"posture": [7, 9]}, {"posture": [7, 30]}], {"truth": [[0, 10]]}, 1),
    "choice": ("limits", "noise", [{"choice": 1}, {"choice": 0}], {"truth": [[2]]}, 1),
    "bets": ("sign", "sign", [{"values": [70, 30]}, {"values": [10]}], {}, None),
    "motions": ("tour", "servo", [{"number": 7}, {"number": 2}], {}, None),
    "unknown": ("tour", "claim", [{"number": 7}, {"number": 17}], {}, None),
}


@pytest.mark.parametrize("what", ASKED)
def test_what_only_a_page_computes_is_judged_by_the_lecturers_truth(lecturer, students, what):
    lesson, step, answers, truth, right = ASKED[what]
    round = lecturer.ask(lesson, step)
    for student, answer in zip(students, answers):
        assert student.reply(student.answer(lesson, step, answer, round, right=True))["kind"] == "ack"
    lecturer.counted(total=2, right=None)
    lecturer.send("reveal", **truth)
    found = students[0].orders(lambda o: o["asked"]["revealed"])["asked"]["results"]["now"]
    assert found["right"] == right
    said = ["1", "0"] if right else ["", ""]
    assert sorted(row["right"] for row in exported(lecturer)) == sorted(said)


def test_who_leads_is_followed_until_they_let_go_and_late_comers_hear_it(server, lecturer, students):
    lecturer.send("state", state=STATE)
    lecturer.send("switch", what="lead", on=True)
    assert students[0].orders(lambda o: o["lead"])["lead"]
    lecturer.send("state", state=STATE)
    assert students[0].wait("screen")["state"] == STATE
    late = Student(server)
    assert late.last("orders")["lead"] and late.wait("screen")["state"] == STATE
    assert len([m for m in students[0].heard if m["kind"] == "screen"]) == 1, "none from before"
    lecturer.send("switch", what="lead", on=False)
    students[0].orders(lambda o: not o["lead"])
    lecturer.send("state", state=STATE, once=True)
    assert students[0].wait("send")["state"] == STATE
    late.close()


def test_all_are_gathered_frozen_and_reset_and_the_truth_is_hidden(server, lecturer, students):
    lecturer.send("gather", lesson="tour", step="line")
    first = students[0].orders(lambda o: o["gather"])["gather"]
    lecturer.send("gather", lesson="tour", step="line")
    assert students[0].orders(lambda o: o["gather"] != first)["gather"]["number"] == first["number"] + 1
    lecturer.send("switch", what="frozen", on=True)
    lecturer.send("switch", what="hidden", on=True)
    lecturer.send("do", what="reset")
    students[1].orders(lambda o: o["frozen"] and o["hidden"] and o["reset"])
    late = Student(server)
    assert late.last("orders")["hidden"]
    late.close()


def test_the_lecturer_opens_a_copy_of_a_students_screen(lecturer, students):
    wait_until(lambda: len(people(lecturer)) == 3)
    place = next(place for place, one in people(lecturer).items() if one["name"] == "Mira")
    lecturer.send("request", place=place)
    wanted = students[0].wait("request")["number"]
    students[1].send("copy", number=wanted, state={"not": "mine"})
    students[0].send("copy", number=wanted, state=STATE)
    assert lecturer.wait("copy")["state"] == STATE
    lecturer.send("request", place=999_999)
    assert "gone" in lecturer.wait("done")["what"]


def test_only_who_types_the_code_is_the_lecturer_and_leaves_with_one_message(server, lecturer, students):
    guess = Student(server)
    guess.send("login", code=CODE[:-1])
    assert "not the code" in guess.wait("wrong")["why"]
    wait_until(lambda: "a wrong lecturer's code from 127.0.0.1" in server.log)
    guess.send("login", code=CODE)
    session = guess.wait("lecturer")["session"]
    guess.send("at", lesson="tour", step="eyes")
    wait_until(lambda: len(people(lecturer)) == 3)
    stays(lambda: len(people(lecturer)) == 3, 1)
    guess.send("do", what="logout")
    guess.wait("student")
    wait_until(lambda: len(people(lecturer)) == 4)
    guess.close()
    again = Student(server, guess.token)
    again.close()
    late = Lecturer(server, session=session)
    assert not late.wait("welcome")["lecturer"], "the session has ended"
    late.close()


def test_a_new_code_ends_the_sessions_of_others():
    with ClassServer() as server:
        one, other = Lecturer(server), Lecturer(server)
        one.send("code", code="a longer word")
        other.wait("student")
        assert "changed" in one.wait("done")["what"]
        one.close()
        server.restart()
        old = Student(server)
        old.send("login", code=CODE)
        old.wait("wrong")
        old.send("login", code="a longer word")
        old.wait("lecturer")
        assert "chosen on the page" in server.log and CODE not in server.log
        back = Lecturer(server, session=one.session)
        assert back.wait("welcome")["lecturer"]


def test_a_restart_loses_nothing():
    with ClassServer() as server:
        lecturer, student = Lecturer(server), Student(server, name="Mira")
        lecturer.send("gather", lesson="tour", step="line")
        lecturer.send("switch", what="hidden", on=True)
        round = lecturer.ask()
        assert student.vote(round, 1, right=False)["kind"] == "ack"
        number = exported(lecturer)[0]["person"]
        server.restart()
        lecturer = Lecturer(server, lecturer.token, lecturer.session)
        student = Student(server, student.token)
        assert lecturer.wait("welcome")["lecturer"]
        orders = student.last("orders")
        assert orders["asked"]["round"] == round and orders["hidden"] and orders["gather"]["step"] == "line"
        lecturer.counted(total=1, counts=[0, 1])
        assert student.vote(round, 0, right=True)["kind"] == "ack"
        lecturer.counted(total=1, counts=[1])
        assert [row["person"] for row in exported(lecturer)] == [number]
        server.stop()


def test_without_a_lecturer_students_are_let_go():
    with ClassServer() as server:
        lecturer, student = Lecturer(server), Student(server)
        lecturer.send("switch", what="frozen", on=True)
        lecturer.send("switch", what="hidden", on=True)
        lecturer.ask()
        student.orders(lambda o: o["frozen"] and o["hidden"] and o["asked"])
        lecturer.close()
        stays(lambda: student.last("orders")["frozen"] and student.last("orders")["hidden"], 3)
        student.orders(lambda o: not o["frozen"] and not o["hidden"] and not o["asked"])


def exported(lecturer):
    before = lecturer.last("csv")
    lecturer.send("do", what="export")
    return list(csv.DictReader(io.StringIO(lecturer.wait("csv", lambda m: m is not before)["text"])))


def test_all_answers_are_exported_and_those_of_who_wants_it_are_not_linked(server, lecturer, students):
    round = lecturer.ask()
    for student in students:
        student.vote(round, 1)
    own = students[0].answer("tour", "crossing", {"place": [1.5, 2]}, seconds=12.34)
    students[0].reply(own)
    number = next(row["person"] for row in exported(lecturer) if row["item"] == "crossing")
    numbers = {row["person"] for row in exported(lecturer)}
    assert len(numbers) == 3 and "unlinked" not in numbers
    students[1].send("self", linked=False)
    unlinked = students[1].answer("questions", "line", {"choice": 0}, phase="before", right=True, sure=False)
    students[1].reply(unlinked)
    assert students[1].vote(round, 2, right=False)["kind"] == "ack"
    lecturer.counted(total=3, counts=[0, 2, 1])  # still one vote each
    rows = exported(lecturer)
    assert list(rows[0]) == "person form item phase answer right sure seconds".split()
    assert {(row["item"], row["phase"], row["answer"], row["right"]) for row in rows if row["person"] == number} == {
        ("eyes", "round 1", "2", "0"),
        ("crossing", "own", "1.5 2", ""),
    }
    assert next(row for row in rows if row["item"] == "crossing")["seconds"] == "12.3"
    nobodys = [row for row in rows if row["person"] == "unlinked"]
    assert sorted((row["form"], row["phase"], row["sure"]) for row in nobodys) == [
        ("questions", "before", "guess"),
        ("tour", "round 1", ""),
    ]
    assert {row["person"] for row in rows} < numbers | {"unlinked"}, "the number of who is not linked is gone"


def numbers_in(value):
    """All numbers of a message, as texts."""
    if isinstance(value, dict):
        return {one for part in value.values() for one in numbers_in(part)}
    if isinstance(value, list):
        return {one for part in value for one in numbers_in(part)}
    return {str(value)}


def test_the_numbers_of_the_table_are_not_sent_with_names(lecturer, students):
    for student in students:
        assert student.reply(student.answer("tour", "line", {"choice": 0}))["kind"] == "ack"
        student.send("at", lesson="tour", step="line")
    numbers = {row["person"] for row in exported(lecturer)}
    assert len(numbers) == 3
    wait_until(lambda: len([one for one in people(lecturer).values() if one["at"]]) == 3)
    for browser in (lecturer, *students):
        for message in browser.heard:
            if message["kind"] != "csv":
                assert not numbers & numbers_in(message), message


def test_the_gain_is_of_those_who_answered_both_times_and_of_no_few(server, lecturer, students):
    more = [*students, *(Student(server) for _ in range(4))]
    for k, student in enumerate(more):
        for phase, right in (("before", k % 2 == 0), ("after", k != 1)):
            if (k, phase) != (6, "after"):
                kept = student.answer("questions", "line", {"choice": 0 if right else 1}, phase=phase, right=not right)
                assert student.reply(kept)["kind"] == "ack"
        lecturer.heard[:] = [m for m in lecturer.heard if m["kind"] != "gain"]
        lecturer.send("do", what="gain")
        found = lecturer.wait("gain")["learned"]
        assert found["enough"] == (k >= 4) and (k >= 4) == (found["gain"] is not None)
    assert found["persons"] == 6 and found["items"] == [{"item": "line", "persons": 6, "before": 3, "after": 5}]
    assert found["gain"] == pytest.approx((5 - 3) / (6 - 3)) and found["low"] <= found["gain"] <= found["high"]
    for one in more[3:]:
        one.close()


def test_an_answer_that_cannot_be_saved_is_not_acknowledged_until_it_is():
    with ClassServer() as server:
        lecturer, student = Lecturer(server), Student(server)
        round = lecturer.ask()
        other = sqlite3.connect(server.data, isolation_level=None)
        other.execute("begin exclusive")
        seq = student.answer("tour", "eyes", {"choice": 0}, round)
        lecturer.wait("count", lambda m: "locked" in (m["problem"] or ""))
        assert not [m for m in student.heard if m.get("seq") == seq]
        other.execute("rollback")
        assert student.reply(seq)["kind"] == "ack"
        lecturer.wait("count", lambda m: m["problem"] is None)
        assert server.log.count("answers are not saved") == 1


HOSTILE = {
    "too long": ('{"kind":"self","name":"' + "x" * 20_000 + '"}', "a message of 2"),
    "far too long": ("x" * 100_000, "too long"),
    "binary": (b"\x00\x01", "binary"),
    "not JSON": ("hello", "no message"),
    "deep": ("[" * 10_000, "no message"),
    "unknown": ('{"kind":"shutdown"}', "no message"),
    "wrong types": ('{"kind":"answer","seq":"1","lesson":"tour","step":"eyes","answer":{"choice":0}}', "no message"),
    "a further field": ('{"kind":"self","name":"x","html":"<b>"}', "no message"),
    "two answers": (
        '{"kind":"answer","seq":1,"lesson":"t","step":"e","answer":{"choice":0,"number":1}}',
        "exactly one",
    ),
    "no number": ('{"kind":"answer","seq":1,"lesson":"t","step":"e","answer":{"number":NaN}}', "no message"),
    "a line break": ('{"kind":"do","x\\nwarning: all is well":1}', "no message"),
    "orders of a student": ('{"kind":"ask","lesson":"tour","step":"eyes"}', "not the lecturer"),
    "a second hello": ('{"kind":"hello","token":"' + "0" * 32 + '"}', "one hello"),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_messages_end_the_connection_with_one_line(server, what):
    message, words = HOSTILE[what]
    student, before = Student(server), len(server.lines)
    student.socket.send(message)
    wait_until(lambda: student.closed)
    wait_until(lambda: len(server.lines) > before)
    time.sleep(0.1)
    assert len(server.lines) == before + 1 and "rejected from 127.0.0.1" in server.lines[-1], server.log
    assert words in server.lines[-1] and len(server.lines[-1]) < 250
    Student(server).close()


def test_a_flood_and_a_first_message_that_is_no_hello_are_rejected(server):
    student = Student(server)
    before = len(server.lines)
    for _ in range(300):
        try:
            student.send("self")
        except Exception:
            break
    wait_until(lambda: student.closed)
    wait_until(lambda: "too many messages" in "".join(server.lines[before:]))
    rude = Student(server, hello=False)
    rude.send("self")
    wait_until(lambda: "begins with one hello" in "".join(server.lines[before:]))
    assert len(server.lines) == before + 2


def test_pages_of_other_origins_do_not_connect(server):
    port = server.url.rpartition(":")[2]
    for origin in ("http://evil.example", "null", f"{server.url}0"):
        with pytest.raises(InvalidStatus, match="403"):
            Student(server, origin=origin)
    wait_until(lambda: server.log.count("another origin") >= 3)
    foreign = f"evil.example:{port}"  # a name that points here, as an attacker's may
    head = f"GET /socket HTTP/1.1\r\nHost: {foreign}\r\nOrigin: http://{foreign}\r\nUpgrade: websocket\r\n"
    key = "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    with socket.create_connection(("127.0.0.1", int(port))) as rebound:
        rebound.sendall((head + key).encode())
        assert b" 403 " in rebound.recv(100)


NOTHING_LIKE_THAT = {
    "no lesson": ("no such lesson", "eyes", {"choice": 0}, "own"),
    "no step": ("tour", "no such step", {"choice": 0}, "own"),
    "no option": ("tour", "eyes", {"choice": 20}, "own"),
    "another kind": ("tour", "eyes", {"values": [1.5] * 60}, "own"),
    "no phase": ("tour", "eyes", {"choice": 0}, "before"),
    "no question": ("questions", "q1", {"choice": 0}, "after"),
    "without phase": ("questions", "line", {"choice": 0}, "own"),
}


def test_answers_to_what_the_class_does_not_ask_are_refused_and_not_kept(server, lecturer, students):
    for lesson, step, answer, phase in NOTHING_LIKE_THAT.values():
        seq = students[0].answer(lesson, step, answer, phase=phase)
        assert students[0].reply(seq)["kind"] == "refused", (lesson, step, answer, phase)
    assert exported(lecturer) == []


def test_one_device_neither_keeps_the_lecturer_out_nor_outvotes_four_students():
    """One types wrong codes, as the same browser and as new ones; one votes with a fresh token each time."""
    with ClassServer() as server:
        lecturer, students = Lecturer(server), [Student(server) for _ in range(4)]
        round = lecturer.ask()
        for choice, student in enumerate(students):
            assert student.vote(round, choice % 2)["kind"] == "ack"
        guess = Student(server)
        for _ in range(12):
            guess.send("login", code="wrong")
        wait_until(lambda: sum(message["kind"] == "wrong" for message in guess.heard) == 12)
        assert len({message["why"] for message in guess.heard if message["kind"] == "wrong"}) == 2, "it has to wait"
        another = Lecturer(server)  # a new browser
        for _ in range(130):
            new = Student(server)
            new.send("login", code="wrong")
            assert new.vote(round, 2)["kind"] == "ack"
            new.close()
        lecturer.counted(total=4, counts=[2, 2])
        patient = Student(server)
        time.sleep(3)  # no new browser any more
        patient.send("login", code=CODE)
        patient.wait("lecturer")
        students[0].close()  # who has left still counts
        lecturer.send("reveal")
        asked = students[1].orders(lambda o: o["asked"]["revealed"])["asked"]
        assert asked["results"]["now"]["total"] == 4 and asked["left_out"] == 130
        assert len(exported(lecturer)) == 4
        another.close()


@pytest.mark.parametrize("trusted", [True, False])
def test_students_who_leave_count_up_to_as_many_as_were_here_from_their_address(trusted):
    """One stays, two come and leave one after the other; a trusted proxy says that their addresses differ."""
    from_address = lambda k: {"X-Forwarded-For": f"198.51.100.{k}"}
    with ClassServer(*(["--trust-proxy", "127.0.0.1"] if trusted else [])) as server:
        lecturer = Lecturer(server)
        round = lecturer.ask()
        Student(server, additional_headers=from_address(1)).vote(round, 0)
        for k in (2, 3):
            student = Student(server, additional_headers=from_address(k))
            student.vote(round, 1)
            time.sleep(3)
            student.close()
        lecturer.counted(total=3 if trusted else 2)
        lecturer.send("reveal")
        assert lecturer.orders(lambda o: o["asked"]["revealed"])["asked"]["left_out"] == (0 if trusted else 1)


def asked(url, **headers):
    with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=20) as answer:
        return answer.status, answer.headers, answer.read()


def test_the_page_has_a_policy_with_hashes_and_is_kept_by_browsers(server):
    status, headers, body = asked(server.url)
    policy = headers["Content-Security-Policy"]
    assert "'sha256-" in policy and "unsafe-inline" not in policy.partition("script-src")[2].partition(";")[0]
    assert "frame-ancestors 'self'" in policy and b"http-equiv" not in body and "Set-Cookie" not in headers
    assert asked(server.url, **{"Accept-Encoding": "gzip"})[1]["Content-Encoding"] == "gzip"
    with pytest.raises(urllib.error.HTTPError, match="304"):
        asked(server.url, **{"If-None-Match": headers["ETag"]})


def damaged(folder):
    """Files that are none of a class, and why."""
    with ClassServer(data=folder / "class.sqlite") as server:
        round = Lecturer(server).ask()
        for k in range(30):
            Student(server).vote(round, k % 3)
        server.stop()
    whole = server.data.read_bytes()
    (folder / "half.sqlite").write_bytes(whole[:4096] + bytes(range(256)) * 32 + whole[12288:])
    (folder / "cut.sqlite").write_bytes(whole[: len(whole) // 2])
    (folder / "none.sqlite").write_bytes(b"not a database" * 100)
    changes = {
        "orders": "update kept set value = '{' where key = 'orders'",
        "answer": "update answers set answer = 'x'",
        "seconds": "update answers set seconds = 'soon'",
        "column": "alter table answers rename column sure to certain",
        "table": "create table notes (text)",
    }
    for name, change in changes.items():
        (folder / f"{name}.sqlite").write_bytes(whole)
        with contextlib.closing(sqlite3.connect(folder / f"{name}.sqlite")) as file, file:
            file.execute(change)
    with contextlib.closing(sqlite3.connect(folder / "other.sqlite")) as file, file:
        file.execute("create table answers (x)")
    server.data.unlink()
    return sorted(folder.glob("*.sqlite"))


def test_a_damaged_or_foreign_file_ends_in_a_sentence_and_stays_as_it_is(tmp_path, ask, monkeypatch):
    monkeypatch.setenv("VIEWIMIT_LECTURER", CODE)
    files = damaged(tmp_path)
    assert len(files) == 9
    for path in files:
        before = path.read_bytes()
        status, _, stderr = ask("class", "--port", 0, "--data", path)
        assert status == 2 and str(path) in stderr and "Traceback" not in stderr, stderr
        assert path.read_bytes() == before, path.name


def test_lessons_that_no_page_can_show_are_refused_before_a_class_is_announced(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(ROOT.joinpath("lessons/limits.toml").read_text("utf-8").replace('"panda-toed"', '"iiwa"'), "utf-8")
    command = [*CLASS, "--data", str(tmp_path / "a"), "--lesson", str(own)]
    done = subprocess.run(command, capture_output=True, text=True, env=WITH_CODE)
    assert done.returncode == 2 and "--lesson: no layout" in done.stderr and not done.stdout
    assert not (tmp_path / "a").exists()


def test_the_code_is_printed_on_a_terminal_alone(tmp_path):
    command = [*CLASS, "--data", str(tmp_path / "a")]
    clean = {name: value for name, value in os.environ.items() if name != "VIEWIMIT_LECTURER"}
    done = subprocess.run(command, capture_output=True, text=True, env=clean)
    assert done.returncode == 2 and "VIEWIMIT_LECTURER" in done.stderr
    ours, theirs = pytest.importorskip("pty").openpty()
    process = subprocess.Popen(command, stdout=theirs, stderr=subprocess.PIPE, env=clean)
    said = ""
    while "answers are kept" not in said:
        said += os.read(ours, 4096).decode()
    process.terminate()
    process.wait()
    assert re.search(r"the lecturer's code is [a-z2-9]{8}: ", said)
