"""Kernels that a wheel carries: read where they are of this version and this processor can run them, never trusted."""

import json
import platform
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from engine.kernels import packaged
from engine.kernels.packaged import TARGET_FILE, Target, packaged_kernels, process_triple, wheel_target, write_target
from tests.engine.kernels.test_jit import DAMAGES, PRELUDE, UNKEPT, Installation, result, without_numba
from tests.fork_server import ForkServer

LINUX = "x86_64-unknown-linux-gnu"
V3 = wheel_target("x86_64", LINUX)
ARM = wheel_target("arm64", "arm64-apple-darwin23")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ForkServer]:
    with ForkServer(PRELUDE, tmp_path_factory.mktemp("server"), *UNKEPT, environment=without_numba()) as server:
        yield server


@pytest.fixture(scope="module")
def carried(tmp_path_factory: pytest.TempPathFactory, server: ForkServer) -> Path:
    """Two kernels compiled for the target of a wheel, with its description."""
    target = wheel_target(platform.machine(), process_triple())
    if target is None or not _is_runnable(target):
        pytest.skip("this processor is no target of a wheel, or an older one")
    at = tmp_path_factory.mktemp("build")
    process = Installation(at, at / "cache", server).start(
        NUMBA_CPU_NAME=target.processor, NUMBA_CPU_FEATURES=target.features
    )
    _, value, _, folder = result(process)
    assert value == 6.0
    write_target(folder, folder.name.split("-")[1], target)
    return folder


@pytest.fixture
def installation(tmp_path: Path, server: ForkServer, carried: Path) -> Installation:
    """An installation whose two kernels are in its package and in no cache."""
    made = Installation(tmp_path, tmp_path / "cache", server)
    shutil.copytree(carried, made.package / "kernels" / "compiled")
    return made


def _is_runnable(target: Target) -> bool:
    return packaged._suits(target)


def test_the_package_is_read_before_the_cache(installation: Installation) -> None:
    """Nothing is compiled, and nothing written but the mark of the sources."""
    cached, value, hits, folder = installation.run()
    assert (cached, value, hits) == (True, 6.0, 1)
    assert not list(folder.rglob("*.nbc"))


def test_other_sources_compile_as_without_a_package(installation: Installation) -> None:
    """The key is another, the results are those of the sources."""
    installation.write_inner(2)
    assert installation.run()[:3] == (False, 9.0, 0)
    assert installation.run()[:3] == (True, 9.0, 1)


@pytest.mark.parametrize(("entry", "found"), [("inner", 1), ("outer", 0)])
def test_a_damaged_kernel_costs_a_compilation(installation: Installation, entry: str, found: int) -> None:
    """Of itself alone, into the user's cache: the caller of a shared kernel is found."""
    (path,) = (installation.package / "kernels" / "compiled" / entry).glob("*.nbc")
    whole = path.read_bytes()
    for damage in DAMAGES:
        path.write_bytes(damage(whole))
        _, value, hits, folder = installation.run(COMPILE_BEFORE="1")
        assert (value, hits) == (6.0, found)
        assert len(list(folder.rglob("*.nbc"))) == 1
        assert installation.run(COMPILE_BEFORE="1")[1:3] == (6.0, 1)
        shutil.rmtree(folder)


def test_a_foreign_kernel_is_a_miss(installation: Installation) -> None:
    """The entry of another function under this one's name, whole as it is."""
    carried = installation.package / "kernels" / "compiled"
    (inner,), (outer,) = (list((carried / name).glob("*.nbc")) for name in ("inner", "outer"))
    shutil.copy(inner, outer)
    assert installation.run()[1:3] == (6.0, 0)
    assert installation.run()[1:3] == (6.0, 1)


def test_a_processor_that_the_user_chose_gets_its_own_kernels(installation: Installation) -> None:
    """The settings of numba hold: what they exclude is not run."""
    chosen = {"NUMBA_CPU_NAME": "x86-64", "NUMBA_CPU_FEATURES": "+sse2"}
    if platform.machine() != "x86_64":
        pytest.skip("names of another architecture")
    process = installation.start(**chosen)
    assert process.communicate()[0].split()[1:3] == ["6.0", "0"]


def test_targets_are_keys() -> None:
    """Code runs on its own architecture and system alone, and on no processor that lacks a feature."""
    assert V3 is not None
    assert ARM is not None
    full = {str(name): True for name in packaged.V3.split()}
    arm = {"fp-armv8": True, "neon": True, "sve": False}
    assert V3.runs_on(LINUX, full | {"avx512f": True})
    assert ARM.runs_on("arm64-apple-darwin23", arm)
    assert not V3.runs_on("x86_64-apple-darwin23", full)
    assert not ARM.runs_on(LINUX, full)
    assert not V3.runs_on(LINUX, full | {"avx2": False})
    assert not ARM.runs_on("arm64-apple-darwin23", {"neon": True})
    assert wheel_target("aarch64", "t") == wheel_target("arm64", "t")
    assert wheel_target("AMD64", "t") == wheel_target("x86_64", "t")
    assert wheel_target("riscv64", "t") is None


@pytest.mark.parametrize("text", ["", "[]", "{}", "null", '{"key": "k"}', "\xff"])
def test_a_broken_description_is_none(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels whose target is unknown are not run."""
    monkeypatch.setattr(packaged, "FOLDER", tmp_path)
    (tmp_path / TARGET_FILE).write_text(text, encoding="latin-1")
    assert packaged_kernels("k") is None


def test_the_key_of_the_package_is_compared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package of another version, or for another machine, is passed over."""
    target = wheel_target(platform.machine(), process_triple())
    if target is None or not _is_runnable(target):
        pytest.skip("this processor is no target of a wheel, or an older one")
    monkeypatch.setattr(packaged, "FOLDER", tmp_path)
    write_target(tmp_path, "k", target)
    assert packaged_kernels("k") == (tmp_path, target)
    assert packaged_kernels("l") is None
    described: dict[str, Any] = json.loads((tmp_path / TARGET_FILE).read_text())
    for other in ({"triple": "another"}, {"features": f"{target.features},+unheard-of"}):
        (tmp_path / TARGET_FILE).write_text(json.dumps(described | other))
        assert packaged_kernels("k") is None
