"""Markup: whatever text goes in, a parser gets the same text out, and no element that was not built."""

import json
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.report.page.markup import data_block, element, render, script

TEXTS = st.text(st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="\ufffe\uffff"), max_size=40)


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.found: list[str] = []
        self.attributes: list[dict[str, str | None]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append(tag)
        self.attributes.append(dict(attrs))

    def handle_data(self, data: str) -> None:
        self.text += data


def parsed(markup: str) -> Tags:
    tags = Tags()
    tags.feed(markup)
    tags.close()
    return tags


@given(TEXTS, TEXTS)
def test_text_and_attributes_survive(text: str, attribute: str) -> None:
    """Text and attribute come back as they were, and are all that there is."""
    tags = parsed(render(element("p", text, title=attribute)))
    assert tags.found == ["p"]
    assert tags.text == text
    assert tags.attributes == [{"title": attribute}]


@given(TEXTS)
def test_data_survives(text: str) -> None:
    """Data comes back as it was, and cannot end its element."""
    markup = render(data_block("name", {"text": text, "mean": "</script><!--"}))
    assert markup.lower().count("</script") == 1
    assert json.loads(parsed(markup).text) == {"text": text, "mean": "</script><!--"}


def test_scripts_cannot_end_themselves() -> None:
    """A script that holds its own end tag is refused."""
    with pytest.raises(ValueError, match="own end tag"):
        script("'</script>'")


def test_control_characters_are_shown() -> None:
    """What no document may hold becomes the replacement character."""
    assert render(element("p", "a\x00b\ud800")) == "<p>a\ufffdb\ufffd</p>"


def test_attributes_may_be_absent_or_bare() -> None:
    """None and False leave an attribute out, True writes it bare, underscores become hyphens."""
    made = element("input", value=None, checked=True, disabled=False, data_actor=3, class_="x")
    assert render(made) == '<input checked data-actor="3" class="x">'
