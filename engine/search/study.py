"""One call for a whole search of a compiled scenario."""

from collections.abc import Callable, Sequence

from engine.config import Config
from engine.program import Program
from engine.search.campaign import Campaign, OnGeneration, run_campaign
from engine.search.evaluations import Evaluations
from engine.search.protocol import Box
from engine.search.searchers import build_searcher, canonical, find_searcher
from engine.search.workers import Workers, open_workers, spread

DEFAULTS = Config()


def search(
    program: Program,
    method: str = "ga",
    config: Config = DEFAULTS,
    profile: str = "paper",
    on_generation: OnGeneration | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    past: Sequence[Evaluations] = (),
    spent: float = 0.0,
    workers: Workers | None = None,
) -> Campaign:
    """Search a program's box by a method of `searchers.known_searchers`, judged by a risk profile; see `run_campaign`.

    Without `workers`, threads of this process run the simulations, as many as the config says. Where they run changes
    no result.

    Raises:
        ValueError: an unknown method, engine, profile or aggregate, or settings out of range.
        MissingExtraError, PluginError: the method cannot be used.
        WorkersLostError: nobody is there to run simulations, or no longer.
    """
    method = canonical(method)
    searcher = build_searcher(method, Box.of(program.space), config)
    from engine.risk import PROFILES
    from engine.search.evaluator import make_evaluator

    if profile not in PROFILES:
        raise ValueError(f"profile: `{profile}` is none of {', '.join(PROFILES)}")
    entry = find_searcher(method)
    workers = workers or Workers("threads", config.search.jobs)
    with open_workers(workers) as executor:
        here = make_evaluator(program, config, PROFILES[profile])
        return run_campaign(
            program.space,
            searcher,
            spread(executor, workers, program, config, profile) if executor else here,
            config.search,
            entry.method,
            preset=entry.preset(config),
            on_generation=on_generation,
            should_stop=should_stop,
            past=past,
            spent=spent,
        )
