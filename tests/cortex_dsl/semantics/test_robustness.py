"""No program is answered by a crash: mutants of good programs compile, or are refused with diagnostics."""

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.semantics.model import state
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from tests.laws import examples

GOOD = sorted((Path(__file__).parent / "golden" / "good").glob("*.scn"))
TEXTS = [path.read_text() for path in GOOD]
WORD = re.compile(r"[A-Za-z_][\w.]*|\d+(?:\.\d+)?(?: (?:km/h|m/s|m|s|deg))?|'[^']*'")
PIECES = """3 | 2 m | -1 | 0 | 1e308 | 'a' | None | True | [1, 2] | (1, 2) | lane | ego | self | intersection | network
| road | roadDirection | ManeuverType | ManeuverType.STRAIGHT | lane.centerline | lane.maneuvers | Range(0, 1)
| Uniform(1, 2) | Uniform('a', 'b') | DiscreteRange(0, 2) | Normal(0, 1) m | lambda x: x | FollowLaneBehavior
| FollowLaneBehavior() | SetBrakeAction(1) | {1: 2} | distance to ego | new Point at (1, 2) | none | Fixed(1, 2)
| globalParameters | Uniform() | Discrete({}) | ego.position | 1 @ 2 | not ego | 3 deg | Car | filter | sum([])
| max([]) | self.speed | network.lanes[0] | [*network.lanes] | intersection.maneuvers[0]""".replace("\n", " ").split(
    " | "
)


@pytest.fixture(autouse=True, scope="module")
def _little_patience() -> Iterator[None]:
    """Refuse endless files soon."""
    before, state.EVALUATION_LIMIT = state.EVALUATION_LIMIT, 20_000
    yield
    state.EVALUATION_LIMIT = before


@examples(150)
@given(
    st.sampled_from(TEXTS), st.lists(st.tuples(st.floats(0, 0.999), st.sampled_from(PIECES)), min_size=1, max_size=3)
)
def test_mutants_never_crash(text: str, changes: list[tuple[float, str]]) -> None:
    """Words replaced by others: a scenario or diagnostics, nothing else."""
    for where, piece in changes:
        words = list(WORD.finditer(text))
        word = words[int(where * len(words))]
        text = text[: word.start()] + piece + text[word.end() :]
    source = Source("mutant.scn", text)
    with contextlib.suppress(CompileError):
        elaborate(parse(source), source)
