"""Studies: many runs of several methods on several scenarios, each run kept whole, compared run by run.

    plan ──execution──▶ RunRecord of each run ──store──▶ study.sqlite
                              │
                              └─▶ comparisons, curves, rates, exports

Nothing is imported here. A study of your own: `plan.Plan`, `execution.perform_all`, `comparisons.compare_all`.
"""
