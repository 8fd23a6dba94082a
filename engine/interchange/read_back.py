"""Checks of exported files: their XML, and comparison with the run that they were written from."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from engine.errors import InterchangeError
from engine.interchange.contract import OURS, Finding
from engine.interchange.measuring import measure
from engine.interchange.recording import RecordedCase, Recording
from engine.outcomes import PAIRS, Outcomes
from engine.risk import PROFILES, assess
from engine.tables import SLIDING, Floats
from engine.vocabulary import State, Verdict

# -- XML of an export --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tree:
    """An XML file of an export, with the places of its elements in words."""

    name: str
    root: Element

    def find(self, tag: str) -> Element | None:
        return next(self.root.iter(tag), None)

    def finding(self, element: Element, reason: str, cure: str = "") -> Finding:
        called = element.get("name") or element.get("id") or ""
        return Finding(f"{self.name}, {element.tag} {called}".rstrip(), reason, cure)


def read_tree(path: Path) -> Tree:
    """Return a file that was just written, so that it needs no protection against hostile content."""
    return Tree(path.name, ElementTree.parse(path).getroot())  # noqa: S314


NEAR = 1e-3
"""A place that is read back may be so far off [m]; a heading [rad], a speed [m/s]."""
SAME = 1e-6
"""A metric may be so far off, of its size."""
METRICS = {row.symbol: row.name for row in PAIRS if row.of_risk}


def same_run(case: RecordedCase, read: Recording, name: str) -> Iterator[Finding]:
    """Check that all actors have equal states, and that metrics and risk are equal."""
    ours = case.replay
    if len(read.actors) != len(ours.actors):
        count = f"{len(ours.actors)} took part, {len(read.actors)} are read back"
        yield Finding(name, count, OURS)
        return
    for number, actor in enumerate(ours.actors):
        yield from _same_way(ours, read, number, f"{name}, {actor.name}")
    yield from _same_risk(case, read, name)


def _same_way(ours: Recording, read: Recording, actor: int, place: str) -> Iterator[Finding]:
    """Compare one actor's states at every sample of the run at which it is present.

    The speed at contact or after it, and of a sliding actor, has no unique meaning and is not compared.
    """
    scored = ours.scored_samples() - (0 if ours.contact is None else 1)
    slides = ours.states[:, actor, State.PRESENT] == SLIDING
    slides[1:] |= slides[:-1].copy()
    slides[:-1] |= slides[1:].copy()
    for what, column in (("place", State.X), ("place", State.Y), ("heading", State.HEADING), ("speed", State.SPEED)):
        for first, last in ours.stretches(actor):
            end = min(last + 1, scored) if what == "speed" else last + 1
            times, states = ours.time[first:end], ours.states[first:end, actor, column]
            off = np.abs(np.interp(times, *_course(read, actor, column)) - states)
            off = np.abs((off + np.pi) % (2 * np.pi) - np.pi) if what == "heading" else off
            off = np.where(slides[first:end], 0.0, off) if what == "speed" else off
            worst = int(off.argmax()) if len(off) else 0
            if len(off) and not off[worst] <= NEAR:
                yield Finding(place, f"the {what} at {times[worst]:.3f} s is {off[worst]:.3g} off", OURS)


def _course(read: Recording, actor: int, column: State) -> tuple[Floats, Floats]:
    there = read.there[:, actor]
    values = read.states[there, actor, column]
    return read.time[there], np.unwrap(values) if column == State.HEADING else values


def _same_risk(case: RecordedCase, read: Recording, name: str) -> Iterator[Finding]:
    """Compare the assessment of the recording with that of a valid run; a table takes the buildings of the run."""
    if case.outcomes.verdict[0] != Verdict.VALID:
        return
    try:
        known = read if read.buildings is not None else replace(read, buildings=case.recording.buildings)
        measured = measure(known, case.profile)
    except InterchangeError as error:
        yield Finding(name, error.message, error.cure)
        return
    pairs = [actor - 1 for actor in range(1, len(case.recording.actors)) if actor not in case.recording.never_there]
    yield from _same_metrics(case.outcomes, pairs, measured.outcomes, name)
    ours = assess(case.outcomes, PROFILES[case.profile])
    if int(ours.score[0]) != int(measured.risk.score[0]):
        yield Finding(name, f"the risk is {ours.score[0]}, read back {measured.risk.score[0]}", OURS)


def _same_metrics(ours: Outcomes, pairs: Sequence[int], read: Outcomes, name: str) -> Iterator[Finding]:
    """Compare metrics; `pairs` are the run's pairs in which both actors were present."""
    if bool(ours.collided[0]) != bool(read.collided[0]):
        yield Finding(name, "the run collided or not, read back it is otherwise", OURS)
    for metric, column in METRICS.items():
        one, other = getattr(ours, column)[0, pairs], getattr(read, column)[0]
        if not np.allclose(one, other, rtol=SAME, atol=SAME, equal_nan=True):
            yield Finding(name, f"{metric} is {_listed(one)}, read back {_listed(other)}", OURS)


def _listed(values: Floats) -> str:
    return ", ".join(f"{value:.6g}" for value in values.tolist())
