"""Names of the finite choices of a variant, and those of its sampled lanes."""

from collections.abc import Sequence
from itertools import chain, count

from engine.program import DrawSite, VariantLabel


def drawn_lanes(label: VariantLabel) -> list[DrawSite]:
    """Return the lanes that a scene of the variant samples."""
    return [site for site in label.sites if site.kind == "lane"]


def choice_names(label: VariantLabel) -> list[str]:
    """Return the unique names of a variant's choices, followed by those of its sampled lanes."""
    return numbered([*(choice.name for choice in label.choices), *(site.unit or "lane" for site in drawn_lanes(label))])


def numbered(names: Sequence[str]) -> list[str]:
    """Return unique names: the second `a` is `a 2`."""
    taken = dict[str, None]()
    for name in names:
        further = (f"{name} {number}" for number in count(2))
        taken[next(each for each in chain([name], further) if each not in taken)] = None
    return list(taken)
