"""Compiled kernels of a wheel: a folder in the package that is read before the user's cache.

Its kernels are compiled for a named processor of a platform, not for that of the machine that built the wheel.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple, cast

import numba
from llvmlite import binding  # pyright: ignore[reportMissingTypeStubs]

FOLDER = Path(__file__).parent / "compiled"
TARGET_FILE = "target.json"
V3 = (
    "64bit avx avx2 bmi bmi2 cmov crc32 cx16 cx8 f16c fma fxsr lzcnt mmx movbe popcnt sahf sse sse2 sse3 sse4.1 sse4.2 "
    "ssse3 xsave"
)
"""Features of x86-64-v3 under LLVM's names. Source: System V ABI, AMD64 supplement, section 3.1.1."""
PROCESSORS = {"x86_64": ("x86-64-v3", V3), "arm64": ("generic", "fp-armv8 neon")}
"""LLVM's name of the processor that kernels of a wheel are compiled for, and its features, for each architecture."""
SYNONYMS = {"amd64": "x86_64", "aarch64": "arm64"}


class Target(NamedTuple):
    """Target of machine code, in the order of numba's own keys."""

    triple: str
    processor: str
    features: str

    def runs_on(self, triple: str, features: Mapping[str, bool]) -> bool:
        """Return True if a machine of this triple and these features can run the code."""
        return self.triple == triple and all(features.get(name[1:]) for name in self.features.split(","))


class PackagedKernels(NamedTuple):
    """A folder of compiled kernels, and the target of their keys."""

    folder: Path
    target: Target


def wheel_target(architecture: str, triple: str) -> Target | None:
    """Return the target of a wheel for an architecture as `platform.machine` names it; None where there is none."""
    name = architecture.lower()
    if (known := PROCESSORS.get(SYNONYMS.get(name, name))) is None:
        return None
    processor, features = known
    return Target(triple, processor, ",".join(f"+{feature}" for feature in features.split()))


def packaged_kernels(key: str) -> PackagedKernels | None:
    """Return the kernels of the package, if it has some of this key for a target that this machine can run."""
    try:
        described = json.loads((FOLDER / TARGET_FILE).read_text(encoding="utf-8"))
        target = Target(*(str(described[name]) for name in Target._fields))
        return PackagedKernels(FOLDER, target) if described["key"] == key and _suits(target) else None
    except (OSError, ValueError, LookupError, TypeError):
        return None


def write_target(folder: Path, key: str, target: Target) -> None:
    """Describe a folder of compiled kernels."""
    (folder / TARGET_FILE).write_text(json.dumps({"key": key, **target._asdict()}, indent=1), encoding="utf-8")


def process_triple() -> str:
    """Return LLVM's name of the platform of this process."""
    return str(cast("Any", binding).get_process_triple())


def processor() -> tuple[str, str]:
    """Return LLVM's name of the processor that numba compiles for, and its features; empty if unknown."""
    config, untyped = cast("Any", numba).config, cast("Any", binding)
    try:
        features = untyped.get_host_cpu_features().flatten() if config.CPU_FEATURES is None else config.CPU_FEATURES
    except RuntimeError:
        features = ""
    return untyped.get_host_cpu_name() if config.CPU_NAME is None else config.CPU_NAME, features


def _suits(target: Target) -> bool:
    """Return True if this machine can run the code, and the user has not chosen another processor for numba."""
    config = cast("Any", numba).config
    chosen = config.CPU_NAME, config.CPU_FEATURES
    if chosen != (None, None):
        return chosen == target[1:]
    try:
        features = dict(cast("Any", binding).get_host_cpu_features())
    except RuntimeError:  # LLVM does not know them
        return False
    return target.runs_on(process_triple(), features)
