"""Studies: many runs of several methods on several scenarios, each stored whole, compared run by run.

    plan ──execution──▶ RunRecord of each run ──database──▶ study.sqlite
                              │
                              └─▶ comparisons, curves, verdict, study files

Nothing is imported here. To write a study in Python, use `plan.Plan`, `execution.perform_all`,
`comparisons.compare_all`.
"""
