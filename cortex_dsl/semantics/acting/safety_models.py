"""Models of safe driving around another behaviour: it drives; in a risk that the model detects, the actor brakes.

*Responsibility-sensitive safety*: Shalev-Shwartz, Shammah and Shashua (2017), "On a formal model of safe and scalable
self-driving cars", arXiv:1708.06374. Nearer than the distances of definitions 1, 2 and 6 the proper response is to
brake by at least `least_braking`. On crossing routes no actor has the right of way here: before the area in which both
may be together, the actor must still be able to stop after the response time. Parameters are those with which CARLA
runs Intel's ad-rss-lib.

*The careful driver* of UN Regulation 157, Annex 4, Appendix 3: an actor is a risk if it is 0.375 m off the middle of
its lane towards the ego's lane, or in that lane, and would be hit in less than 2 s, or if it brakes by more than 5
m/s^2 within 2 s of headway. It is perceived for 0.4 s, 0.75 s later braking begins and builds up by 12.65 m/s^3 to
0.774 g.

*The fuzzy safety model* of the same regulation: Mattas, Makridis, Botzoris et al. (2020), "Fuzzy surrogate safety
metrics for real-time assessment of rear-end collision risk", Accident Analysis and Prevention 148, 105794. With u and
u_l the speeds, t = 0.75 s, 4 and 6 m/s^2 of comfortable and hard braking, 7 m/s^2 of the vehicle ahead, d = 2 m, PFS
falls from 1 to 0 as the gap less d grows from u t + u^2 / (2 * 6) - u_l^2 / (2 * 7) to u t + u^2 / (2 * 4) - u_l^2 / (2
* 7) + d; CFS, while closing, from g + c^2 / (2 * 6) to g + c^2 / (2 * 4), g being the loss of gap within t and c the
speed at which it then still shrinks. Braking is PFS * 4 m/s^2, and where CFS > 0 it is 4 + CFS * 2 m/s^2.

Both models of the regulation cover one lane. Where ways cross (*ours*), an actor that the careful driver would meet
within 4 s is a risk, as in `engine.avoidability`, and the fuzzy model treats the area of the meeting as a standing
vehicle.

The models are Python, not text of the language: as text, RSS and the fuzzy model drove the same scenes to the last bit,
but 198 lines of text and 89 of Python replaced 147 lines, and `--check` of a file with 12 variants took 1.2 and 1.3
times as long. The careful driver cannot be text, because it stores a number for each other actor, and a variable of a
behavior holds one number.
"""

from cortex_dsl import ir
from cortex_dsl.semantics.acting.braking import (
    STANDSTILL,
    Targets,
    blocked,
    ground_speed,
    inner_acts,
    is_target,
    latest_arrival,
    moves,
    stays_close,
    waits,
)
from cortex_dsl.semantics.acting.foreseeing import (
    EVERYWHERE,
    LEAST_LINE,
    SLACK,
    Extent,
    Sight,
)
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.acting.partners import Beside, Seen, partners_of
from cortex_dsl.semantics.evaluation.geometry import is_present, others, size_of, state
from cortex_dsl.semantics.model.values import Actor
from cortex_dsl.semantics.quantities.algebra import (
    Term,
    maximum,
    minimum,
    where,
)
from engine.vocabulary import State

GRAVITY = 9.81
JERK = 12.65
"""Rate at which braking builds up in both models of UN R157 [m/s^3]."""
NOT_RISKY = -1.0
"""Value of the start time of a risk while there is no risk."""


def _brake(job: Job, while_: Term, deceleration: Term, note: ir.Block = ()) -> ir.Act:
    pedal = minimum(1.0, deceleration / size_of(job.actor, "maxBraking"))
    return ir.Loop(job.call.span, while_, (*note, job.braking(pedal)))


def _must_wait(job: Job) -> Term:
    """Return whether to wait before an area, or behind another actor."""
    sight = Sight.of(job)
    return job.ev.algebra.any_of([waits(job, each, sight) for each in others(job.ev, job.actor)]) | blocked(job)


# -- responsibility-sensitive safety -----------------------------------------------------------------------------------

