"""Cache of results per network, for the lifetime of the network."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from engine.road.network import Network

Found = TypeVar("Found")


def kept(find: Callable[[Network], Found]) -> Callable[[Network], Found]:
    """Return `find` with a cache per network. A result must not refer to its network, or both are never freed."""
    found: WeakKeyDictionary[Network, Found] = WeakKeyDictionary()

    @wraps(find)
    def asked(network: Network) -> Found:
        if network not in found:
            found[network] = find(network)
        return found[network]

    return asked
