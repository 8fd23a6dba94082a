"""What was typed in earlier sessions, in the user's state folder; nothing fails where there is none."""

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from prompt_toolkit.history import FileHistory, History, InMemoryHistory


class TolerantHistory(FileHistory):
    """A history file that may vanish or become full while the session lasts."""

    def load_history_strings(self) -> Iterable[str]:
        try:
            return list(super().load_history_strings())
        except OSError:
            return []

    def store_string(self, string: str) -> None:
        with suppress(OSError):
            super().store_string(string)


def past_entries() -> History:
    """The history file of the user, or one that lasts as long as the session."""
    with suppress(OSError, RuntimeError):
        folder = _state_folder()
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        file = folder / "history"
        file.touch(mode=0o600)
        if os.access(file, os.R_OK | os.W_OK):
            return TolerantHistory(str(file))
    return InMemoryHistory()


def _state_folder() -> Path:
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "cortexc"