RESPONSE = 1.0
SPEEDING_UP = 3.5
LEADER_BRAKING = 8.0
LEAST_BRAKING = 4.0
IN_LANE_BRAKING = 3.0
DRIFTING, DRIFT_BRAKING, DRIFT_MARGIN = 0.2, 0.8, 0.1
"""Lateral acceleration and braking [m/s^2], and lateral margin [m], of `engine.metrics.values.RESPONSIBILITY`; a test
compares them.
"""


def responsibility(job: Job) -> ir.Block:
    """Another behaviour; the proper response while a situation is dangerous."""
    seen = partners_of(job, lambda other: _extent_of_response(job, other))
    dangerous = job.ev.algebra.any_of([_is_dangerous(job, each) for each in seen]) & moves(job)
    needed = job.ev.algebra.literal(0.0)
    for each in seen:
        # Braking by least_braking suffices if the actor held the distance, but not if another actor has cut it short.
        stopping = job.speed() * job.speed() / (2.0 * maximum(each.gap - LEAST_LINE, LEAST_LINE))
        shrinking = maximum(each.closing, 0.0)
        keeping = shrinking * shrinking / (2.0 * maximum(each.gap, LEAST_LINE))
        needed = maximum(needed, where(each.crosses, stopping, where(each.in_lane, keeping, 0.0)))
    braking = maximum(needed, job.number("least_braking", LEAST_BRAKING))
    brake = _brake(job, dangerous | _must_wait(job), braking)
    return (ir.TryInterrupt(job.call.span, inner_acts(job), ((dangerous, (brake,)),)),)


def _extent_of_response(job: Job, other: Actor) -> Extent:
    """Return the greatest distances of definitions 1 and 2, and those at which `least_braking` no longer suffices."""
    mine, theirs = abs(job.speed()), ground_speed(job, other)
    near = _stopping(job, mine, _least(job)) + (LEAST_LINE + SLACK)
    oncoming = _stopping(job, mine, IN_LANE_BRAKING) + _stopping(job, theirs, _least(job))
    both = (mine + theirs) * (mine + theirs) / (2.0 * _least(job))
    return Extent(near, maximum(oncoming, both) + SLACK)


def _is_dangerous(job: Job, seen: Seen) -> Term:
    speed, gap = job.speed(), seen.gap
    following = seen.in_lane & seen.conflict.is_ahead & (gap < _safe_behind(job, seen.speed))
    meeting = seen.in_lane & seen.conflict.comes & (gap < _safe_oncoming(job, -seen.speed))
    dangerous = following | meeting | (seen.crosses & (gap < _stopping(job, speed, _least(job)) + LEAST_LINE))
    if (beside := seen.beside) is None:
        return dangerous
    near = (beside.ahead >= 0.0) & (beside.ahead < _safe_behind(job, beside.speed))
    return dangerous | (
        is_present(job.ev, seen.other) & near & beside.comes_over & (beside.apart < _safe_beside(job, beside.nearing))
    )


def _least(job: Job) -> Term:
    return job.number("least_braking", LEAST_BRAKING)


def _stopping(job: Job, speed: Term, braking: Term | float, speeding_up: float = SPEEDING_UP) -> Term:
    """Return the stopping distance [m] with acceleration during the response time."""
    response = job.number("response", RESPONSE)
    faster = speed + response * speeding_up
    return 0.5 * (speed + faster) * response + faster * faster / (2.0 * braking)


def _safe_behind(job: Job, leading: Term) -> Term:
    """Definition 1 [m]."""
    lead = maximum(leading, 0.0)
    stop = lead * lead / (2.0 * job.number("leader_braking", LEADER_BRAKING))
    return maximum(_stopping(job, job.speed(), _least(job)) - stop, 0.0)


def _safe_oncoming(job: Job, oncoming: Term) -> Term:
    """Definition 2: I am in my own lane [m]."""
    theirs = _stopping(job, maximum(oncoming, 0.0), _least(job))
    return _stopping(job, job.speed(), IN_LANE_BRAKING) + theirs


def _safe_beside(job: Job, nearing: Term) -> Term:
    """Return the safe lateral distance [m] of definition 6 to an actor that comes nearer, if the ego does not."""
    still = job.ev.algebra.literal(0.0)
    return sum((_stopping(job, each, DRIFT_BRAKING, DRIFTING) for each in (nearing, still)), DRIFT_MARGIN + still)


