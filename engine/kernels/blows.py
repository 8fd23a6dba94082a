"""What a run keeps of impacts among others, and for how long two of them are one."""

from enum import IntEnum


class Blow(IntEnum):
    """Columns of `Run.impacts`: an impact between two others, the lower actor first."""

    TIME = 0
    """[s]"""
    ONE = 1
    OTHER = 2
    X = 3
    """Middle of the contact [m]."""
    Y = 4
    VX_ONE = 5
    """Velocity of each before, and by how much it changed while they were in contact, by whomever it was [m/s]."""
    VY_ONE = 6
    VX_OTHER = 7
    VY_OTHER = 8
    CHANGE_X_ONE = 9
    CHANGE_Y_ONE = 10
    CHANGE_X_OTHER = 11
    CHANGE_Y_OTHER = 12
    HEADING_ONE = 13
    """[rad]"""
    HEADING_OTHER = 14
    X_ONE = 15
    """Centre of each [m]."""
    Y_ONE = 16
    X_OTHER = 17
    Y_OTHER = 18
    LAST = 19
    """When the two last touched; contact again within `PAUSE` is still the same impact [s]."""


MAX_BLOWS = 64
"""Impacts among others that a run keeps; later ones happen and are not kept."""
PULSE = 0.25
"""Impulses count for so long from the first touch [s], whether two stay in contact or part and meet again: the crash
pulses of cars are over by then, and what is pushed along for longer fights the friction of its tyres."""
PAUSE = 0.05
"""Two bodies that part after that and meet again sooner than this are still in the same impact [s]."""
