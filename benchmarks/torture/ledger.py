"""What a campaign has done, kept line by line, so that the same command goes on where it was stopped."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Ledger:
    """Results of pieces of work by their names; without a file they are kept in memory alone."""

    path: Path | None
    done: dict[str, Any] = field(default_factory=dict[str, Any])

    @classmethod
    def of(cls, path: Path | None) -> "Ledger":
        """What a file holds; a last line that was not written to its end is cut off."""
        if path is None or not path.exists():
            return cls(path)
        whole, _, torn = path.read_bytes().rpartition(b"\n")
        if torn:
            path.write_bytes(whole + b"\n" if whole else b"")
        lines = [json.loads(line) for line in whole.splitlines()]
        return cls(path, {line["piece"]: line["result"] for line in lines})

    def add(self, piece: str, result: Mapping[str, Any]) -> None:
        """Keep the result of a piece, in the file before anything else is begun."""
        self.done[piece] = result
        if self.path is not None:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps({"piece": piece, "result": result}) + "\n")
