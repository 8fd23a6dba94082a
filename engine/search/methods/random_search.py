"""The random baseline: independent uniform draws over the box, as many as the search it stands beside."""

from collections.abc import Sequence

from engine.search.methods.operators import draw_genome
from engine.search.protocol import Birth, Box, Operator, Proposal, Result, StreamAt, check_answer


class RandomSearch:
    """Learns nothing: valid, invalid and failed results alike leave it as it was."""

    def __init__(self, box: Box, population: int, streams: StreamAt) -> None:
        self._box = box
        self._population = population
        self._streams = streams
        self._generation = -1
        self._asked: list[Proposal] = []

    def ask(self) -> list[Proposal]:
        self._generation += 1
        births = [Birth(self._generation, slot) for slot in range(self._population)]
        self._asked = [
            Proposal(draw_genome(self._streams(*birth), self._box), Operator.RANDOM, birth) for birth in births
        ]
        return self._asked

    def tell(self, results: Sequence[Result]) -> None:
        check_answer(self._asked, results)
