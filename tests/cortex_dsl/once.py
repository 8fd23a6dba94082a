"""Texts that several tests compile, compiled once in each process."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import pytest

from cortex_dsl import codes
from cortex_dsl.semantics.model import state

judged = cache(codes.judged)


@contextmanager
def judging_once() -> Iterator[None]:
    """Each example of a page is compiled by the first test that asks; a long evaluation is refused sooner."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(state, "EVALUATION_LIMIT", 20_000)
        patch.setattr(state, "BODY_LIMIT", 200)
        patch.setattr(codes, "judged", judged)
        yield
