"""What cannot stand in XML is refused by its escape, and what can is written."""

import re
from xml.etree import ElementTree

import pytest

from engine.interchange import InterchangeError
from engine.interchange.xml_text import Element, child, xml_text


def written(text: str) -> str:
    root = Element("a")
    child(root, "b", name=text)
    return xml_text(root)


@pytest.mark.parametrize("code", [0, 8, 0x1F, 0xFFFE, 0xFFFF, 0xD800, 0xDFFF])
def test_characters_that_xml_cannot_hold_are_refused(code: int) -> None:
    """Controls, the two that are no characters, and halves of a pair."""
    with pytest.raises(InterchangeError, match=re.escape(repr(chr(code)))):
        written(f"VUT{chr(code)}")


def test_all_others_come_back() -> None:
    """Line ends and tabs, what lies at the edges, and what needs two halves."""
    text = "\t\n\r \x7f\x85\ud7ff\ue000\ufffd\U00010000\U0010ffff<&>\"'"
    assert ElementTree.fromstring(written(text)).find("b").get("name") == text
