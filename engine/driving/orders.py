"""What is decided in scenes side by side: of the coming turns, which runs read, and all of it, by which they run again.

The decisions of all lanes at one step stand in one row of a log, which is as long as the oldest run that still goes on.
"""

from collections.abc import Sequence

import numpy as np

from engine.control import Control, columns, numbers_decided, turns
from engine.tables import Bools, Floats, Ints

FIRST_ROOM = 16
"""Rows of a log to begin with; it grows by half."""


class Orders:
    """Decisions for `count` lanes: by whom they are asked for at which samples, and from when on they hold."""

    def __init__(self, controls: Sequence[Control], count: int, time_step: float, pause: int) -> None:
        self.every = [max(1, turns(each.every, time_step)) for each in controls]
        self._delay = [turns(each.delay, time_step) for each in controls]
        self._columns, self._pause = columns(controls), pause
        self.coming = max(map(sum, zip(self.every, self._delay, strict=True)))
        """Turns of which it is known what was decided."""
        width = numbers_decided(controls)
        self._neutral = np.zeros((count, width))
        self._log = np.zeros((FIRST_ROOM, count, width))
        self._step, self._born = 0, np.ones(count, dtype=np.int64)

    @property
    def nbytes(self) -> int:
        """Memory of what is kept."""
        return self._log.nbytes + self._neutral.nbytes + self._born.nbytes

    def begin(self, chosen: Ints, neutral: Floats, coming: Floats) -> None:
        """Runs begin in the chosen lanes with the next step; until something is decided, `neutral` (chosen, numbers)
        holds. `coming` (lanes, turns, numbers) is what runs read.
        """
        self._born[chosen], self._neutral[chosen] = self._step + 1, neutral
        coming[chosen] = neutral[:, np.newaxis]

    def step(self, longest: int) -> None:
        """All lanes go on; no run has more than `longest` steps."""
        self._step += 1
        rows = len(self._log)
        needed = min(self._step - int(self._born.min()), longest) + 2  # one more: a run that has ended rests for a step
        if needed > rows:
            wider = np.zeros((max(needed, min(rows + rows // 2, longest + 2)), *self._log.shape[1:]))
            for step in range(max(0, self._step - rows), self._step):
                wider[step % len(wider)] = self._log[step % rows]
            self._log = wider

    def decide(self, number: int, chosen: Bools, samples: Ints, actions: Floats, coming: Floats) -> None:
        """Let the control of this number do `actions` (lanes, a) in the chosen lanes, now or from its delay on."""
        its = self._columns[number]
        np.copyto(self._log[self._step % len(self._log), :, its], actions, where=chosen[:, np.newaxis])
        lane = np.flatnonzero(chosen)
        first, given = samples[lane] + self._delay[number], actions[lane]
        for later in range(self.every[number]):
            coming[lane, (first + later) % coming.shape[1], its] = given

    def decided(self, chosen: Ints, samples: Ints, length: int) -> Floats:
        """(chosen, length, numbers): what was decided for each turn in the chosen lanes, which are at `samples`
        (chosen,); what was decided last goes on.
        """
        out = np.repeat(self._neutral[chosen][:, np.newaxis], length, axis=1)
        for its, every, delay in zip(self._columns, self.every, self._delay, strict=True):
            held = max(length - delay, 0)
            number = np.minimum(np.arange(-(-held // every)), ((samples - 1) // every)[:, np.newaxis])
            row = (self._born[chosen][:, np.newaxis] + number * (every // self._pause)) % len(self._log)
            found = self._log[row, chosen[:, np.newaxis], its]
            nothing = samples == 0
            found[nothing] = self._neutral[chosen[nothing], np.newaxis, its]
            out[:, delay:, its] = np.repeat(found, every, axis=1)[:, :held]
        return out
