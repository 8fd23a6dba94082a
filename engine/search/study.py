"""One call for a whole search of a compiled scenario."""

from collections.abc import Callable, Sequence

from engine.config import Config
from engine.program import Program
from engine.search.campaign import Campaign, OnGeneration, run_campaign
from engine.search.evaluations import Evaluations
from engine.search.protocol import Box
from engine.search.searchers import SEARCHERS, build_searcher

DEFAULTS = Config()


def search(
    program: Program,
    method: str = "ga",
    config: Config = DEFAULTS,
    profile: str = "paper",
    on_generation: OnGeneration | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    past: Sequence[Evaluations] = (),
) -> Campaign:
    """Search a program's box by a method of `searchers.SEARCHERS`, judged by a risk profile; see `run_campaign`.

    Raises:
        ValueError: an unknown method, engine, profile or aggregate, or settings out of range.
    """
    searcher = build_searcher(method, Box.of(program.space), config)
    from engine.risk import PROFILES
    from engine.search.evaluator import make_evaluator

    if profile not in PROFILES:
        raise ValueError(f"profile: `{profile}` is none of {', '.join(PROFILES)}")
    evaluate = make_evaluator(program, config, PROFILES[profile])
    entry = SEARCHERS[method]
    return run_campaign(
        program.space,
        searcher,
        evaluate,
        config.search,
        entry.method,
        preset=entry.preset(config),
        on_generation=on_generation,
        should_stop=should_stop,
        past=past,
    )
