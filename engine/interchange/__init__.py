"""Export and import of cases: recordings of runs, and the formats of other tools. Independent of the language.

`Recording` connects a simulator and a file: `recorded_run` makes a recording of a run, each format's module writes
files of a recording, and `measure` assesses a recording of any driver, with the kernels that assess simulated runs.
"""

from typing import TYPE_CHECKING, Any

from engine.errors import InterchangeError
from engine.interchange.contract import Export, ExportOptions

if TYPE_CHECKING:
    from engine.interchange.recording import Contact, Provenance, RecordedActor, Recording, SignalTimes

__all__ = [
    "Contact",
    "Export",
    "ExportOptions",
    "InterchangeError",
    "Provenance",
    "RecordedActor",
    "Recording",
    "SignalTimes",
]


def __getattr__(name: str) -> Any:
    """Import recordings on first access: every command that reads a scenario imports this package."""
    if name in __all__:
        from engine.interchange import recording

        return getattr(recording, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
