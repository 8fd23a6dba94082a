"""Expected output in files, which `UPDATE_GOLDEN=1` writes."""

import os
from pathlib import Path


def matches(text: str, file: Path) -> None:
    """Assert that a text is the one in a file."""
    if os.environ.get("UPDATE_GOLDEN"):
        file.write_text(text, encoding="utf-8")
    assert text == file.read_text(encoding="utf-8")
