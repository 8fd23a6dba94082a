"""Controllers of a program's controls, their questions, and checks of their answers.

A controller is a function of observations (n, d) to actions (n, a), or an object with a memory:

    reset(lanes, keys)               new scenes begin in these slots (m,); `keys` (m, 6) are their stream keys
    act(observations, active)        actions (n, a); rows of slots that are not `active` (n,) are ignored
    meet(header)                     optional, called first: the header of the questions, as a process receives it
                                     (`engine.driving.stacks`)

Rows are slots of parallel runs, n of them at every call.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from inspect import signature
from typing import Any, Protocol, cast, runtime_checkable

import numpy as np

from engine.control import NO_WARNINGS, WARNING, Control, may_warn, turns
from engine.driving.observations import Named
from engine.driving.stacks import VERSION, Stack
from engine.driving.stepping import names_of
from engine.errors import ControllerError, CortexError, LostError, nearest
from engine.kernels.decision_pages import are_within
from engine.program import Program
from engine.tables import PLAIN, Bools, Floats, Ints

ROUNDED = 1e-6
"""Tolerance by which an action may exceed its range, relative to the end of the range, or absolute if that is below 1;
float32 has 24 bits.
"""
QUOTED = 300
"""Maximum number of characters quoted from an error."""


# -- controllers -------------------------------------------------------------------------------------------------------
@runtime_checkable
class Controller(Protocol):
    """A controller with a memory."""

    def reset(self, lanes: Ints, keys: Ints) -> None:
        """Begin new scenes in these slots."""
        ...

    def act(self, observations: Floats, active: Bools) -> Floats:
        """Return (n, a) actions."""
        ...


@dataclass(frozen=True)
class _Memoryless:
    """A function as a controller."""

    function: Callable[[Floats], Floats]

    def reset(self, lanes: Ints, keys: Ints) -> None:
        """Do nothing: a function has no memory."""

    def act(self, observations: Floats, active: Bools) -> Floats:
        del active
        return self.function(observations)


def controller_of(name: str, driver: object) -> Controller:
    """Return the controller of this name, as an object with `reset` and `act`.

    Raises:
        ControllerError: `driver` is neither a function of the observations nor such an object.
    """
    if isinstance(driver, Controller) and not isinstance(driver, type):
        for method, given in (("reset", "lanes, keys"), ("act", "observations, active")):
            _refuse_other_methods(name, driver, method, given)
        return driver
    if callable(driver) and not isinstance(driver, type):
        _refuse_other_arguments(name, driver)
        return _Memoryless(cast("Callable[[Floats], Floats]", driver))
    raise ControllerError(
        f"the controller `{name}` is not a function and lacks `reset` or `act`; its type is `{type(driver).__name__}`",
        "give a function of observations (n, d) to actions (n, a), or an object with `reset(lanes, keys)` and "
        "`act(observations, active)`",
    )


def _refuse_other_arguments(name: str, function: Callable[..., Any]) -> None:
    """Raise ControllerError unless a function can be called with the observations alone."""
    try:
        arguments = signature(function)
    except (TypeError, ValueError):  # compiled functions may have no signature
        return
    try:
        arguments.bind(None)
    except TypeError:
        raise ControllerError(
            f"the function for the controller `{name}` takes ({', '.join(arguments.parameters)})",
            "it is called with the observations (n, d) alone; to be told where scenes begin and which rows count, make "
            "it an object with `reset(lanes, keys)` and `act(observations, active)`",
        ) from None


def controllers_of(program: Program, given: object) -> tuple[Controller, ...]:
    """Return one controller for each control of a program, in its order.

    `given` is the controller of the ego, or of the only control, or a mapping from names to controllers.
    """
    names = names_of(program.controls)
    if not names:
        raise ControllerError(
            f"nobody in {program.name} is driven from outside, so that no controller is asked",
            "give the ego `with behavior ExternalBehavior(trajectory=…)` in place of its own, on the same trajectory; "
            "without one it goes along its lane",
        )
    several = isinstance(given, Mapping)
    drivers = cast("Mapping[str, object]", given) if several else {meant(program): given}
    for name in drivers:
        if name not in names:
            near = nearest(name, names)
            cure = f"did you mean `{near}`?" if near else f"name one of {', '.join(names)}"
            raise ControllerError(f"{program.name} has no controller `{name}`", cure)
    missing = [name for name in names if name not in drivers]
    if missing:
        raise ControllerError(
            f"nobody drives for the controller{'s' * (len(missing) > 1)} {', '.join(f'`{name}`' for name in missing)}",
            f"name who drives for each: `--ego {missing[0]}=python:module:function` on the command line, "
            "`ego={" + f'"{missing[0]}": …' + "}` in Python",
        )
    return tuple(controller_of(name, drivers[name]) for name in names)


def meant(program: Program) -> str:
    """Return the name of the default controller: the ego's, or the first."""
    return min(program.controls, key=lambda control: control.actor).controller


