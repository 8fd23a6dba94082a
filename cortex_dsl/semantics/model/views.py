"""Field of view of an object or a place, without occlusion."""

from cortex_dsl.semantics.quantities.algebra import Term
from engine.frozen import frozen


@frozen
class View:
    """How far [m], and within which opening angle about its heading [rad]."""

    reach: Term
    opening: Term
