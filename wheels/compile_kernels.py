"""Compile kernels for a wheel: `python -m wheels.compile_kernels FOLDER [ARGUMENTS]`.

They are compiled for a named processor (`engine.kernels.packaged`) by a Python process of its own, which calls them:
`wheels.jobs`, or what the arguments say. It keeps them in a cache beside the folder, so that a second wheel of the same
kernels compiles nothing.
"""

import os
import platform
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import engine.kernels
from engine.compiling_apart import stored_name
from engine.kernels.jit import content_key
from engine.kernels.packaged import process_triple, wheel_target, write_target
from engine.kernels.shared import Shared

ROOT = Path(__file__).parent.parent
EVERY_KERNEL = ("-m", "wheels.jobs")


def compile_kernels(folder: Path, arguments: tuple[str, ...] = EVERY_KERNEL) -> int:
    """Fill a new folder; return the exit code."""
    target = wheel_target(platform.machine(), process_triple())
    if target is None:
        print(f"no kernels: no target is known for {platform.machine()}", file=sys.stderr)
        return 1
    key, cache = content_key(), folder.with_name(f"{folder.name}-cache")
    chosen = {"NUMBA_CPU_NAME": target.processor, "NUMBA_CPU_FEATURES": target.features, "CORTEXC_CACHE": str(cache)}
    command = [sys.executable, *arguments]
    done = subprocess.run(command, cwd=ROOT, env={**os.environ, **chosen}, stdout=subprocess.DEVNULL, check=False)
    if done.returncode:
        return done.returncode
    shutil.rmtree(folder, ignore_errors=True)
    (compiled,) = cache.glob(f"numba-{key}-*")
    shutil.copytree(compiled, folder, ignore=shutil.ignore_patterns("*.nbc.*"))
    write_target(folder, key, target)
    if arguments == EVERY_KERNEL and (missing := [name for name in deferred_names() if not any(folder.glob(name))]):
        print(f"no job of wheels.jobs calls {', '.join(missing)}", file=sys.stderr)
        return 1
    files = list(folder.rglob("*.nbc"))
    print(f"{len(files)} kernels, {sum(file.stat().st_size for file in files) / 1e6:.1f} MB", file=sys.stderr)
    return 0


def deferred_names() -> list[str]:
    """Return the pattern of the file of each kernel that only some programs need."""
    modules = [import_module(each.name) for each in walk_packages(engine.kernels.__path__, "engine.kernels.")]
    kernels = {each for module in modules for each in vars(module).values() if isinstance(each, Shared)}
    return sorted(stored_name(each, "*") for each in kernels if not each.is_always_needed)


if __name__ == "__main__":
    sys.exit(compile_kernels(Path(sys.argv[1]).resolve(), tuple(sys.argv[2:]) or EVERY_KERNEL))
