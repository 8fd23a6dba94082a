"""The fixed-time plan of the traffic lights: what `signals(...)` says, and in which phase each arm is."""

from cortex_dsl import ir
from engine.frozen import frozen

COLOURS = ("None", "green", "yellow", "red", "off", "unknown")
"""What a light may show, by number; `None` where there is no light. CARLA's names, as Scenic's scripts have them."""
NONE, GREEN, YELLOW, RED, OFF, UNKNOWN = range(len(COLOURS))

DEFAULT_GREEN = 10.0
DEFAULT_YELLOW = 3.0
DEFAULT_ALL_RED = 2.0
"""[s]. Those of CARLA's lights; yellow of 3 to 6 s and red clearance of 1 to 2 s are what the Manual on Uniform Traffic
Control Devices (2009), section 4D.26, and practice ask for."""

PHASES = 2
"""Arms that face each other are green together: first those of the north and south, then those of the east and west."""


@frozen
class SignalPlan:
    """Times in seconds, as expressions over genes and constants."""

    green: ir.Expr
    yellow: ir.Expr
    all_red: ir.Expr
    offset: ir.Expr
    """How far into the plan the run starts."""
    controls: "Controls | None" = None

    def as_ir(self) -> ir.Lights:
        return ir.Lights(self.green, self.yellow, self.all_red, self.offset, controlled=self.controls is not None)


@frozen
class Controls:
    """Locals by which behaviours and monitors change the lights; only where a file does so."""

    frozen: int
    """1 while the lights stand still."""
    frozen_at: int
    """Clock of the lights while they do [s]."""
    lost: int
    """How long they have stood still before [s]."""
    colours: tuple[int, ...]
    """Per light, the colour it was set to; 0: none."""
    changes: tuple[int, ...]
    """Per light, how often the plan had changed its colour when it was set: the next change takes over again."""
