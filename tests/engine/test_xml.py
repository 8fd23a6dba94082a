"""The reader of XML refuses what could harm, and says where and why; the writer refuses what XML cannot hold."""

import os
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from engine.interchange import InterchangeError
from engine.interchange.xml_writing import Element, child, xml_text
from engine.xml import Limits, read_xml


def failure(path: Path, limits: Limits | None = None) -> InterchangeError:
    with pytest.raises(InterchangeError) as caught:
        read_xml(path, "OpenSCENARIO", limits or Limits())
    assert caught.value.place
    assert caught.value.cure
    return caught.value


def failure_of(folder: Path, content: str | bytes, limits: Limits | None = None) -> InterchangeError:
    path = folder / "case.xosc"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return failure(path, limits)


def test_elements_remember_their_line(tmp_path: Path) -> None:
    """The line is that of the element's own tag, and the tree is that of the file."""
    path = tmp_path / "case.xosc"
    path.write_text('<OpenSCENARIO>\n <A x="1"/>\n\n <B><C/></B>\n</OpenSCENARIO>')
    root = read_xml(path, "OpenSCENARIO")
    assert [(node.tag, node.line) for node in root.walk()] == [("OpenSCENARIO", 1), ("A", 2), ("B", 4), ("C", 4)]
    assert root.need("A").place == "case.xosc, line 2"
    assert root.need("A").number("x") == 1.0


def test_a_bomb_of_entities_is_refused_at_its_declaration(tmp_path: Path) -> None:
    """Nothing is expanded, whatever the entities would have come to."""
    tens = {i: f"&a{i - 1};" * 10 for i in range(1, 12)}
    layers = "".join(f'<!ENTITY a{i} "{ten}">' for i, ten in tens.items())
    error = failure_of(tmp_path, f'<!DOCTYPE x [<!ENTITY a0 "ha">{layers}]>\n<OpenSCENARIO>&a11;</OpenSCENARIO>')
    assert "document type" in error.message
    assert error.place == "case.xosc, line 1"


@pytest.mark.parametrize("kind", ["SYSTEM", 'PUBLIC "x"'])
def test_a_local_file_is_not_taken_in(tmp_path: Path, kind: str) -> None:
    """The content of a file that an entity names reaches nobody."""
    (tmp_path / "secret.txt").write_text("hunter2")
    name = (tmp_path / "secret.txt").as_uri()
    text = f'<!DOCTYPE x [<!ENTITY a {kind} "{name}">]><OpenSCENARIO x="b">&a;</OpenSCENARIO>'
    error = failure_of(tmp_path, text)
    assert "hunter2" not in str(error)
    assert "document type" in error.message


@pytest.mark.parametrize("text", ['<!DOCTYPE x SYSTEM "http://example.com/x.dtd"><OpenSCENARIO/>', "<!DOCTYPE x><y/>"])
def test_no_document_type_is_read(tmp_path: Path, text: str) -> None:
    """Neither here nor elsewhere, so that nothing is fetched."""
    assert "never read" in failure_of(tmp_path, text).message


def test_broken_xml_has_line_and_column(tmp_path: Path) -> None:
    """The place is where the parser stopped."""
    error = failure_of(tmp_path, "<OpenSCENARIO>\n  <A></B>\n</OpenSCENARIO>")
    assert error.place == "case.xosc, line 2, column 8"
    assert "mismatched tag" in error.message


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "empty"),
        (b"   \n", "not well-formed"),
        (b"PK\x03\x04rest", "zip archive"),
        (b"\x1f\x8b\x08rest", "gzip"),
        (bytes(range(256)), "not well-formed"),
        (b"\x00" * 1000, "not well-formed"),
        (b"<OpenSCENARIO>\xff\xfe</OpenSCENARIO>", "not well-formed"),
        (b'<?xml version="1.0" encoding="klingon"?><OpenSCENARIO/>', "encoding"),
        (b'<?xml version="1.0" encoding="shift_jis"?><OpenSCENARIO/>', "encoding"),
        (b"<OpenSCENARIO>", "no element found"),
        (b"<OpenSCENARIO/><OpenSCENARIO/>", "junk"),
        (b'<OpenSCENARIO a="1" a="2"/>', "duplicate attribute"),
        (b"hello", "not well-formed"),
    ],
)
def test_what_is_no_xml_is_refused_with_the_reason(tmp_path: Path, content: bytes, said: str) -> None:
    """Empty, binary, cut short, in an unknown encoding, or plain text."""
    assert said in failure_of(tmp_path, content).message


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1", "cp1252"])
def test_common_encodings_are_read(tmp_path: Path, encoding: str) -> None:
    """With a declaration, or a byte order mark."""
    declared = encoding.removesuffix("-sig")
    text = f'<?xml version="1.0" encoding="{declared}"?><OpenSCENARIO name="Straße"/>'
    (tmp_path / "case.xosc").write_bytes(text.encode(encoding))
    assert read_xml(tmp_path / "case.xosc", "OpenSCENARIO").text("name") == "Straße"


