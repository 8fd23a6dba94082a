"""The world host: scenes one at a time in pymunk, which carries the poses and computes the motion after a contact.

`simulate(program, scenes, config)` gives scored outcomes; `run(program, scenes, row, config)` one complete run.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from engine.world.pymunk_host import WorldRun, run, simulate

__all__ = ["WorldRun", "run", "simulate"]


def __getattr__(name: str) -> Any:
    """Import pymunk and the kernels on first access, not with the package."""
    if name in __all__:
        from engine.world import pymunk_host

        return getattr(pymunk_host, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
