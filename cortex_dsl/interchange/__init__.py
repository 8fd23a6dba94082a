"""Cases for other tools: the case, the table of formats, and the formats that need the language.

`engine.interchange` writes, reads and checks formats of motion alone, from a recording; `formats.py` names all formats.
"""
