"""Params that the command line holds fixed, told as the file would write them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from cortex_dsl.semantics.names.linking import override_text
from cortex_dsl.semantics.names.tree import param_entries
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.units import UNIT_WORDS

AMOUNT = re.compile(r"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?) *(?P<unit>\S*)")


@dataclass(frozen=True)
class Held:
    """One param that is no gene in this run."""

    name: str
    value: float | str
    """A number in the file's own unit, or what the command line says."""
    unit: str = ""

    @property
    def text(self) -> str:
        """The value without its unit."""
        return self.value if isinstance(self.value, str) else f"{self.value:.10g}"


def held_params(module: nodes.Module, overrides: Mapping[str, str]) -> tuple[Held, ...]:
    """What `-p` and `--freeze` hold, in the order in which they were given."""
    entries = param_entries(module)
    return tuple(
        _held(name, override_text(entries[name], text) if name in entries else text) for name, text in overrides.items()
    )


def _held(name: str, text: str) -> Held:
    amount = AMOUNT.fullmatch(text.strip())
    if amount is None or amount["unit"] not in ("", *UNIT_WORDS):
        return Held(name, text)
    return Held(name, float(amount["number"]), amount["unit"])
