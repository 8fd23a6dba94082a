"""SCN53x: what is proved of a file before anything is drawn."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.problems import Problem

INFEASIBLE = Problem(
    "SCN530",
    "no scene can meet every requirement",
    "{reason}",
    "relax one of them, or widen the range of a param that it reads",
    page=Page(
        "file without a valid scene",
        "Interval reasoning over the ranges of all params and draws proves that no attempt can pass: every one of them "
        "would be thrown away. The requirements named are a smallest set for which this is proved.",
        "param D = Range(5, 20) m\nego = new Car on road\nrequire D >= 15 m\nrequire D * 2 <= 25 m\n",
        "param D = Range(5, 20) m\nego = new Car on road\nrequire D >= 10 m\nrequire D * 2 <= 25 m\n",
        shown="by `--check`",
    ),
)
