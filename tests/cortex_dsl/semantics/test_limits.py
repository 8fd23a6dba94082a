"""Loops over constants are refused soon: by what they cost, whatever they repeat."""

import pytest

from cortex_dsl import CompileError, compile_text
from cortex_dsl.semantics.model import state
from cortex_dsl.semantics.model.state import REPETITION_LIMIT

TWICE = "for a in range(9999) for b in range(9999)"
LOOPS = {
    "list": f"n = len([a + b {TWICE}])",
    "loop": "n = 0\nfor a in range(9999):\n    for b in range(9999):\n        n = n + 1",
    "while": "n = 0\nwhile n < 90000000:\n    n = n + 1",
    "lambda": "n = sum(map(lambda a: sum(map(lambda b: a * b, range(9999))), range(9999)))",
    "filter": "n = [filter(lambda b: b > a, range(9999)) for a in range(9999)]",
    "function": f"def f(a):\n    return a + 1\nn = [f(a) {TWICE}]",
    "any": f"n = any([a + b < 0 {TWICE}])",
    "range": "n = [range(9999) for a in range(9999)]",
    "text": f"n = [f'{{a}}' {TWICE}]",
    "choice": f"n = [Discrete({{1: 1, 2: 1}}) {TWICE}]",
    "draw": f"n = [Range(0, 1) {TWICE}]",
    "place": f"n = [new Point at (a, b) {TWICE}]",
    "object": f"n = [new Car at (a, b) {TWICE}]",
    "region": f"n = [CircularRegion((a, b), 3) {TWICE}]",
    "lane": "n = [lane.centerline for a in range(9999) for lane in network.lanes]",
}


@pytest.mark.parametrize("loop", LOOPS)
def test_a_loop_without_end_is_refused(loop: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within a second each, which is counted in evaluations, so that a file compiles everywhere or nowhere. All but one
    meet a tenth of the limit.
    """
    limit = REPETITION_LIMIT if loop == "list" else REPETITION_LIMIT // 10
    monkeypatch.setattr(state, "REPETITION_LIMIT", limit)
    with pytest.raises(CompileError) as error:
        compile_text(f"map intersection()\nego = new Car at (0, 0)\n{LOOPS[loop]}\n")
    assert error.value.message.startswith("SCN434")
    assert f"{limit:,}" in str(error.value)


def test_many_variants_may_evaluate_more_than_one() -> None:
    """The limit of one variant is not that of a file: here 64 variants take some 4,000 each."""
    maneuvers = "".join(f"m{number} = Uniform(*intersection.maneuvers[:8])\n" for number in range(2))
    work = "n = len([a + a for a in range(1000)])\n"
    assert compile_text(
        f"map intersection()\n{maneuvers}{work}ego = new Car on m0.startLane\nb = new Car on m1.startLane\n"
    ).program
