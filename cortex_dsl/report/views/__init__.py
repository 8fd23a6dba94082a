"""The views: one function each, from findings to blocks (`cortex_dsl.report.blocks`)."""
