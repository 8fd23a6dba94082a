"""ASAM's checkers, asked for the issues of their reports: their commands end with 0 whatever they found."""

from collections.abc import Callable
from types import ModuleType

from answering import answer
from qc_baselib import Configuration, Result, StatusType


def answer_by(constants: ModuleType, run_checks: Callable[[Configuration, Result], None]) -> None:
    """Answer all jobs with one bundle of checks."""
    answer(lambda job: issues(job, constants, run_checks))


def issues(job: dict, constants: ModuleType, run_checks: Callable[[Configuration, Result], None]) -> list[str]:
    """Every issue of any level, and every check that broke down or was left out for want of an earlier one."""
    config, result = Configuration(), Result()
    config.set_config_param("InputFile", job["file"])
    result.register_checker_bundle("", constants.BUNDLE_NAME, constants.BUNDLE_VERSION)
    run_checks(config, result)
    found = []
    for checker in result.get_checker_results(constants.BUNDLE_NAME):
        found += [f"{issue.rule_uid}: {issue.description} {places(issue)}".strip() for issue in checker.issues]
        if checker.status is StatusType.ERROR or "Preconditions" in checker.summary:
            found.append(f"{checker.checker_id}: {checker.summary}")
    return found


def places(issue: object) -> str:
    """What the report says of where it is."""
    return "; ".join(each.description for each in issue.locations)
