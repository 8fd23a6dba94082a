"""The table of likely mistakes: every row is answered as it says, by its own rule."""

import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.explain.table import MISTAKES, Mistake, explain


@pytest.mark.parametrize("row", MISTAKES, ids=lambda row: row.rule.__name__)
def test_a_row_is_answered_by_its_own_rule(row: Mistake, monkeypatch: pytest.MonkeyPatch) -> None:
    """No earlier rule takes what people write in a row, and the diagnostic has the row's code."""
    answers: list[tuple[Mistake, str]] = []

    def recorded(each: Mistake) -> Mistake:
        def rule(context):
            diagnostic = each.rule(context)
            if diagnostic is not None:
                answers.append((each, diagnostic.code))
            return diagnostic

        return Mistake(each.written, each.code, rule)

    monkeypatch.setitem(explain.__globals__, "MISTAKES", tuple(map(recorded, MISTAKES)))
    with pytest.raises(CompileError):
        parse(Source("mistake.scn", row.written + "\n"))
    assert [(each.rule.__name__, code) for each, code in answers[:1]] == [(row.rule.__name__, row.code)]
