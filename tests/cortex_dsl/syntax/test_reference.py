"""The reference says what is so: every block on its pages is read, and every wrong one has the error it names."""

import re
from itertools import chain
from pathlib import Path

import pytest

from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.pipeline import compile_source
from cortex_dsl.semantics.acting.statements import SETTINGS
from cortex_dsl.semantics.evaluation.attributes import attribute_names
from cortex_dsl.semantics.evaluation.functions import RANGE_LIMIT
from cortex_dsl.semantics.evaluation.maps import MAP_ARGUMENTS
from cortex_dsl.semantics.model import state
from cortex_dsl.semantics.model.choices import VARIANT_LIMIT
from cortex_dsl.semantics.model.state import CALL_LIMIT, EVALUATION_LIMIT, REPETITION_LIMIT
from cortex_dsl.semantics.names.builtins import Kind, names_of
from cortex_dsl.semantics.names.properties import CLASSES, ENVIRONMENT, all_properties
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.errors import MAX_BYTES, MAX_DEPTH, MAX_ERRORS
from cortex_dsl.syntax.literals import UNITS
from cortex_dsl.syntax.words import KEYWORDS, RESERVED, Keyword
from docs.builder.site import LANGUAGE
from engine.config import SimulationConfig
from engine.host import MAX_SAMPLES
from engine.road.specification import MAX_INTERSECTIONS
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, EndReason, Verdict

DOCS = Path(__file__).parents[3] / "docs"
PAGES = {name: (DOCS / name).read_text(encoding="utf-8") for name in LANGUAGE}
REFERENCE = "\n".join(PAGES.values())
BLOCK = re.compile(r"^```(?P<kind>\S+) ?(?P<code>\w*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
BLOCKS = [
    (f"{Path(name).name}:{page.count(chr(10), 0, match.start()) + 1}", match["kind"], match["code"], match["text"])
    for name, page in PAGES.items()
    for match in BLOCK.finditer(page)
]


def test_pages_can_be_read() -> None:
    """Each page has at most 250 lines and a line in the list of pages."""
    listed = re.findall(r"^\| \[.*?\]\((language/.*?)\)", PAGES[LANGUAGE[0]], re.MULTILINE)
    assert [f"reference/{name}" for name in listed] == [*LANGUAGE[1:]]
    assert {name: lines for name, page in PAGES.items() if (lines := page.count("\n")) > 250} == {}


@pytest.mark.parametrize(("place", "kind", "code", "text"), BLOCKS)
def test_block(place: str, kind: str, code: str, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A block is a piece of a program, a whole one, or has exactly the error that it is marked with."""
    source = Source(place, text)
    if code == "whole":
        assert not compile_source(source).diagnostics
        return
    if kind == "scn":
        parse(source)
        return
    assert kind == "scn-error"
    monkeypatch.setattr(state, "EVALUATION_LIMIT", 20_000)  # what would take too long is refused sooner here
    with pytest.raises(CompileError) as caught:
        compile_source(source) if code >= "SCN2" else parse(source)
    assert [d.code for d in caught.value.diagnostics if d.severity is Severity.ERROR] == [code]


def test_tables_and_lists_are_complete() -> None:
    """Units, reserved words and limits on the pages are those of the program."""
    for dimension, words in UNITS.items():
        assert f"| {dimension} | " + " ".join(f"`{word}`" for word in words) + " |" in REFERENCE
    listed = re.search(r"never names: `(.*?)`", REFERENCE, re.DOTALL)
    assert listed is not None
    assert set(listed[1].split()) == RESERVED
    assert f"at most {MAX_BYTES >> 10} KiB long" in REFERENCE
    assert f"nest at most {MAX_DEPTH} deep. After {MAX_ERRORS} errors" in REFERENCE
    limits = REFERENCE.partition("## Limits")[2]
    evaluation = CALL_LIMIT, EVALUATION_LIMIT, REPETITION_LIMIT
    for limit in (VARIANT_LIMIT, MAX_INTERSECTIONS, RANGE_LIMIT, *evaluation, MAX_SAMPLES):
        assert re.search(rf"\b{limit:,}\b", limits), limit
    assert f"{SimulationConfig().instruction_budget:,} instructions" in " ".join(limits.split())


@pytest.mark.parametrize("keyword", KEYWORDS, ids=lambda keyword: keyword.phrase)
def test_every_keyword_is_used(keyword: Keyword) -> None:
    """In the words of a table or in a block, so that its construct is there."""
    assert re.search(r"\b" + r"\s+".join(keyword.words) + r"\b", REFERENCE)


@pytest.mark.parametrize("kind", [Verdict, EndReason])
def test_how_a_run_can_end(kind: type[Verdict] | type[EndReason]) -> None:
    """Each verdict and each end has a row, and no other has; that of a contact of two others is only reserved."""
    heading = {Verdict: "# The verdict\n", EndReason: "# The end\n"}[kind]
    section = REFERENCE.partition(heading)[2].partition("\n#")[0]
    assert re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE) == [
        member.name.lower() for member in kind if member is not EndReason.OTHER_COLLISION
    ]


def test_every_class_is_named() -> None:
    """Those of roads, those of Scenic's props, and places."""
    section = PAGES["reference/language/objects.md"].partition("## Specifiers")[0]
    assert set(CLASSES) <= set(re.findall(r"`(\w+)`", section))


@pytest.mark.parametrize("kind", list(Kind))
def test_every_built_in_name_is_explained(kind: Kind) -> None:
    """The pages name all there is."""
    assert not [name for name in names_of(kind) if not re.search(rf"`{name}\b", REFERENCE)]


def test_every_property_argument_and_attribute_is_explained() -> None:
    """Properties of objects, arguments of `map` and `simulation`, attributes of everything."""
    names = {
        *all_properties(),
        *ENVIRONMENT,
        *chain.from_iterable(MAP_ARGUMENTS.values()),
        *SETTINGS,
        *attribute_names(),
    }
    assert not [name for name in sorted(names) if f"`{name}`" not in REFERENCE]


@pytest.mark.parametrize("kind", list(ActorKind))
def test_sizes_are_those_of_the_models(kind: ActorKind) -> None:
    """The table of classes gives what `engine.vehicles` says."""
    model, name = MODELS[kind], kind.name.title()
    row = (
        f"| `{name}` | {model.length:g} x {model.width:g} m | {model.mass / 1000:g} t "
        f"| {model.max_acceleration:g} m/s² | {model.max_braking:g} m/s² | {model.top_speed * 3.6:.0f} km/h |"
    )
    assert row in REFERENCE
