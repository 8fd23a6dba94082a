"""The colours of every view, named once. Only the terminal's own sixteen, so that its theme decides the shades."""

from rich.theme import Theme

THEME = Theme(
    {
        "title": "bold",
        "quiet": "bright_black",
        "unit": "bright_black",
        "road": "bright_black",
        "good": "green",
        "bad": "bold red",
        "warn": "yellow",
        "bar": "blue",
        "part.C": "red",
        "part.MD": "yellow",
        "part.D_MS": "magenta",
        "part.TTC_MS": "blue",
        "actor.0": "bold cyan",
        "actor.1": "bold magenta",
        "actor.2": "bold yellow",
        "actor.3": "bold green",
        "actor.4": "bold blue",
        "actor.5": "bold white",
        # the marks that rich.progress uses
        "bar.complete": "blue",
        "bar.finished": "blue",
        "bar.back": "bright_black",
    }
)

ACTOR_STYLES = 6


def actor_style(actor: int) -> str:
    """The style of an actor: the ego is always the same, many actors share the rest."""
    return f"actor.{actor if actor == 0 else 1 + (actor - 1) % (ACTOR_STYLES - 1)}"


def method_style(name: str) -> str:
    """The style of a search method, from its row; those of other packages share one."""
    from engine.search.methods.table import PLUGIN_STYLE, SEARCHERS  # not for those who only read the language

    return SEARCHERS[name].style if name in SEARCHERS else PLUGIN_STYLE
