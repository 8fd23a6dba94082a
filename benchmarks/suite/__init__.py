"""Scenarios with competent egos, fair starts and known rates of failure: which searcher finds what is rare?

    python -m benchmarks.suite --truth --count 200000            # more plain draws, added to truth.json
    python -m benchmarks.suite --methods random,ga,best_first --runs 30 --budget 3000
    python -m benchmarks.suite                                   # the tables of what is kept

In every file the ego brakes for whatever is about to be struck, and gives way or keeps its distance; others that could
be in its way start 40 m away or more (in `outside_cut_in`, all but the car on the next lane to the left). A failure is
a collision that is no fault of another (`engine.vocabulary.Fault`). Its mechanism is whom the ego met and on which side
of itself, or the planted defect that it came from. README.md says what the groups of files are for.
"""
