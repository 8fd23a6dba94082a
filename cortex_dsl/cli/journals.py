"""Runs that `report` and `analyse` tell about: opened, and held against the searcher that their journals name."""

from pathlib import Path

from cortex_dsl.api.runs import OpenedRun, check_journal, open_run
from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.hunting import usage_errors
from cortex_dsl.cli.terminal import Terminal
from engine.extras import MissingExtraError
from engine.search.campaign import ForeignPastError
from engine.search.manifest import changed_versions
from engine.search.plugins import PluginError
from engine.search.searchers import UnknownMethodError


def told_run(folder: Path, terminal: Terminal) -> OpenedRun:
    """A run with a finished generation, whose individuals are those that its method proposes.

    What the simulations came to is not simulated again: a changed result shows only where it changes what the method
    proposed next, or the figures of its generation.

    Raises:
        UsageError: there is no readable run, or its journal does not follow from its own beginning.
    """
    with usage_errors():
        run = open_run(folder)
    if not len(run.record.evaluations):
        raise UsageError(f"`{folder}` has no finished generation", "`cortexc resume` goes on with it")
    try:
        check_journal(run)
    except ForeignPastError as error:
        _foreign(run, error, terminal)
    except (MissingExtraError, PluginError, UnknownMethodError):
        method = run.record.manifest.method
        terminal.err.print(f"not checked: the searcher {method} of this journal is not installed here", style="quiet")
    return run


def _foreign(run: OpenedRun, error: ForeignPastError, terminal: Terminal) -> None:
    """Other versions may well search otherwise; the same ones do not, unless a searcher never repeats itself."""
    what = f"generation {error.generation} in the journal of `{run.folder}` is not what {run.record.manifest.method} "
    what += "proposes after the ones before it"
    if changed := changed_versions(run.record.manifest):
        terminal.err.print(f"{what}; it was started with {', '.join(changed)}", style="warn")
        return
    raise UsageError(what, "rows were changed since they were written: restore the file from a copy, or search again")
