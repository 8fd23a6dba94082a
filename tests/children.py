"""What a process that a test starts does before anything else."""

import ctypes
import os
import signal

CAPABILITY_VERSION, OVERRIDES = 0x20080522, (1 << 1) | (1 << 2)
"""Of the layout of `capset`; CAP_DAC_OVERRIDE and CAP_DAC_READ_SEARCH. Source: linux/capability.h."""


def hear_interrupts() -> None:
    """Let Ctrl-C end this process, though a shell that runs the tests in the background has it ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def obey_modes() -> None:
    """Give up root's right to overrule the modes of files, until another program is executed. Source: capset(2)."""
    if os.geteuid() == 0:
        libc = ctypes.CDLL(None, use_errno=True)
        header, sets = (ctypes.c_uint32 * 2)(CAPABILITY_VERSION, 0), (ctypes.c_uint32 * 6)()
        assert libc.capget(header, sets) == 0
        for effective_or_permitted in (0, 1):
            sets[effective_or_permitted] &= ~OVERRIDES
        assert libc.capset(header, sets) == 0
