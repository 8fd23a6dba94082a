"""Scenic source: the scenario with every value fixed, in the constructs that Scenic 3 shares with this language.

`write.py` assembles a file and checks it, `write_statements.py` and `write_expressions.py` translate each construct,
`scenic_names.py` contains different or missing names, and how Scenic finds a lane of ours in the exported road.

Source: Scenic 3.1, language reference and driving library (https://docs.scenic-lang.org).
"""

from cortex_dsl.interchange.scenic.write import refuse_left_hand, write_scenic

__all__ = ["refuse_left_hand", "write_scenic"]
