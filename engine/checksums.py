"""Files that contain their own checksum, and the link of the journal or study from which they were written, if any.

A JSON document begins with the fields of `stamp`; a page has them as `<meta>`. The checksum is the BLAKE2b digest of
the whole file with zeros in its place, so that every changed byte shows, in every folder.
"""

import re
from hashlib import blake2b

NO_CHECKSUM = "0" * 32
"""Placeholder of an unknown checksum."""
_CHECKSUM = re.compile(rb'\bchecksum"(?:: | content=)"([0-9a-f]{32})"')
_JOURNAL = re.compile(rb'\bjournal"(?:: | content=)"([0-9a-f]*)"')


def stamp(journal: str = "") -> dict[str, str]:
    """Return the first fields of a document, for `with_checksum`; `journal` is the last link of the journal's chain."""
    return {"checksum": NO_CHECKSUM, **({"journal": journal} if journal else {})}


def with_checksum(content: str) -> bytes:
    """Return the file of a text whose first checksum is `NO_CHECKSUM`.

    Raises:
        ValueError: there is no such place.
    """
    file = content.encode()
    found = _CHECKSUM.search(file)
    if found is None or found[1] != NO_CHECKSUM.encode():
        raise ValueError("there is no place for a checksum")
    return _replaced(file, found, _digest(file))


def has_checksum(file: bytes) -> bool:
    """Return True if a file names a checksum; those of earlier versions do not."""
    return _CHECKSUM.search(file) is not None


def is_unchanged(file: bytes) -> bool:
    """Return True if a file has the checksum of its content."""
    found = _CHECKSUM.search(file)
    return found is not None and found[1] == _digest(_replaced(file, found, NO_CHECKSUM.encode()))


def journal_of(file: bytes) -> str:
    """Return the link of the journal from which a file was written; "" if the file names none."""
    found = _JOURNAL.search(file)
    return "" if found is None else found[1].decode()


def _replaced(file: bytes, place: re.Match[bytes], checksum: bytes) -> bytes:
    return file[: place.start(1)] + checksum + file[place.end(1) :]


def _digest(file: bytes) -> bytes:
    return blake2b(file, digest_size=len(NO_CHECKSUM) // 2).hexdigest().encode()
