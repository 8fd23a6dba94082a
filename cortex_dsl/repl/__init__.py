"""`cortexc repl`: a scenario written entry by entry, each checked and weighed as soon as it is there.

reading -> entering (splitting, placing, checking) -> weighing, or a command of the table in `commands`.
"""
