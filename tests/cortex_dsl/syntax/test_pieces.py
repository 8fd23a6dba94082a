"""Spaces inside a line."""

from cortex_dsl.source import Source
from cortex_dsl.syntax.formatting import format_source


def test_the_sign_of_an_argument_stands_close() -> None:
    """Also before a list or a bracket; that of an assignment does not."""
    text = "x = f(a = [1, 2], b= (3), c =-4)\ny=[1]\nsimulation(system = [A])\n"
    assert format_source(Source("a.scn", text)) == "x = f(a=[1, 2], b=(3), c=-4)\ny = [1]\nsimulation(system=[A])\n"
