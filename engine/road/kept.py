"""What is found out about a network once, and kept as long as the network is there."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from engine.road.network import Network

Found = TypeVar("Found")


def kept(find: Callable[[Network], Found]) -> Callable[[Network], Found]:
    """`find`, which each network is asked once; what it finds must not refer to the network, or both stay for ever."""
    found: WeakKeyDictionary[Network, Found] = WeakKeyDictionary()

    @wraps(find)
    def asked(network: Network) -> Found:
        if network not in found:
            found[network] = find(network)
        return found[network]

    return asked
