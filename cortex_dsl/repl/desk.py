"""The state of a session: the one mutable object that entries and commands work on."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.repl.checking import Checked, check
from cortex_dsl.repl.draft import Draft, History
from cortex_dsl.repl.kernels import Kernels

if TYPE_CHECKING:
    from cortex_dsl.api.scenario import Scenario
    from engine.blame import Weighing
    from engine.program import Program

UNNAMED = "session"
"""What messages call a scenario that is in no file."""
LIKE = "such as `ego = new Car on road`"


@dataclass
class Desk:
    """Everything that a session knows."""

    terminal: Terminal
    interactive: bool = False
    """Whether somebody can be asked."""
    history: History = field(default_factory=History)
    file: Path | None = None
    on_disk: str = ""
    """Text of the file when the session last read or wrote it."""
    saved: Draft = field(default_factory=Draft)
    """The draft that is in the file."""
    overrides: Mapping[str, str] = field(default_factory=dict)
    """Params that are held."""
    seed: int = 0
    scenes_tried: int = 0
    """Draws of the params that `:scene` has looked at, those without a scene among them."""
    scenes_shown: int = 0
    """How many scenes of the present draft were looked at."""
    editing: int | None = None
    """The entry that the next chunk takes the place of."""
    proposal: str = ""
    """Text to put into the next prompt."""
    kernels: Kernels = field(default_factory=Kernels)
    mistakes: int = 0
    """Entries and commands that were refused."""
    bugs: int = 0
    no_scene: bool = False
    """Whether the last command that needed a scene found none."""
    leaving: bool = False
    _checked: Checked | None = None
    _weighings: "list[Weighing]" = field(default_factory=list)

    @property
    def draft(self) -> Draft:
        return self.history.present

    @property
    def name(self) -> str:
        return UNNAMED if self.file is None else str(self.file)

    @property
    def unsaved(self) -> bool:
        return self.draft != self.saved

    @property
    def checked(self) -> Checked:
        """What the compiler says of the draft as it is."""
        if self._checked is None or self._checked.draft != self.draft:
            self._checked = check(self.draft, self.name, self.overrides)
        return self._checked

    def adopt(self, history: History, checked: Checked | None = None) -> None:
        """Go on with another draft."""
        self.history = history
        self._checked = checked
        self.scenes_tried = self.scenes_shown = 0

    def hold(self, overrides: Mapping[str, str], checked: Checked) -> None:
        """Go on with other params held."""
        self.overrides = overrides
        self._checked = checked
        self.scenes_tried = self.scenes_shown = 0

    def weighing(self, program: "Program") -> "Weighing":
        """A program's requirements on ten thousand draws; those of the last programs are kept."""
        for known in self._weighings:
            if known.program is program:
                return known
        from engine.blame import weigh

        weighing = weigh(program, seed=self.seed)
        self._weighings = [*self._weighings[-2:], weighing]
        return weighing

    def forget_weighings(self) -> None:
        self._weighings = []

    @property
    def acceptance(self) -> float | None:
        """Share of draws that the draft accepts; None while it is not known."""
        program = self.checked.weighable
        return self.weighing(program).acceptance if program is not None and self.kernels.ready else None

    def scenario(self) -> "Scenario":
        """The draft, ready to be sampled and run.

        Raises:
            UsageError: it is not complete.
        """
        compiled = self.checked.compiled
        if compiled is None:
            raise self.not_ready()
        from cortex_dsl.api.scenario import Scenario, in_file
        from engine.config import Config, SimulationConfig

        self.kernels.wait(self.terminal)
        simulation = in_file(SimulationConfig(), compiled.program.settings)
        return Scenario(compiled, Config(simulation=simulation), self.overrides)

    def not_ready(self) -> UsageError:
        """Why nothing can be drawn yet."""
        if self.checked.errors:
            return UsageError("the scenario has errors", "`:check` shows them, `:edit N` mends an entry")
        return UsageError("still to come: an ego", LIKE)