# -- the models of UN R157: a risk is seen for some time, then brakes build up -----------------------------------------


def _after_a_while(
    job: Job, risk: Term, late: Term, on: Term, deceleration: Term, targets: Targets | None = None
) -> ir.Block:
    """The behaviour that is given; once there has been a risk for some time brakes, as long as `on`."""
    algebra, span = job.ev.algebra, job.call.span
    number = job.ev.run.new_local()
    since, now = algebra.local(number), algebra.time()
    forget = ir.SetLocal(span, number, algebra.literal(NOT_RISKY))
    for_long = now - since
    begun = (since >= 0.0) & moves(job) & (for_long >= late - 1e-9)
    ramped = JERK * (for_long - late)
    never, note = ((), ()) if targets is None else (targets.forget, targets.note)
    handlers = (
        (risk & (since < 0.0), (ir.SetLocal(span, number, now),)),
        (~risk & (since >= 0.0), (forget,)),
        (begun, (*note, _brake(job, on, minimum(deceleration, ramped), note), forget)),
    )
    first = () if targets is None else (targets.gone,)
    return (*never, forget, ir.TryInterrupt(span, inner_acts(job), (*first, *handlers)))


PERCEPTION = 0.4
DELAY = 0.75
"""Delay in both models [s]."""
HARDEST = 0.774 * GRAVITY
DEVIATION = 0.375
CRITICAL = 2.0
"""Time to collision below which an actor is a risk, and headway to an actor that brakes by `ALARMING` [s]."""
ALARMING = 5.0
HORIZON = 4.0
"""Time to arrival below which crossing traffic is a risk [s], as in `engine.avoidability`."""


def careful_driver(job: Job) -> ir.Block:
    """Another behaviour; the brakes of UN R157's careful human driver while there is a risk."""
    numbers = {other.index: job.ev.run.new_local() for other in others(job.ev, job.actor)}
    seen = partners_of(job, lambda other: _extent_of_risk(job, other).unless(is_target(job, numbers[other.index])))
    sight = Sight.of(job)
    risks = [_is_risk(job, each) for each in seen]
    targets = Targets.of(
        job, [*numbers.values()], risks, [is_present(job.ev, each.other) & each.conflict.exists for each in seen]
    )
    risk = job.ev.algebra.any_of(risks) & moves(job)
    stays = job.ev.algebra.any_of([stays_close(job, each.other, sight) for each in seen])
    goes_on = stays | targets.block(job, [(each.other, each.conflict) for each in seen]) | blocked(job)
    late = job.number("perception", PERCEPTION) + job.number("delay", DELAY)
    hardest = job.number("reference_deceleration", HARDEST)
    # Afterwards it does not speed up behind an actor within that headway.
    near = job.ev.algebra.any_of([each.in_lane & (each.gap < job.speed() * CRITICAL) for each in seen])
    brakes = risk | goes_on
    return _after_a_while(job, risk, late, brakes | near, where(brakes, hardest, 0.0), targets)


def _extent_of_risk(job: Job, other: Actor) -> Extent:
    """Return the greatest distances of a risk, or of an actor ahead behind which the driver does not speed up."""
    speed = abs(job.speed())
    return Extent(speed * HORIZON + SLACK, (speed + ground_speed(job, other)) * CRITICAL + SLACK)


def _is_risk(job: Job, seen: Seen) -> Term:
    conflict, speed = seen.conflict, job.speed()
    soon = seen.gap < seen.closing * CRITICAL
    brakes = state(job.ev, seen.other, State.ACCELERATION) < -ALARMING
    alarming = conflict.is_ahead & brakes & (seen.gap < speed * CRITICAL)
    meets = seen.crosses & (latest_arrival(job, seen.other, conflict) < HORIZON)
    risk = (seen.in_lane & (soon | alarming)) | meets
    if (beside := seen.beside) is None:
        return risk
    cuts_in = (beside.ahead >= 0.0) & (beside.ahead < (speed - beside.speed) * CRITICAL)
    cuts_in = cuts_in & beside.comes_over & (beside.deviation > DEVIATION)
    return risk | (is_present(job.ev, seen.other) & cuts_in & (beside.apart < NEXT_LANE))


