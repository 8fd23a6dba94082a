"""Export and import of cases: recordings of runs, and the formats of other tools. Knows no text of the language.

`Recording` is what stands between a simulator and a file: `recorded_run` makes one of a run, each format's module makes
files of one, `measure` judges one, from any driver, with the kernels that judge our own runs.
"""

from typing import TYPE_CHECKING, Any

from engine.interchange.contract import Export, ExportOptions, InterchangeError

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
    """Import recordings when they are first asked for: every command that reads a scenario names the package."""
    if name in __all__:
        from engine.interchange import recording

        return getattr(recording, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