def _refuse_other_methods(name: str, driver: Controller, method: str, given: str) -> None:
    """Raise ControllerError unless a method can be called with the arguments `given`."""
    try:
        signature(getattr(driver, method)).bind(*given.split(", "))
    except ValueError:  # compiled functions may have no signature
        return
    except TypeError as error:
        raise ControllerError(
            f"`{method}` of the controller `{name}` cannot be called with ({given}): {error}",
            f"let it take them: `def {method}(self, {given})`",
        ) from None


# -- questions and answers ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ControllerSlot:
    """A control of the program with its controller."""

    control: Control
    controller: Controller

    def initialize(self, lanes: int, seen: Named, time_step: float) -> None:
        """Send a controller that has `meet` the header of its questions.

        Raises:
            LostError: it failed.
        """
        meet: Callable[[dict[str, Any]], None] | None = getattr(self.controller, "meet", None)
        if meet is None:
            return
        header = {
            "version": VERSION,
            "controller": self.control.controller,
            "lanes": lanes,
            "observations": [{"name": name, "unit": unit} for name, unit in seen],
            "actions": [asdict(action) for action in self.control.actions if action.name != WARNING],
            **({"warning": True} if may_warn(self.control) else {}),
            "time_step": time_step,
            "every": max(turns(self.control.every, time_step) * time_step, time_step),
        }
        self._ask(lambda: meet(header), "meet")

    def reset(self, lanes: Ints, keys: Ints) -> None:
        self._ask(lambda: self.controller.reset(lanes, keys), "reset")

    def act(self, observations: Floats, active: Bools, times: Floats) -> Floats:
        """Return the actions (n, a), checked in the `active` rows. `times` (n,) [s] of the samples are for messages."""
        return checked(self.control, self.answer(observations, active, times), active, times)

    def answer(self, observations: Floats, active: Bools, times: Floats) -> Floats:
        """Return actions (n, a); some may be NaN or out of range.

        Raises:
            LostError: the controller failed, or gave no such array.
        """
        timed = (times,) if isinstance(self.controller, Stack) else ()
        seen = (
            f"; it is given observations of shape {observations.shape}: rows are scenes, and "
            "`scenario.environment().observations` names the columns"
        )
        given = self._ask(lambda: self.controller.act(observations, active, *timed), "act", seen)
        return shaped(self.control, given, active)

    @property
    def remembers(self) -> bool:
        """Return True if a question may change later answers."""
        return not isinstance(self.controller, _Memoryless)

    def _ask(self, question: Callable[[], Any], what: str, about: str = "") -> Any:
        try:
            return question()
        except (CortexError, KeyboardInterrupt):
            raise
        except BaseException as error:  # user code may raise any: SystemExit, GeneratorExit, its own
            who = f"the controller `{self.control.controller}` raised {type(error).__name__} in `{what}`"
            said = _in_short(error)
            lost = LostError(f"{who}{said and f': {said}'}{_place(error)}", f"correct it{about}")
            lost.raised = error
            raise lost from error


def _in_short(error: BaseException) -> str:
    """Return an error's text as one line of printable characters, at most `QUOTED` of them."""
    try:
        text = str(error)
    except Exception:
        text = "it cannot say what happened"
    text = " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())
    return text if len(text) <= QUOTED else f"{text[:QUOTED]}…"


