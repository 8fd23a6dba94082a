"""Is there a recording that breaks a command, or takes too long? Recordings of every kind that is read, changed.

    python -m benchmarks.fuzz recordings [--count 2000] [--seed 0] [--keep FOLDER] [--json]

Each file has one to four changes: a row, column, cell, element or text is deleted or doubled, a number becomes 0,
changes its sign, or jumps; of a binary file, some bytes. `cortexc measure` judges it, its ego or every pair. It must
end in a result whose JSON is strict, or in a refusal that names the file and a cure, within the time limit. Exit code 1
if one does not; `--keep` writes those files down, and the slowest.
"""

import csv
import io
import json
import random
import re
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import cache
from pathlib import Path
from typing import NoReturn

from benchmarks.fuzz.files import JUMPS, Fuzzer, Judge, Sample, run
from cortex_dsl.cli import main as cortexc
from engine.interchange import ExportOptions
from engine.interchange.openscenario import write_trajectories
from tests.engine.interchange.openscenario.conftest import small
from tests.engine.interchange.test_sources import WRITERS

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])")
TEXTS = ("", " ", "nan", "inf", "-", "x", "1e999", "1,5", "2026-11-28T12:00:00Z", "é", '"', "<", "\t")
FINE, REFUSED = 0, 1
EVERY_PAIR = ("--all",)


@cache
def sound() -> tuple[Sample, ...]:
    """Return recordings to change, one of each kind."""
    found: list[Sample] = []
    for write in WRITERS:
        with tempfile.TemporaryDirectory() as folder:
            name = write(Path(folder)).name
            others = sorted(each.name for each in Path(folder).iterdir() if each.name != name)
            found.append(Sample({each: (Path(folder) / each).read_bytes() for each in (name, *others)}))
    files = write_trajectories(small(), "case", ExportOptions(), None).files
    return (*found, Sample({name: str(text).encode() for name, text in files.items()}))


# -- changes -----------------------------------------------------------------------------------------------------------


def number_of(rng: random.Random, text: str) -> str:
    """Return another number, or no number, in place of one."""
    try:
        value = float(text)
    except ValueError:
        return rng.choice(TEXTS)
    other = rng.choice((0.0, -value, value * rng.choice(JUMPS), value + rng.choice((-1.0, 1.0)) * rng.choice(JUMPS)))
    return rng.choice(TEXTS) if rng.random() < 0.1 else repr(int(other) if rng.random() < 0.3 else other)


def changed_table(rng: random.Random, text: str) -> str:
    """A table with other rows, columns and cells."""
    mark = ";" if ";" in text[:500] else ","
    rows = list(csv.reader(io.StringIO(text), delimiter=mark))
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(rows))
        column = rng.randrange(max(1, len(rows[at])))
        match rng.randrange(8):
            case 0:
                del rows[at : at + rng.choice((1, 1, 30))]
            case 1:
                rows[at:at] = [list(rows[at])]
            case 2:
                rng.shuffle(rows[1:])
                rows.insert(rng.randrange(len(rows)), rows.pop(at))
            case 3:
                for row in rows:
                    del row[column : column + 1]
            case 4:
                for row in rows:
                    row[column:column] = row[column : column + 1]
            case 5:
                kept = rng.choice((0.0, -1.0, *JUMPS))
                for row in rows[1:]:
                    row[column : column + 1] = [_scaled(cell, kept) for cell in row[column : column + 1]]
            case _:
                if column < len(rows[at]):
                    rows[at][column] = number_of(rng, rows[at][column])
        if not rows:
            break
    out = io.StringIO()
    csv.writer(out, delimiter=mark, lineterminator="\n").writerows(rows)
    return out.getvalue()


def _scaled(cell: str, factor: float) -> str:
    try:
        return repr(float(cell) * factor)
    except ValueError:
        return cell


