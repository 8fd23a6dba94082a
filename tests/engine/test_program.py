"""A saved program is the program: it loads equal, runs equal, and is refused when damaged or foreign."""

from dataclasses import fields, replace
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import compile_text, load
from engine import batch, opcodes, vocabulary
from engine.program import ArchiveError, Program, load_program, save_program
from engine.sampling import draw_genomes, sample
from engine.streams import key_rows
from engine.vocabulary import Method

VALUES = {
    name: each
    for module in (opcodes, vocabulary)
    for name, each in vars(module).items()
    if isinstance(each, type) and issubclass(each, Enum) and each.__module__ == module.__name__
}
EXAMPLE = Path(__file__).parents[2] / "examples" / "crossing_left_turn.scn"


@pytest.mark.parametrize("name", VALUES)
def test_no_two_values_are_one(name: str) -> None:
    """Two names of one number would be one value to kernels and to archives."""
    assert len(VALUES[name]) == len(VALUES[name].__members__)


@pytest.fixture(scope="module")
def program() -> Program:
    return load(EXAMPLE).program


def test_a_program_survives_the_disk(program: Program, tmp_path: Path) -> None:
    """Every field comes back with its type."""
    save_program(program, tmp_path / "program.npz")
    again = load_program(tmp_path / "program.npz")
    for field in fields(Program):
        one, other = getattr(program, field.name), getattr(again, field.name)
        if field.name in ("code", "road"):
            for name, array in one._asdict().items():
                np.testing.assert_array_equal(array, getattr(other, name))
                assert array.dtype == getattr(other, name).dtype
        elif field.name == "space":
            assert one.names == other.names
            np.testing.assert_array_equal(one.low, other.low)
            assert one.options == other.options
        elif isinstance(one, np.ndarray):
            np.testing.assert_array_equal(one, other)
        else:
            assert one == other, field.name


def test_a_loaded_program_runs_without_the_language(program: Program, tmp_path: Path) -> None:
    """Sampling and simulation need nothing but the archive."""
    save_program(program, tmp_path / "program.npz")
    keys = key_rows(7, Method.SAMPLE, 0, 0, range(30))
    runs = []
    for each in (program, load_program(tmp_path / "program.npz")):
        scenes = sample(each, draw_genomes(each.space, keys), keys)
        runs.append(batch.simulate(each, scenes))
    np.testing.assert_array_equal(runs[0].min_distance, runs[1].min_distance)
    np.testing.assert_array_equal(runs[0].end_time, runs[1].end_time)


def test_the_digest_names_what_decides_a_result() -> None:
    """Names and comments do not change it; a number does."""
    text = 'map intersection()\nego = new Car at (0 m, 0 m), facing 0 deg, with speed 5 m/s\nrequire True as "one"\n'
    digest = compile_text(text).program.digest
    assert compile_text(text.replace("one", "other") + "# a remark\n").program.digest == digest
    assert compile_text(text.replace("5 m/s", "6 m/s")).program.digest != digest
    assert compile_text(text + "terminate after 3 s\n").program.digest != digest


@pytest.mark.parametrize("content", [b"", b"no archive at all", b"PK\x03\x04 broken"])
def test_foreign_files_are_refused(content: bytes, tmp_path: Path) -> None:
    """What is no archive gets a clear error."""
    path = tmp_path / "program.npz"
    path.write_bytes(content)
    with pytest.raises(ArchiveError, match="not a saved program"):
        load_program(path)


def test_a_damaged_program_is_refused(program: Program, tmp_path: Path) -> None:
    """The digest must fit the arrays."""
    code = program.code._replace(literals=program.code.literals + 1.0)
    save_program(replace(program, code=code), tmp_path / "program.npz")
    with pytest.raises(ArchiveError, match="damaged"):
        load_program(tmp_path / "program.npz")
