"""The eight questions as exam items: Moodle GIFT, and a package of IMS QTI 2.1 items.

GIFT: https://docs.moodle.org/en/GIFT_format. QTI: IMS Question and Test Interoperability 2.1 (2012), a content package
with one test and one file for each item.
"""

import io
import re
import zipfile
from collections.abc import Sequence
from typing import Any
from xml.sax.saxutils import escape

from .source import questions
from .step_data import items_with_facts

CATEGORY = "viewimit/View-based imitation"
TITLE = "View-based imitation: eight questions"
QTI = "http://www.imsglobal.org/xsd/imsqti_v2p1"
PACKAGE = "http://www.imsglobal.org/xsd/imscp_v1p1"
MOMENT = (2001, 10, 29, 0, 0, 0)  # of all files in a package, so that equal items make an equal package


def exam_items() -> list[dict[str, Any]]:
    """Return the eight questions with their numbers filled in, the right answer of each first."""
    return items_with_facts(questions().item)


def gift(items: Sequence[dict[str, Any]]) -> str:
    """Return items as a file that Moodle imports as "GIFT format". Each answer has its reply as feedback, and each item
    its beliefs as tags."""
    parts = [f"// {TITLE}", f"$CATEGORY: {CATEGORY}"]
    for item in items:
        tags = " ".join(f"[tag:{answer['belief']}]" for answer in item["answers"] if answer["belief"])
        lines = [f"// [id:{item['id']}] {tags}", f"::{_gift(item['id'])}::[plain]{_gift(item['text'])} {{"]
        for answer in item["answers"]:
            mark = "=" if answer["right"] else "~"
            lines.append(f"\t{mark}{_gift(answer['text'])}#{_gift(_plain(answer['because']))}")
        parts.append("\n".join((*lines, "}")))
    return "\n\n".join(parts) + "\n"


def _gift(text: str) -> str:
    """Text with the characters escaped that GIFT gives a meaning."""
    return re.sub(r"([~=#{}:\\])", r"\\\1", text)


def _plain(text: str) -> str:
    return text.replace("**", "")


# One item: a choice of one answer, shuffled, that scores 1 for the right one, with the reply to each as feedback
ITEM = """<assessmentItem {root} identifier="viewimit-{id}" title="{title}" adaptive="false" timeDependent="false">
<responseDeclaration identifier="RESPONSE" cardinality="single" baseType="identifier">
<correctResponse><value>{right}</value></correctResponse></responseDeclaration>
<outcomeDeclaration identifier="SCORE" cardinality="single" baseType="float">
<defaultValue><value>0</value></defaultValue></outcomeDeclaration>
<outcomeDeclaration identifier="FEEDBACK" cardinality="single" baseType="identifier"/>
<itemBody><choiceInteraction responseIdentifier="RESPONSE" shuffle="true" maxChoices="1"><prompt>{text}</prompt>
{choices}</choiceInteraction></itemBody>
<responseProcessing><responseCondition><responseIf>
<match><variable identifier="RESPONSE"/><correct identifier="RESPONSE"/></match>
<setOutcomeValue identifier="SCORE"><baseValue baseType="float">1</baseValue></setOutcomeValue>
</responseIf></responseCondition>
<setOutcomeValue identifier="FEEDBACK"><variable identifier="RESPONSE"/></setOutcomeValue></responseProcessing>
{replies}</assessmentItem>"""
TEST = """<assessmentTest {root} identifier="viewimit-test" title="{title}">
<testPart identifier="part" navigationMode="nonlinear" submissionMode="simultaneous">
<assessmentSection identifier="section" title="{title}" visible="true">
{refs}</assessmentSection></testPart></assessmentTest>"""
MANIFEST = """<manifest {root} identifier="viewimit-manifest">
<metadata><schema>IMS Content</schema><schemaversion>1.1</schemaversion></metadata><organizations/>
<resources><resource identifier="test" type="imsqti_test_xmlv2p1" href="test.xml"><file href="test.xml"/>
{needs}</resource>
{files}</resources></manifest>"""


def qti_package(items: Sequence[dict[str, Any]]) -> bytes:
    """Return items as a zip file: an IMS content package of QTI 2.1 items and a test of all of them."""
    each = lambda form: "\n".join(form.format(id=item["id"]) for item in items)
    needs = each('<dependency identifierref="item-{id}"/>')
    hrefs = each(
        '<resource identifier="item-{id}" type="imsqti_item_xmlv2p1" href="items/{id}.xml">'
        '<file href="items/{id}.xml"/></resource>'
    )
    refs = each('<assessmentItemRef identifier="ref-{id}" href="items/{id}.xml"/>')
    files = {
        "imsmanifest.xml": MANIFEST.format(root=_root(PACKAGE, "imscp_v1p1"), needs=needs, files=hrefs),
        "test.xml": TEST.format(root=_root(QTI, "imsqti_v2p1"), title=TITLE, refs=refs),
        **{f"items/{item['id']}.xml": qti_item(item) for item in items},
    }
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as package:
        for name, text in files.items():
            package.writestr(zipfile.ZipInfo(name, MOMENT), text.encode(), zipfile.ZIP_DEFLATED)
    return out.getvalue()


def qti_item(item: dict[str, Any]) -> str:
    answers = {f"A{k}": answer for k, answer in enumerate(item["answers"], 1)}
    choice = '<simpleChoice identifier="{name}">{text}</simpleChoice>\n'
    reply = '<modalFeedback outcomeIdentifier="FEEDBACK" identifier="{name}" showHide="show">{text}</modalFeedback>\n'
    said = lambda form, key: "".join(
        form.format(name=name, text=escape(_plain(answers[name][key]))) for name in answers
    )
    return ITEM.format(
        root=_root(QTI, "imsqti_v2p1"), id=item["id"], title=item["id"].replace("-", " "), text=escape(item["text"]),
        right=next(name for name, answer in answers.items() if answer["right"]),
        choices=said(choice, "text"), replies=said(reply, "because"),
    )  # fmt: skip


def _root(namespace: str, schema: str) -> str:
    """The attributes of a file's root element."""
    where = f"{namespace} http://www.imsglobal.org/xsd/{schema}.xsd"
    instance = "http://www.w3.org/2001/XMLSchema-instance"
    return f'xmlns="{namespace}" xmlns:xsi="{instance}" xsi:schemaLocation="{where}"'
