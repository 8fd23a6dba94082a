"""Progress of long commands: an estimate after the first runs, and lines where there is no terminal."""

import io
import re
from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from cortex_dsl.report.terminal import progress
from cortex_dsl.report.terminal.progress import LONG, Estimate, SearchProgress, count_line, measured
from cortex_dsl.report.terminal.theme import THEME
from engine.run_count import report_runs


class _Clock:
    """A clock that a test sets [s]."""

    now = 0.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> _Clock:
    found = _Clock()
    monkeypatch.setattr(progress, "time", found)
    return found


@given(
    loading=st.floats(0.0, 300.0),
    each=st.floats(1e-4, 20.0),
    batch=st.integers(1, 500),
    batches=st.integers(3, 400),
)
def test_an_estimate_is_the_time_of_an_even_work(loading: float, each: float, batch: int, batches: int) -> None:
    """Runs of one cost give the time of the whole, whatever is loaded first; once, and only where much is left."""
    clock, stream, total = _Clock(), io.StringIO(), batch * batches
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(progress, "time", clock)
        estimate = Estimate(Console(file=stream, theme=THEME, width=20), started=0.0)
        clock.now = loading
        for done in range(batch, total + 1, batch):
            clock.now += each * batch
            estimate.update(done, total - done)
    whole, lines = loading + each * total, stream.getvalue().splitlines()
    left = each * (total - 2 * batch)  # the first results are not measured, the next ones are
    if left < 0.99 * LONG:
        assert lines == []
    for line in lines:
        cost, said = re.fullmatch(r"about (.*) a run, about (.*) in all", line).groups()  # type: ignore[union-attr]
        assert seconds_of(said) >= 0.94 * whole - 0.1
        assert seconds_of(said) <= 1.06 * whole + 0.1
        assert seconds_of(cost) >= 0.94 * each
    assert len(lines) <= 1
    if left > 1.01 * LONG and batch >= 50:
        assert len(lines) == 1


def seconds_of(text: str) -> float:
    units = {"ms": 0.001, "s": 1.0, "min": 60.0, "h": 3600.0}
    return sum(float(number) * units[unit] for number, unit in re.findall(r"([\d.]+) (\w+)", text))


def test_runs_of_unknown_number_have_no_estimate(clock: _Clock) -> None:
    """Subset simulation does not know its levels, so it promises no end."""
    stream = io.StringIO()
    with measured(Console(file=stream, theme=THEME), None):
        for now in range(0, 1000, 100):
            clock.now = float(now)
            report_runs(100)
    assert stream.getvalue() == ""
    assert count_line(300, None, "runs", 45.0).plain == "300 runs, 45 s so far"
    assert count_line(300, 900, "runs", 45.0).plain == "300 of 900 runs, 1 min 30 s left"
    assert count_line(0, 900, "runs", 45.0).plain == "0 of 900 runs, 45 s so far"


def test_reported_runs_are_counted_within_the_block_only(clock: _Clock) -> None:
    """A listener hears of runs of its own block, and the estimate follows from them."""
    stream = io.StringIO()
    report_runs(10_000)
    with measured(Console(file=stream, theme=THEME), 3000):
        for now in (1.0, 2.0, 3.0):
            clock.now = now
            report_runs(100)
    assert stream.getvalue() == "about 10 ms a run, about 30 s in all\n"
    report_runs(10_000)


def test_the_runs_of_a_journal_are_no_measure(clock: _Clock) -> None:
    """A resumed search lets its method propose the past again; only the runs that follow tell what a run costs."""
    stream, figures = io.StringIO(), cast("Any", SimpleNamespace(individuals=100))
    shown = SearchProgress(Console(file=stream, theme=THEME), "ga", 100, figures=[figures] * 9, started=0.0)
    shown.estimate.started = 0.0
    for clock.now in (100.0, 101.0, 102.0):
        shown.generation_done(figures, 1000, 0.0)
    assert stream.getvalue() == "about 10 ms a run, about 1 min 30 s for the rest\n"