def _place(error: BaseException) -> str:
    """Return the file and line at which an error was raised; "" if that is this file, as for wrong arguments."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None or trace.tb_frame.f_code.co_filename == __file__:
        return ""
    return f" ({trace.tb_frame.f_code.co_filename}, line {trace.tb_lineno})"


def checked(control: Control, given: object, active: Bools, times: Floats) -> Floats:
    """Return actions (n, a) as numbers, if those of the active slots can be driven.

    Raises:
        ControllerError: another shape, no numbers, NaN, or out of range: which, where and when.
    """
    actions, wrong = settled(control, shaped(control, given, active), active)
    if wrong is not None:
        slot = int(np.flatnonzero(wrong)[0])
        raise fault_of(control, actions[slot]).at(f"in slot {slot} at {times[slot]:.2f} s")
    return actions


def shaped(control: Control, given: object, active: Bools) -> Floats:
    """Return actions (n, a) as float64.

    Raises:
        LostError: the shape differs, or they are no real numbers.
    """
    who, shape = f"the controller `{control.controller}`", (len(active), len(control.actions))
    if getattr(getattr(given, "dtype", None), "kind", "") == "c":
        raise LostError(f"{who} gave complex numbers", _wanted(control))
    try:
        actions = np.asarray(_bare(given), dtype=np.float64)
    except Exception as error:  # other array types may raise any: a tensor with a gradient does
        why = "" if isinstance(error, TypeError | ValueError) else f": {_in_short(error)}"
        raise LostError(f"{who} gave no numbers, but {type(given).__name__}{why}", _wanted(control)) from error
    if given is None:
        raise LostError(f"{who} gave nothing: it returns None", _wanted(control))
    if may_warn(control) and actions.shape == (shape[0], shape[1] - 1):
        actions = np.column_stack([actions, np.full(len(active), NO_WARNINGS)])
    if actions.shape != shape:
        raise LostError(f"{who} gave actions of shape {actions.shape}; expected {shape}", _wanted(control))
    return np.require(actions, np.float64, PLAIN)  # once, for all kernels that read them


def _bare(given: object) -> Any:
    """Return an array with masked elements as NaN; anything else unchanged."""
    return cast("Any", given).astype(np.float64).filled(np.nan) if isinstance(given, np.ma.MaskedArray) else given


def settled(control: Control, actions: Floats, active: Bools) -> tuple[Floats, Bools | None]:
    """Return actions (n, a) within their ranges, and (n,) True for `active` rows that are NaN or out of range; None if
    there is no such row.

    A value that exceeds its range by no more than the rounding of float32 is set to the end of the range.
    """
    low, high = _ranges(control)
    if are_within(actions, active, low, high):
        return actions, None
    ends = np.clip(actions, low, high)
    actions = np.where(np.abs(actions - ends) <= ROUNDED * np.maximum(1.0, np.abs(ends)), ends, actions)
    wrong = active & ~((actions >= low) & (actions <= high)).all(axis=1)
    return actions, wrong if wrong.any() else None


def fault_of(control: Control, actions: Floats) -> ControllerError:
    """Return the error for the first of the actions (a,) that is NaN or out of range."""
    low, high = _ranges(control)
    number = int(np.flatnonzero(~((actions >= low) & (actions <= high)))[0])
    action, value = control.actions[number], float(actions[number])
    unit, who = f" {action.unit}" if action.unit else "", f"the controller `{control.controller}` gave {action.name}"
    return ControllerError(
        f"{who} = {value:.9g}{unit}",
        f"{action.name} lies in {action.low:g} .. {action.high:g}{unit}: "
        + ("look for what makes it no number" if np.isnan(value) else "`numpy.clip` holds it there"),
        kind=f"{who} {'= nan' if np.isnan(value) else 'out of its range'}",
    )


def _ranges(control: Control) -> tuple[Floats, Floats]:
    return np.array([each.low for each in control.actions]), np.array([each.high for each in control.actions])


def _wanted(control: Control) -> str:
    columns = ", ".join(f"{a.name} [{a.unit or '1'}, {a.low:g} .. {a.high:g}]" for a in control.actions)
    return f"give an array (n, {len(control.actions)}) with one row per slot: {columns}"


def seats_of(program: Program, driver: object) -> tuple[ControllerSlot, ...]:
    """Return every control with its controller."""
    controllers = controllers_of(program, driver)
    return tuple(ControllerSlot(control, each) for control, each in zip(program.controls, controllers, strict=True))
