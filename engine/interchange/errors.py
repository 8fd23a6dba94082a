"""What is wrong with a file from elsewhere, or with the wish to write one."""


class InterchangeError(Exception):
    """A file that cannot be read, or a case that a format cannot carry: what is wrong, where, and what to do."""

    def __init__(self, message: str, cure: str, place: str = "") -> None:
        self.message = message
        self.cure = cure
        self.place = place
        """File, and line or element where one is known: `case.xosc, line 12`."""
        super().__init__(f"{place + ': ' if place else ''}{message} ({cure})")
