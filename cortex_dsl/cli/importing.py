"""`cortexc import FILE.xosc`: a case of somebody else's read back, with its road, and scored."""

from collections.abc import Sequence

from cortex_dsl.cli.measure import SCENARIO, Command, perform
from cortex_dsl.cli.terminal import Terminal

IMPORT = Command(
    "import",
    (SCENARIO,),
    "Read an OpenSCENARIO file whose actors follow timed polylines, with the\n"
    "OpenDRIVE road beside it, and judge it by the metrics and the risk of cortexc.\n"
    "Nothing is fetched from elsewhere.",
    "cortexc import case.xosc",
)


def main(arguments: Sequence[str], terminal: Terminal) -> int:
    return perform(IMPORT, arguments, terminal)