NEXT_LANE = 3.5
"""Lateral gap from which an actor is not in a neighbouring lane [m]; *ours*."""
COMFORTABLE, HARD, THEIRS = 4.0, 6.0, 7.0
"""Braking of the fuzzy model's vehicle, comfortable and hard, and braking of the vehicle ahead [m/s^2]."""
ROOM = 2.0
"""Gap at rest in the fuzzy model [m]."""
SPARE = 0.1
"""Time margin by which crossing traffic must arrive after the ego [s]."""


def fuzzy_safety(job: Job) -> ir.Block:
    """Another behaviour; brakes by how unsafe the fuzzy model finds the situation."""
    # An actor that merges is a risk only while no area with it is known, wherever that area is.
    seen = partners_of(job, lambda _: EVERYWHERE)
    braking = job.ev.algebra.literal(0.0)
    for each in seen:
        braking = maximum(braking, _reaction(job, each))
    risk = (braking > 0.0) & moves(job)
    on = risk | _must_wait(job)
    # A waiting actor does not roll.
    held = where(risk, braking, job.number("comfortable_deceleration", COMFORTABLE))
    return _after_a_while(job, risk, job.number("delay", DELAY), on, held)


def _reaction(job: Job, seen: Seen) -> Term:
    """Return the braking for another actor [m/s^2]."""
    lead = where(seen.in_lane, maximum(seen.speed, 0.0), 0.0)
    counts, gap = seen.in_lane | seen.crosses, seen.gap
    if (beside := seen.beside) is not None:
        cuts_in = is_present(job.ev, seen.other) & _cuts_in(job, seen.other, beside) & ~counts
        lead, gap = where(cuts_in, beside.speed, lead), where(cuts_in, beside.ahead, gap)
        counts = counts | cuts_in
    return where(counts, _fuzzy(job, minimum(gap, 1e4), lead), 0.0)


def _cuts_in(job: Job, other: Actor, beside: Beside) -> Term:
    """Return whether another actor reaches the ego's side before the ego has passed it."""
    long = size_of(job.actor, "length") + size_of(other, "length")
    closing = job.speed() - beside.speed
    before = beside.apart * closing < beside.nearing * (beside.ahead + long + SPARE * closing)
    return (beside.ahead >= 0.0) & beside.comes_over & (closing > STANDSTILL) & before


def _fuzzy(job: Job, gap: Term, lead: Term) -> Term:
    """Braking by PFS and CFS for one ahead [m/s^2]."""
    late, speed = job.number("delay", DELAY), job.speed()
    soft = job.number("comfortable_deceleration", COMFORTABLE)
    hard = job.number("reference_deceleration", HARD)
    stop = lead * lead / (2.0 * job.number("leader_braking", THEIRS))
    reach = speed * late - stop
    square = speed * speed
    proactive = _share(gap - ROOM, reach + square / (2.0 * hard), reach + square / (2.0 * soft) + ROOM)
    now = maximum(state(job.ev, job.actor, State.ACCELERATION), -soft)
    after = speed + late * now
    gone = (speed + 0.5 * late * now - lead) * late
    left = after - lead
    critical = _share(gap, gone + left * left / (2.0 * hard), gone + left * left / (2.0 * soft))
    # A vehicle that is slower than the other within the delay still covers (u - u_l)^2 / 2 a until then.
    slowed = where(gap < (speed - lead) * (speed - lead) / (2.0 * maximum(-now, 1e-6)), 1.0, 0.0)
    critical = where(speed <= lead, 0.0, where(left < 0.0, slowed, critical))
    return where(critical > 0.0, soft + critical * (hard - soft), proactive * soft)


def _share(gap: Term, unsafe: Term, safe: Term) -> Term:
    """Return 1 up to an unsafe gap, 0 from a safe one on, and a linear value between."""
    part = (safe - gap) / maximum(safe - unsafe, 1e-6)
    return where(gap < unsafe, 1.0, minimum(1.0, maximum(0.0, part)))
