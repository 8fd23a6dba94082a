"""What the finite choices of a variant are called, and which of them are lanes that its scenes draw."""

from collections.abc import Sequence
from itertools import chain, count

from engine.program import DrawSite, VariantLabel


def drawn_lanes(label: VariantLabel) -> list[DrawSite]:
    """The lanes that a scene of the variant draws."""
    return [site for site in label.sites if site.kind == "lane"]


def choice_names(label: VariantLabel) -> list[str]:
    """What the choices of a variant are called, those of lanes that its scenes draw behind them; no two alike."""
    return numbered([*(choice.name for choice in label.choices), *(site.unit or "lane" for site in drawn_lanes(label))])


def numbered(names: Sequence[str]) -> list[str]:
    """Names of which no two are equal: the second `a` is `a 2`."""
    taken = dict[str, None]()
    for name in names:
        further = (f"{name} {number}" for number in count(2))
        taken[next(each for each in chain([name], further) if each not in taken)] = None
    return list(taken)
