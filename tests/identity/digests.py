"""`python -m tests.identity.digests NAME` prints digests of subjects as JSON, made in a process of its own."""

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
    with tempfile.TemporaryDirectory() as scratch:
        sys.stdout.write(json.dumps(digests(ON_THE_OLDEST[sys.argv[1]](Path(scratch)))))
