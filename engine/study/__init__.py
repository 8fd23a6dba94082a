"""Studies: many runs of several methods on several scenarios, each run kept whole, compared run by run.

    plan ──execution──▶ RunRecord of each run ──database──▶ study.sqlite
                              │
                              └─▶ comparisons, curves, verdict, study files

Nothing is imported here. A study of your own: `plan.Plan`, `execution.perform_all`, `comparisons.compare_all`.
"""
