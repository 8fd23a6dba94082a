"""`python -m tests.identity.digests` prints digests of `ON_THE_OLDEST` as JSON, made in a process of its own."""

import hashlib
import json
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from tests.identity.subjects import ON_THE_OLDEST


def digests(subjects: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return a digest of the text of each subject."""
    return {subject: hashlib.sha256(text.encode()).hexdigest()[:20] for subject, text in subjects}


if __name__ == "__main__":
    found: dict[str, dict[str, str]] = {}
    for name, make in ON_THE_OLDEST.items():
        with tempfile.TemporaryDirectory() as scratch:
            found[name] = digests(make(Path(scratch)))
    json.dump(found, sys.stdout)
