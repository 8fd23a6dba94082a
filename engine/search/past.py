"""Repetition of a search from its journal: a new searcher gets the stored results and must make the stored proposals.

The driver of the search drives again, or its recorded decisions do.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from engine.config import ActorDriver
from engine.errors import CortexError
from engine.search.evaluations import (
    Evaluations,
    parent_rows,
    results,
)
from engine.search.manifest import DrivenBy
from engine.search.protocol import Proposal, Searcher
from engine.search.store import StoreError
from engine.tables import Floats

if TYPE_CHECKING:
    from engine.driving.decisions import RecordedActions

OTHER = "bring it back as it was, or start a new search with the driver as it is"


class ForeignPastError(CortexError):
    """The searcher does not propose a journal's generation: its settings, or the version, differ."""

    def __init__(self, generation: int) -> None:
        super().__init__(
            f"generation {generation} does not follow from the ones before it",
            "use the version of cortexc that wrote it, or search again",
        )
        self.generation = generation


def follow(searcher: Searcher, past: Sequence[Evaluations]) -> None:
    """Pass all stored results to a new searcher, without a simulation.

    Raises:
        ForeignPastError: its proposals differ from those of `past`, in genomes, operators or parents.
    """
    for generation, evaluations in enumerate(past):
        searcher.tell(results(checked(searcher.ask(), evaluations, generation)))


def checked(proposals: Sequence[Proposal], evaluations: Evaluations, generation: int) -> Evaluations:
    """Return a generation of the past, after checking that these proposals led to it."""
    genomes = np.array([proposal.genome for proposal in proposals], dtype=np.float64).reshape(len(proposals), -1)
    same = genomes.tobytes() == evaluations.genomes.tobytes() and all(
        np.array_equal(asked, written)
        for asked, written in (
            ([proposal.birth for proposal in proposals], evaluations.births),
            ([proposal.operator for proposal in proposals], evaluations.operator),
            ([proposal.reused is not None for proposal in proposals], evaluations.reused),
            (parent_rows(proposals), evaluations.parents),
        )
    )
    if not same:
        raise ForeignPastError(generation)
    return evaluations


def recorded_driver(driven: DrivenBy | ActorDriver, actions: Mapping[bytes, Floats] | None = None) -> "RecordedActions":
    """Return a driver that repeats recorded decisions, under the name of the driver that made them."""
    from engine.driving.decisions import RecordedActions

    return RecordedActions({} if actions is None else actions, driven.name, driven.digest, driven.block, driven.observe)


def who_drove(
    folder: Path, driven: DrivenBy | ActorDriver | None, actions: Mapping[bytes, Floats], ego: object
) -> ActorDriver | None:
    """Return the driver of a repeated run: the named driver if it drove then, else its recorded decisions.

    A name in a journal is never used to load a controller.

    Raises:
        StoreError: a different driver drove in the run, or none.
    """
    if driven is None:
        if ego is not None:
            raise StoreError(f"no controller drove in `{folder}`", "leave `--ego` out")
        return None
    from engine.driving.named import driver_of

    driver = driver_of(ego, driven.block, driven.observe)
    if driver is None:
        return recorded_driver(driven, actions)
    if driver.name != driven.name:
        raise StoreError(f"`{driven.name}` drove in `{folder}`, not `{driver.name}`", OTHER)
    if driver.digest != driven.digest:
        raise StoreError(f"the file of `{driver.name}` is not what it was when it drove in `{folder}`", OTHER)
    for what, was, now in (
        ("batch", driven.block, driver.block),
        ("observes", driven.observe, driver.observe),
    ):
        if was != now:
            raise StoreError(f"`{driver.name}` drove in `{folder}` with --ego-{what} {was}, not {now}", OTHER)
    return driver