def changed_pieces(rng: random.Random, pieces: list[str]) -> str:
    """Lines of a log or elements of XML, with some deleted, doubled, moved, or with other numbers."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(pieces))
        match rng.randrange(6):
            case 0:
                del pieces[at : at + rng.choice((1, 1, 5))]
            case 1:
                pieces[at:at] = pieces[at : at + rng.choice((1, 1, 5))]
            case 2:
                pieces.insert(rng.randrange(len(pieces)), pieces.pop(at))
            case _:
                found = list(NUMBER.finditer(pieces[at]))
                if found:
                    one = rng.choice(found)
                    start, end = one.span()
                    pieces[at] = pieces[at][:start] + number_of(rng, one.group()) + pieces[at][end:]
        if not pieces:
            break
    return "".join(pieces)


def changed_bytes(rng: random.Random, content: bytes) -> bytes:
    """A binary file with some bytes changed, deleted, doubled or zero."""
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 4))):
        at, size = rng.randrange(len(data)), rng.choice((1, 1, 4, 8, 64))
        match rng.randrange(5):
            case 0:
                del data[at : at + size]
            case 1:
                data[at:at] = data[at : at + size]
            case 2:
                data[at : at + size] = bytes(len(data[at : at + size]))
            case _:
                data[at] ^= 1 << rng.randrange(8)
        if not data:
            break
    return bytes(data)


def changed(rng: random.Random, name: str, content: bytes) -> bytes:
    """The content of a file with some changes."""
    if name.endswith((".parquet", ".mcap", ".osi")):
        return changed_bytes(rng, content)
    text = content.decode()
    if name.endswith(".csv") and not text.startswith("Version:"):
        return changed_table(rng, text).encode()
    if name.endswith(".csv"):
        head, _, rest = text.partition("\n")
        return f"{head}\n{changed_table(rng, rest)}".encode()
    mark = r"(?<=\n)" if name.endswith((".txt", ".log")) else r"(?=<)"
    return changed_pieces(rng, [piece for piece in re.split(mark, text) if piece]).encode()


def recordings(rng: random.Random) -> Iterator[Sample]:
    """Yield changed recordings for ever, one kind after the other."""
    while True:
        for sample in sound():
            which = rng.choice((sample.name, sample.name, sample.name, *sample.files))
            yield Sample({**sample.files, which: changed(rng, which, sample.files[which])})


# -- judgement ---------------------------------------------------------------------------------------------------------


def judge(sample: Sample, folder: Path, command: str, *options: str) -> str:
    """Return `result`, `result with a note` or `refused`, as the command says that reads it.

    Raises:
        AssertionError: what comes out is none of these.
    """
    shutil.rmtree(folder)
    folder.mkdir()
    for name, content in sample.files.items():
        (folder / name).write_bytes(content)
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        rate = ["--rate", "10"] if sample.name == "plain.csv" else []  # which counts frames
        code = cortexc([command, str(folder / sample.name), "--json", *rate, *options])
    if code == REFUSED:
        said = out.getvalue() + err.getvalue()
        if not any(Path(name).stem in said for name in sample.files) or not re.search(
            r'help: |"help": "|"cure": "', said
        ):
            raise AssertionError(f"a refusal without a place or a cure: {said}")
        return "refused"
    if code != FINE:
        raise AssertionError(f"exit code {code}: {out.getvalue()[-3000:]}{err.getvalue()[-3000:]}")
    document = json.loads(out.getvalue(), parse_constant=_refuse)
    return "result with a note" if document["remarks"] else "result"


def _refuse(constant: str) -> NoReturn:
    raise AssertionError(f"{constant} is no JSON")


@contextmanager
def judging(rng: random.Random) -> Iterator[Judge]:
    """Yield a function that judges a recording: its ego, or now and then every pair."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        for options in ((), EVERY_PAIR):
            judge(sound()[0], folder, "measure", *options)
        yield lambda sample: judge(sample, folder, "measure", *(EVERY_PAIR if rng.random() < 0.4 else ()))


FUZZER = Fuzzer(recordings, judging)


def main(arguments: Sequence[str]) -> int:
    return run(__doc__, FUZZER, arguments)
