"""Scenic source: the scenario with every value fixed, in the words that Scenic 3 shares with this language.

`write.py` puts a file together and looks at it again, `write_statements.py` and `write_expressions.py` say how each
construct is written there, `scenic_names.py` what is called otherwise or is not there, and how Scenic finds a lane of
ours in the exported road.

Source: Scenic 3.1, language reference and driving library (https://docs.scenic-lang.org).
"""

from cortex_dsl.interchange.scenic.write import refuse_left_hand, write_scenic

__all__ = ["refuse_left_hand", "write_scenic"]
