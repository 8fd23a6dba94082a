"""ASAM's checker of OpenDRIVE, asked for the issues of its report: its command ends with 0 whatever it found."""

from answering import answer
from qc_baselib import Configuration, Result, StatusType
from qc_opendrive import constants, main


def check(job: dict) -> list[str]:
    """Every issue of any level, and every check that broke down or was left out for want of an earlier one."""
    config, result = Configuration(), Result()
    config.set_config_param("InputFile", job["file"])
    result.register_checker_bundle("", constants.BUNDLE_NAME, constants.BUNDLE_VERSION)
    main.run_checks(config, result)
    found = []
    for checker in result.get_checker_results(constants.BUNDLE_NAME):
        found += [f"{issue.rule_uid}: {issue.description} {places(issue)}".strip() for issue in checker.issues]
        if checker.status is StatusType.ERROR or "Preconditions" in checker.summary:
            found.append(f"{checker.checker_id}: {checker.summary}")
    return found


def places(issue: object) -> str:
    """What the report says of where it is."""
    return "; ".join(each.description for each in issue.locations)


answer(check)
