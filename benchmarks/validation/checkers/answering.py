"""How a checker is asked: a list of jobs as JSON on stdin, a list of findings for each on stdout, in that order."""

import json
import logging
import os
import re
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any


def answer(check: Callable[[Any], list[str]], known: str = "") -> None:
    """Answer all jobs; what breaks a checker is a finding, and so is what it warns of, but for what is `known`."""
    jobs = json.load(sys.stdin)
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):  # noqa: PTH123 - not a path
        findings = [_guarded(check, job) for job in jobs]
    if known:
        findings = [[each for each in found if not re.fullmatch(known, each)] for found in findings]
    json.dump(findings, sys.stdout)


def _guarded(check: Callable[[Any], list[str]], job: object) -> list[str]:
    with _heard() as said:
        try:
            return check(job) + said
        except Exception as problem:
            place = traceback.extract_tb(problem.__traceback__)[-1]
            return [*said, f"{type(problem).__name__} in {place.name}: {problem}"]


@contextmanager
def _heard() -> Iterator[list[str]]:
    """Warnings of any kind, as they come, but for deprecations."""
    said: list[str] = []
    ear = logging.Handler(logging.WARNING)
    ear.emit = lambda record: said.append(f"{record.name}: {record.getMessage()}")  # type: ignore[method-assign]
    logging.root.addHandler(ear)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            for kind in (DeprecationWarning, PendingDeprecationWarning, ResourceWarning):
                warnings.simplefilter("ignore", kind)
            warnings.showwarning = lambda message, category, *_, **__: said.append(f"{category.__name__}: {message}")
            yield said
    finally:
        logging.root.removeHandler(ear)