@pytest.mark.parametrize(
    ("root", "said"),
    [("OpenDRIVE", "an OpenDRIVE road"), ("commonRoad", "CommonRoad"), ("html", "a web page"), ("x", "another kind")],
)
def test_another_root_is_named(tmp_path: Path, root: str, said: str) -> None:
    """With the file that is wanted instead."""
    error = failure_of(tmp_path, f"<{root}/>")
    assert said in error.message
    assert ".xosc" in error.cure


def test_a_file_that_is_too_large_is_refused_early(tmp_path: Path) -> None:
    """A sparse file of a gigabyte costs as much as the limit, and the error says the limit."""
    path = tmp_path / "case.xosc"
    path.write_bytes(b"<OpenSCENARIO>" + b" " * 70_000)
    os.truncate(path, 1_000_000_000)
    assert "larger than 0.06 MB" in failure(path, Limits(megabytes=0.06)).message
    assert "not well-formed" in failure(path).message


def test_a_generated_file_is_refused_at_its_limits(tmp_path: Path) -> None:
    """Elements and depth are counted while reading."""
    assert "more than 100 elements" in failure_of(tmp_path, "<a>" + "<b/>" * 200, Limits(elements=100)).message
    error = failure_of(tmp_path, "<a>\n" * 100_000)
    assert "64 deep" in error.message
    assert error.place == "case.xosc, line 65"


def test_attributes_are_counted(tmp_path: Path) -> None:
    """In one element, and in all of them."""
    many = " ".join(f'a{i}=""' for i in range(51))
    assert "has 51 attributes" in failure_of(tmp_path, f"<OpenSCENARIO {many}/>").message
    text = "<OpenSCENARIO>" + '<a b="" c=""/>' * 6 + "</OpenSCENARIO>"
    assert "more than 10 attributes" in failure_of(tmp_path, text, Limits(all_attributes=10)).message


@pytest.mark.parametrize("content", ['<OpenSCENARIO a="', "<OpenSCENARIO><!--"])
def test_a_tag_without_an_end_is_not_held_in_memory(tmp_path: Path, content: str) -> None:
    """However large the file may be, one tag or comment may not fill it."""
    error = failure_of(tmp_path, content + "x" * 12_000_001)
    assert "one tag or comment is longer than 12 MB" in error.message
    assert error.cure == "shorten it, or take it out"


def test_too_large_a_map_is_not_told_of_actors(tmp_path: Path) -> None:
    path = tmp_path / "town.xodr"
    path.write_text("<OpenDRIVE>" + "<road/>" * 20 + "</OpenDRIVE>")
    with pytest.raises(InterchangeError, match="more than 10 elements") as caught:
        read_xml(path, "OpenDRIVE", Limits(elements=10))
    assert caught.value.cure == "cut the map down to the roads that are needed"


def test_folders_devices_and_absent_files_are_reported(tmp_path: Path) -> None:
    """Nothing that is no regular file is opened: a pipe would never end."""
    assert "folder" in failure(tmp_path).message
    os.mkfifo(tmp_path / "pipe")
    assert "regular file" in failure(tmp_path / "pipe").message
    assert "no such file" in failure(tmp_path / "absent.xosc").message
    assert "no such file" in failure(tmp_path / "pipe" / "absent.xosc").message
    assert "cannot be read" in failure(tmp_path / ("x" * 300)).message


# -- written ----------------------------------------------------------------------------------------------------------


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
    child = ElementTree.fromstring(written(text)).find("b")
    assert child is not None
    assert child.get("name") == text
