"""The one scene of a file for commands beside `cortexc FILE` that show it otherwise: drawn as that draws it."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cortex_dsl.cli.compiling import compile_request
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.parser import build_parser, to_request
from cortex_dsl.cli.request import Request
from cortex_dsl.cli.terminal import Terminal

if TYPE_CHECKING:
    from cortex_dsl.api.scenario import Scenario
    from engine.scenes import Scenes


@dataclass(frozen=True)
class DrawnScene:
    """A valid scene, row 0, and what it was drawn from."""

    request: Request
    scenario: "Scenario"
    scenes: "Scenes"


def drawn_scene(words: Sequence[str], terminal: Terminal) -> DrawnScene | Exit:
    """The scene of `cortexc WORDS…`; the exit code where the file has errors, which are shown.

    Raises:
        UsageError: no scene meets the requirements.
    """
    from cortex_dsl.cli.run import draw
    from cortex_dsl.cli.simulation import open_scenario

    request = to_request(build_parser().parse_args(words), words)
    compiled = compile_request(request, terminal)
    if isinstance(compiled, Exit):
        return compiled
    scenario = open_scenario(request, compiled)
    scenes, tally = draw(scenario, request)
    if not scenes.valid[0]:
        raise UsageError(
            f"no scene of `{request.file}` meets its requirements, after {tally.attempts:,} attempts",
            f"`{shlex.join(['cortexc', *words])}` says which of them is to blame",
        )
    return DrawnScene(request, scenario, scenes)
