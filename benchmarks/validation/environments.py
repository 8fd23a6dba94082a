"""Every checker in an environment of its own, as their requirements clash. Made once, kept in `.validate`."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterable
from importlib.metadata import distributions
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FOLDER = ROOT / ".validate"
REQUIREMENTS = HERE / "requirements"
LONGEST_SETUP = 1800.0
"""[s]"""


class SetupError(Exception):
    """A checker could not be set up; the message says what to do."""


def set_up(names: Iterable[str], python: str, say: Callable[[str], None]) -> None:
    """Make the environments that are not there, or whose requirements have changed.

    Raises:
        SetupError: an installation failed.
    """
    for name in names:
        wanted = (REQUIREMENTS / f"{name}.txt").read_text(encoding="utf-8")
        stamp = FOLDER / name / "installed.txt"
        if stamp.exists() and stamp.read_text(encoding="utf-8") == wanted:
            continue
        say(f"setting up {name} (once): {', '.join(wanted.split())}")
        _run(name, python, "-m", "venv", "--clear", str(FOLDER / name))
        _run(name, str(python_of(name)), "-m", "pip", "install", "--quiet", "--requirement", _requirements(name))
        stamp.write_text(wanted, encoding="utf-8")


def python_of(name: str) -> Path:
    """The interpreter of a checker."""
    return FOLDER / name / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def version_of(name: str) -> str:
    """Name and version of the first package of a checker's requirements, as it is installed."""
    package = (REQUIREMENTS / f"{name}.txt").read_text(encoding="utf-8").partition("==")[0]
    sites = [str(site) for site in (FOLDER / name).glob("**/site-packages")]
    found = next(distributions(name=package, path=sites), None)
    return f"{package} {found.version}" if found else package


def _requirements(name: str) -> str:
    return str(REQUIREMENTS / f"{name}.txt")


def _run(name: str, *command: str) -> None:
    environment = {**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    try:
        subprocess.run(command, check=True, capture_output=True, text=True, timeout=LONGEST_SETUP, env=environment)
    except FileNotFoundError as missing:
        raise SetupError(f"there is no `{command[0]}`: name a Python with `--python`") from missing
    except subprocess.TimeoutExpired as slow:
        raise SetupError(f"setting up {name} took longer than {LONGEST_SETUP / 60:.0f} minutes: try again") from slow
    except subprocess.CalledProcessError as failed:
        last = (failed.stderr or failed.stdout).strip().splitlines()[-3:]
        raise SetupError(
            f"{name} could not be set up with {sys.version.split()[0]}; it takes a network, and a Python that its"
            " packages know (`--python python3.12`):\n  " + "\n  ".join(last)
        ) from failed
