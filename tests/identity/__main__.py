"""`python -m tests.identity FOLDER` writes every subject into a file of its own.

Do so in two checkouts, into two folders, and `diff -r` shows what one version says and the other does not.
"""

import re
import sys
import tempfile
from pathlib import Path

from tests.identity.subjects import MADE, ON_THE_OLDEST, Subjects, files, scenarios


def every_subject(folder: Path) -> Subjects:
    yield from files(scenarios())
    for name, make in (MADE | ON_THE_OLDEST).items():
        (folder / name).mkdir()
        yield from make(folder / name)


if __name__ == "__main__":
    target = Path(sys.argv[1])
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        for subject, text in every_subject(Path(scratch)):
            (target / re.sub(r"[^\w.-]", "_", subject)).write_text(text, encoding="utf-8")
