"""Scenic source: the scenario with every value fixed, in the words that Scenic 3 shares with this language.

`writing.py` puts a file together, `statements.py` and `expressions.py` say how each construct is written there,
`places.py` how Scenic finds a lane of ours in the exported road, `words.py` what is called otherwise or is not there.

Source: Scenic 3.1, language reference and driving library (https://docs.scenic-lang.org).
"""

from cortex_dsl.exports.scenic.writing import files

__all__ = ["files"]
