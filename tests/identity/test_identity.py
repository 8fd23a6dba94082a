"""What the product says and writes is what it said and wrote before: the guard over every move of code.

`expected/` keeps a digest of each subject. Where a difference is wanted, `UPDATE_GOLDEN=1` records it, in the commit
that makes it and says why; `python -m tests.identity FOLDER` in two checkouts shows what the difference is.
"""

import json
import os
import platform
import subprocess
import sys
import zlib
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.identity.digests import digests
from tests.identity.subjects import MADE, ROOT, files, scenarios
from tests.processor import on_the_oldest

EXPECTED = Path(__file__).parent / "expected"
PARTS = 8
"""The scenario files are judged in so many tests, which may run side by side."""


def _judge(name: str, found: Mapping[str, str], recorded: bool) -> None:
    """Hold digests of subjects against those on record, or record them. A subject that depends on another package
    names its version, and is passed over where another version is installed.
    """
    record = EXPECTED / f"{name}.json"
    if recorded and os.environ.get("UPDATE_GOLDEN"):
        record.write_text(json.dumps(found, indent=0, sort_keys=True) + "\n", encoding="utf-8")
    known = json.loads(record.read_text(encoding="utf-8"))
    common = [subject for subject in known if subject in found]
    assert [subject for subject in common if found[subject] != known[subject]] == []
    assert [subject for subject in set(found) ^ set(known) if "(" not in subject] == []


@pytest.mark.parametrize("part", range(PARTS))
def test_files(part: int) -> None:
    """Check, IR, compiled program and single run of every scenario of the repository."""
    paths = [path for path in scenarios() if zlib.crc32(path.encode()) % PARTS == part]
    _judge(f"files-{part}", digests(files(paths)), recorded=True)


def judged_here() -> list[str]:
    """Not the help texts, which argparse lays out anew in each version of Python, nor what has sums of other processors
    in it, whose last bits differ.
    """
    left_out = set() if sys.version_info[:2] == (3, 11) else {"helps"}
    if platform.machine().lower() not in ("x86_64", "amd64"):
        left_out |= {"documents", "searches", "views"}
    return [name for name in MADE if name not in left_out]


@pytest.mark.parametrize("name", judged_here())
def test_made(name: str, tmp_path: Path) -> None:
    """JSON documents, help texts, searches, exports, views and a study."""
    _judge(name, digests(MADE[name](tmp_path)), recorded=True)


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="sums of other processors differ")
def test_made_on_the_oldest_processor() -> None:
    """What rounds, without AVX2 and AVX-512. Methods of other packages are judged here only, as they depend on it."""
    words = [sys.executable, "-m", "tests.identity.digests"]
    run = subprocess.run(words, cwd=ROOT, env=on_the_oldest(), capture_output=True, text=True, check=True)
    for name, found in json.loads(run.stdout).items():
        _judge(name, found, recorded=name not in MADE)
