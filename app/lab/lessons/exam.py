"""The eight questions as exam items: Moodle GIFT, and a package of IMS QTI 2.1 items.

GIFT: https://docs.moodle.org/en/GIFT_format. QTI: IMS Question and Test Interoperability 2.1 (2012), a content package
with one test and one file for each item.
"""

import io
import re
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Sequence
from typing import Any

from .source import questions
from .step_data import items_with_facts

CATEGORY = "viewimit/View-based imitation"
TITLE = "View-based imitation: eight questions"
QTI = "http://www.imsglobal.org/xsd/imsqti_v2p1"
PACKAGE = "http://www.imsglobal.org/xsd/imscp_v1p1"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
MOMENT = (2001, 10, 29, 0, 0, 0)  # of all files in a package, so that equal items make an equal package


def exam_items() -> list[dict[str, Any]]:
    """Return the eight questions with their numbers filled in, the right answer of each first."""
    return items_with_facts(questions().item)


def gift(items: Sequence[dict[str, Any]]) -> str:
    """Return items as a file that Moodle imports as "GIFT format".

    Each answer has its reply as feedback, and each item its beliefs as tags.
    """
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


def qti_package(items: Sequence[dict[str, Any]]) -> bytes:
    """Return items as a zip file: an IMS content package of QTI 2.1 items and a test of all of them."""
    files = {f"items/{item['id']}.xml": _xml(qti_item(item)) for item in items}
    files = {"imsmanifest.xml": _xml(_manifest(items)), "test.xml": _xml(_test(items)), **files}
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as package:
        for name, data in files.items():
            package.writestr(zipfile.ZipInfo(name, MOMENT), data, zipfile.ZIP_DEFLATED)
    return out.getvalue()


def qti_item(item: dict[str, Any]) -> ET.Element:
    """Return one item: a choice of one answer, shuffled, with the reply to each as feedback."""
    root = _element(QTI, "assessmentItem", identifier=f"viewimit-{item['id']}", title=item["id"].replace("-", " "))
    root.attrib |= {"adaptive": "false", "timeDependent": "false"}
    names = [f"A{k}" for k in range(1, len(item["answers"]) + 1)]
    right = names[next(k for k, answer in enumerate(item["answers"]) if answer["right"])]
    response = _add(root, "responseDeclaration", identifier="RESPONSE", cardinality="single", baseType="identifier")
    _add(_add(response, "correctResponse"), "value", right)
    score = _add(root, "outcomeDeclaration", identifier="SCORE", cardinality="single", baseType="float")
    _add(_add(score, "defaultValue"), "value", "0")
    _add(root, "outcomeDeclaration", identifier="FEEDBACK", cardinality="single", baseType="identifier")
    choice = _add(
        _add(root, "itemBody"), "choiceInteraction", responseIdentifier="RESPONSE", shuffle="true", maxChoices="1"
    )
    _add(choice, "prompt", item["text"])
    for name, answer in zip(names, item["answers"]):
        _add(choice, "simpleChoice", answer["text"], identifier=name)
    _add_processing(root)
    for name, answer in zip(names, item["answers"]):
        feedback = _add(root, "modalFeedback", outcomeIdentifier="FEEDBACK", identifier=name, showHide="show")
        feedback.text = _plain(answer["because"])
    return root


def _add_processing(root: ET.Element) -> None:
    """Score 1 for the right answer, and the feedback of the answer given."""
    processing = _add(root, "responseProcessing")
    chosen = _add(_add(processing, "responseCondition"), "responseIf")
    match = _add(chosen, "match")
    _add(match, "variable", identifier="RESPONSE")
    _add(match, "correct", identifier="RESPONSE")
    _add(_add(chosen, "setOutcomeValue", identifier="SCORE"), "baseValue", "1", baseType="float")
    _add(_add(processing, "setOutcomeValue", identifier="FEEDBACK"), "variable", identifier="RESPONSE")


def _test(items: Sequence[dict[str, Any]]) -> ET.Element:
    root = _element(QTI, "assessmentTest", identifier="viewimit-test", title=TITLE)
    part = _add(root, "testPart", identifier="part", navigationMode="nonlinear", submissionMode="simultaneous")
    section = _add(part, "assessmentSection", identifier="section", title=TITLE, visible="true")
    for item in items:
        _add(section, "assessmentItemRef", identifier=f"ref-{item['id']}", href=f"items/{item['id']}.xml")
    return root


def _manifest(items: Sequence[dict[str, Any]]) -> ET.Element:
    root = _element(PACKAGE, "manifest", identifier="viewimit-manifest")
    about = _add(root, "metadata")
    _add(about, "schema", "IMS Content")
    _add(about, "schemaversion", "1.1")
    _add(root, "organizations")
    resources = _add(root, "resources")
    test = _add(resources, "resource", identifier="test", type="imsqti_test_xmlv2p1", href="test.xml")
    _add(test, "file", href="test.xml")
    for item in items:
        _add(test, "dependency", identifierref=f"item-{item['id']}")
    for item in items:
        href = f"items/{item['id']}.xml"
        one = _add(resources, "resource", identifier=f"item-{item['id']}", type="imsqti_item_xmlv2p1", href=href)
        _add(one, "file", href=href)
    return root


def _element(namespace: str, name: str, **attributes: str) -> ET.Element:
    return ET.Element(f"{{{namespace}}}{name}", attributes)


def _add(parent: ET.Element, name: str, text: str | None = None, **attributes: str) -> ET.Element:
    """Append an element of the parent's namespace."""
    namespace = parent.tag[1:].partition("}")[0]
    element = ET.SubElement(parent, f"{{{namespace}}}{name}", attributes)
    element.text = text
    return element


def _xml(root: ET.Element) -> bytes:
    namespace = root.tag[1:].partition("}")[0]
    schema = {QTI: "imsqti_v2p1.xsd", PACKAGE: "imscp_v1p1.xsd"}[namespace]
    root.set(f"{{{XSI}}}schemaLocation", f"{namespace} http://www.imsglobal.org/xsd/{schema}")
    ET.register_namespace("", namespace)
    ET.register_namespace("xsi", XSI)
    ET.indent(root)
    return ET.tostring(root, "utf-8", xml_declaration=True)
