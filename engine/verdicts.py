"""Verdicts on collisions by a set of reference drivers: all, some or none of them avoid a collision.

Each driver of `engine.references` drives a collision once (`engine.kernels.references`). A driver whose range does not
cover a collision is not counted. Being struck from behind, or while standing where standing is permitted, is no failure
of the ego (`engine.kernels.fault`): such a collision is apart.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from engine.assessment import take
from engine.avoidability import R157, drive_memory
from engine.config import DEFAULT_REFERENCES, ContactConfig, SimulationConfig
from engine.counterfactuals import Counterfactuals, counterfactuals
from engine.dependence import ignores_ego
from engine.host import in_parts, plan, requested, samples_of
from engine.kernels.references import verdict_rows
from engine.kernels.rows import Window
from engine.program import Program
from engine.references import references as drivers_of
from engine.references import rows_of, verdicts
from engine.scenes import Scenes, weather_sight
from engine.tables import Floats, Ints
from engine.vocabulary import Answer, Blame

DEFAULTS = SimulationConfig()
CONTACT = ContactConfig()


@dataclass(frozen=True)
class JudgedCollision:
    """One collision with all that the reference drivers say."""

    verdict: Blame
    answers: Mapping[str, Answer]
    """Answer of each driver, by its name."""
    counterfactuals: Counterfactuals | None
    """None if the ego was struck."""


class KnownVerdicts:
    """Verdicts of one program and one set of reference drivers, so that no scene is driven twice."""

    def __init__(self) -> None:
        self._of_scene: dict[bytes, int] = {}

    def keep(self, scenes: Scenes, verdicts: Ints) -> None:
        """Add the verdicts (n,) on scenes."""
        self._of_scene.update(zip(_identities(scenes), verdicts.tolist(), strict=True))

    def of(self, scenes: Scenes) -> Ints:
        """Return (n,) the verdicts on scenes; `UNKNOWN` where there is none."""
        return np.array([self._of_scene.get(each, UNKNOWN) for each in _identities(scenes)], dtype=np.int32)


UNKNOWN = -2
"""No verdict."""


def _identities(scenes: Scenes) -> list[bytes]:
    """Return the identity of each scene: its key, its variant, its values and its decisions determine its run."""
    decided = scenes.actions if len(scenes.actions) else np.zeros((len(scenes), 0))
    rows = zip(scenes.keys, scenes.variant.tolist(), scenes.values, decided, strict=True)
    return [
        b"".join((key.tobytes(), variant.to_bytes(8, "big", signed=True), values.tobytes(), actions.tobytes()))
        for key, variant, values, actions in rows
    ]


def answers_and_margins(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    contact: ContactConfig = CONTACT,
    jobs: int = 1,
    references: Sequence[str] = DEFAULT_REFERENCES,
    *,
    measured: bool = True,
) -> tuple[Ints, Floats]:
    """Return (n, drivers) the `Answer` of each reference driver, and (n,) the margin of the careful driver [s].

    The margin is that of `Avoidability`, at most `MOST_MARGIN`, and found in few drives; NaN where drivers disagree,
    where nothing is perceived, or if it is not `measured`.
    """
    shared, rows = plan(program, config, contact), requested(program, scenes)
    reach, independent = weather_sight(program, scenes.variant, scenes.values), ignores_ego(program)
    models = rows_of(references)
    answers = np.full((len(scenes), len(models)), int(Answer.NONE), dtype=np.int32)
    margins = np.full(len(scenes) if measured else 0, np.nan)

    def drive(window: Window) -> None:
        samples = samples_of(config) + 1
        stored = samples if not independent and (measured or len(models) > 1) else 0
        scratch = drive_memory(program, config, samples, independent=independent, stored=stored, models=len(models))
        verdict_rows(shared, rows, reach, window, scratch, R157, models, answers, margins)

    in_parts(len(scenes), jobs, drive)
    return answers, margins


def blame(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    contact: ContactConfig = CONTACT,
    jobs: int = 1,
    references: Sequence[str] = DEFAULT_REFERENCES,
    known: KnownVerdicts | None = None,
) -> Ints:
    """Return (n,) `Blame` of each scene; `NONE` for a scene that is invalid or without a collision of the ego.

    Scenes with a `known` verdict are not driven.
    """
    said = np.full(len(scenes), UNKNOWN, dtype=np.int32) if known is None else known.of(scenes)
    rows = np.flatnonzero(said == UNKNOWN)
    if len(rows):
        left = take(scenes, rows)
        said[rows] = verdicts(answers_and_margins(program, left, config, contact, jobs, references, measured=False)[0])
    return said


def judge(
    program: Program,
    scenes: Scenes,
    config: SimulationConfig = DEFAULTS,
    contact: ContactConfig = CONTACT,
    jobs: int = 1,
    references: Sequence[str] = DEFAULT_REFERENCES,
) -> tuple[JudgedCollision | None, ...]:
    """Return the answers of the reference drivers to each scene, and its counterfactuals; None without a collision."""
    answers, _ = answers_and_margins(program, scenes, config, contact, jobs, references, measured=False)
    others = counterfactuals(program, scenes, config, contact, jobs)
    names = [each.name for each in drivers_of(references)]
    rows = zip(verdicts(answers).tolist(), answers.tolist(), others, strict=True)
    return tuple(
        None
        if said == Blame.NONE
        else JudgedCollision(Blame(said), dict(zip(names, map(Answer, row), strict=True)), other)
        for said, row, other in rows
    )
