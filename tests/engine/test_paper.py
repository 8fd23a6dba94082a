"""The paper's arithmetic."""

from engine.paper import GA, METHODS, RANDOM, SCENARIOS, STUDIES, by_assumption, claims, said


def test_every_row_has_its_six_numbers() -> None:
    """One number for each scenario; the last ten generations are part of the thirty."""
    for method in METHODS.values():
        rows = (method.rl, method.nc, method.nc_last, method.mdg_last, method.mdec_last, method.nis, method.nis_last)
        assert all(len(row) == len(SCENARIOS) for row in rows)
        assert all(last <= total for last, total in zip(method.nc_last, method.nc, strict=True))
        assert all(last <= total for last, total in zip(method.nis_last, method.nis, strict=True))


def test_what_holds_and_what_does_not() -> None:
    """The totals agree with their parts; the contradictions known from reading are found."""
    found = {claim.says: claim for claim in claims()}
    assert found["total collisions of GA"].holds
    assert found["total collisions of random"].holds
    assert found["total valid runs of GA"].holds
    assert found["mean of the six increases of RL"].holds
    wrong = {says for says, claim in found.items() if not claim.holds}
    assert "RL rises from 7.75 to 9.54" in wrong
    assert "decrease of invalid runs by the GA (abstract, conclusion)" in wrong
    assert "the GA has fewer invalid runs in E" in wrong
    assert "the GA has the higher share of collisions among valid runs in A" in wrong
    assert "a score of 12 may consist of a collision (10) and 2 other points" in wrong
    assert sum("if an invalid run counts as -1" in says for says in wrong) == 2
    assert sum("follows from MDEC and the number of collisions" in says for says in wrong) == 12


def test_what_is_inferred_is_no_claim_of_the_paper() -> None:
    """Twelve rows rest on one assumption of ours, and are one cause; none of them counts among what the paper says."""
    found = claims()
    causes = by_assumption(found)
    assert [claim.holds for claim in causes["MDG counts a collision as 0 m"]] == [False] * 12
    assert len(causes["an invalid run counts as -1 in RL"]) == 2
    assert len(said(found)) + sum(map(len, causes.values())) == len(found)
    wrong = [claim.says for claim in said(found) if not claim.holds]
    assert not any("follows from MDEC" in says or "if an invalid run" in says for says in wrong)
    assert "the GA has fewer invalid runs in E" not in wrong  # where the paper says "less favorable"


def test_the_next_best_study_is_not_the_best() -> None:
    """18.1 % is 36 % above 13.3 %, but the paper's own table has 30.7 %."""
    found = {claim.says: claim for claim in claims()}
    assert found["collision rate of 18.1 % relative to the 13.3 % of Zhou et al. 2023"].holds
    assert not found["no other study has a collision rate above 13.3 %"].holds
    assert any("30.7 %" in study.collisions for study in STUDIES)


def test_a_changed_number_changes_a_verdict() -> None:
    """The sums are really taken: the printed totals are those of these rows alone."""
    assert sum(GA.nc) == 3249
    assert sum(RANDOM.nc) == 2482
    assert sum(GA.valid) == 13569
