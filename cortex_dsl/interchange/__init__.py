"""Found cases for other people's tools: what a case is, the table of formats, and the formats that need the language.

Formats that know motion only are written, read and checked by `engine.interchange`, from a recording; `formats.py`
names them all.
"""
