"""The eight questions as exam items: GIFT as Moodle documents it, QTI 2.1 as its schema has it.

qti_schemas.zip holds the schema of QTI 2.1 and those that it imports, unchanged, as the project qti-sdk distributes
them; their licence notices permit that and stand in them.
"""

import io
import re
import zipfile
from pathlib import Path

import pytest
from lxml import etree
from viewimit.app.lab.lessons import exam

from viewimit.commands.cli import main

QTI = {"q": exam.QTI}
SCHEMAS = Path(__file__).with_name("qti_schemas.zip")
ITEMS = exam.exam_items()


def parse_gift(text: str) -> list[dict]:
    """Parse multiple-choice questions of GIFT: ::title::[format]text {=right#feedback ~wrong#feedback}."""
    found = []
    text = "\n".join(line for line in text.splitlines() if not line.startswith(("//", "$CATEGORY:")))
    for block in filter(None, (block.strip() for block in re.split(r"\n\s*\n", text))):
        whole = re.fullmatch(r"::((?:\\.|[^\\:])+)::\[plain\]((?:\\.|[^\\{}])*)\{((?:\\.|[^\\{}])*)\}", block, re.S)
        assert whole, block
        parts = re.findall(r"([=~])((?:\\.|[^\\=~#])*)#((?:\\.|[^\\=~#])*)", whole[3])
        plain = [(mark, *(re.sub(r"\\(.)", r"\1", words).strip() for words in texts)) for mark, *texts in parts]
        answers = [{"right": mark == "=", "text": text, "because": because} for mark, text, because in plain]
        found.append({"id": whole[1], "text": re.sub(r"\\(.)", r"\1", whole[2]).strip(), "answers": answers})
    return found


def test_gift_has_every_question_with_its_answers_and_replies():
    found = parse_gift(exam.gift(ITEMS))
    assert [one["id"] for one in found] == [item["id"] for item in ITEMS] and len(found) == 8
    for one, item in zip(found, ITEMS):
        assert one["text"] == item["text"]
        wanted = [
            {"right": answer["right"], "text": answer["text"], "because": answer["because"].replace("**", "")}
            for answer in item["answers"]
        ]
        assert one["answers"] == wanted and sum(answer["right"] for answer in wanted) == 1


@pytest.fixture(scope="module")
def schema(tmp_path_factory):
    folder = tmp_path_factory.mktemp("schemas")
    zipfile.ZipFile(SCHEMAS).extractall(folder)
    return etree.XMLSchema(etree.parse(folder / "qtiv2p1" / "imsqti_v2p1.xsd"))


@pytest.fixture(scope="module")
def package():
    return zipfile.ZipFile(io.BytesIO(exam.qti_package(ITEMS)))


def test_items_and_test_are_valid_qti(schema, package):
    for name in package.namelist():
        if name != "imsmanifest.xml":
            schema.assertValid(etree.fromstring(package.read(name)))


def test_the_manifest_names_every_file_once(package):
    manifest = etree.fromstring(package.read("imsmanifest.xml"))
    space = {"p": exam.PACKAGE}
    hrefs = [file.get("href") for file in manifest.findall(".//p:file", space)]
    assert sorted(hrefs) == sorted(set(package.namelist()) - {"imsmanifest.xml"})
    identifiers = {one.get("identifier") for one in manifest.findall(".//p:resource", space)}
    assert {one.get("identifierref") for one in manifest.findall(".//p:dependency", space)} < identifiers
    test = etree.fromstring(package.read("test.xml"))
    assert [ref.get("href") for ref in test.findall(".//q:assessmentItemRef", QTI)] == hrefs[1:]


def test_the_right_answer_of_an_item_scores_and_each_answer_has_its_reply(package):
    for item in ITEMS:
        root = etree.fromstring(package.read(f"items/{item['id']}.xml"))
        right = root.findtext(".//q:correctResponse/q:value", namespaces=QTI)
        texts = {choice.get("identifier"): choice.text for choice in root.findall(".//q:simpleChoice", QTI)}
        replies = {one.get("identifier"): one.text for one in root.findall(".//q:modalFeedback", QTI)}
        by_text = {answer["text"]: answer for answer in item["answers"]}
        assert by_text[texts[right]]["right"] and set(texts) == set(replies)
        assert all(replies[name] == by_text[text]["because"].replace("**", "") for name, text in texts.items())


@pytest.mark.parametrize(("kind", "name"), [("gift", "a.gift"), ("gift", "a.txt"), ("qti", "a.zip")])
def test_a_command_writes_them(kind, name, tmp_path, capsys):
    assert main(["exam", "--format", kind, "--out", str(tmp_path / name)]) == 0
    assert (tmp_path / name).stat().st_size > 2000
    assert "8 items" in capsys.readouterr().err
