"""Is our single-track drift model that of CommonRoad? Random drives, held against STD integrated by LSODA.

    python -m benchmarks.dynamics --drives 300 [--json]

Vehicles 1 to 3 in turn, from 5 to 40 m/s, 3 s of random steering and braking, together and one after the other. The
reference is `vehiclemodels.vehicle_dynamics_std` (PyPI: `commonroad-vehicle-models`) with relative and absolute
tolerances of 1e-9. Compared until the car stands or has turned by 75 degrees from where it goes: STD is written for a
car that goes forwards, and drives one that slides backwards on.
"""

import argparse
import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from vehiclemodels.init_std import init_std
from vehiclemodels.vehicle_dynamics_std import vehicle_dynamics_std
from vehiclemodels.vehicle_parameters import setup_vehicle_parameters

from engine.kernels.dynamics import COMMAND_STEP, SUBSTEP, Chassis, Drift, Held, hold

Array = NDArray[np.float64]
VEHICLES = (1, 2, 3)
SECONDS = 3.0
TOLERANCE = 1e-9
SPUN = math.radians(75.0)
FRONT, REAR = 7, 8
"""Wheels in the state of the reference."""


@dataclass(frozen=True)
class Agreement:
    """How far our model is from the reference."""

    drives: int
    farthest: float
    """[m]"""
    stopped: int
    """Drives that ended at rest …"""
    spun: int
    """… and those that ended in a spin."""
    locked: int
    """Drives in which a wheel stood while the car went."""


def agreement(drives: int, seed: int = 0) -> Agreement:
    """Drive both models by the same random commands."""
    rng, farthest, stopped, spun, locked = np.random.default_rng(seed), 0.0, 0, 0, 0
    for number in range(drives):
        vehicle = VEHICLES[number % len(VEHICLES)]
        reference, states = drive_both(vehicle, rng.uniform(5.0, 40.0), commands(rng, number // 3 % 4))
        farthest = max(farthest, apart(reference, states))
        stopped += bool(reference[-1, 3] <= 0.0)
        spun += bool(abs(reference[-1, 6]) > SPUN)
        locked += bool(np.any((reference[:, 3] > 1.0) & (reference[:, [FRONT, REAR]].min(axis=1) <= 0.0)))
    return Agreement(drives, farthest, stopped, spun, locked)


def commands(rng: np.random.Generator, kind: int) -> Array:
    """(steps, 2): steering rate [rad/s] and acceleration [m/s^2]."""
    steps = round(SECONDS / COMMAND_STEP)
    time = np.arange(steps) * COMMAND_STEP
    if kind == 0:  # all at random, anew every 0.2 s
        steer, pedal = rng.uniform(-0.4, 0.4, 15).repeat(40), rng.uniform(-9.0, 3.0, 15).repeat(40)
    elif kind == 1:  # into a bend under brake
        steer, pedal = np.where(time < 0.3, rng.uniform(-0.4, 0.4), 0.0), np.full(steps, rng.uniform(-9.0, 0.0))
    elif kind == 2:  # weaving, then braking
        steer = rng.uniform(0.1, 0.4) * np.sin(2.0 * math.pi * rng.uniform(0.3, 1.0) * time)
        pedal = np.where(time > 1.0, rng.uniform(-9.0, 0.0), 0.0)
    else:  # with all that brakes can do
        steer, pedal = rng.uniform(-0.3, 0.3, 6).repeat(100), rng.uniform(-11.5, 3.0, 6).repeat(100)
    return np.stack([steer, pedal], axis=1)


def drive_both(vehicle: int, speed: float, held: Array) -> tuple[Array, list[Drift]]:
    """States after each command: of the reference (n, 9), until it stands or spins, and of our model."""
    parameters = setup_vehicle_parameters(vehicle)
    start = np.array(init_std([0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0], parameters))
    reference = [start]
    for command in held:
        reference.append(_reference_step(reference[-1], command.tolist(), parameters))
        if reference[-1][3] <= 0.0 or abs(reference[-1][6]) > SPUN:
            break
    car = Drift(0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0, float(start[FRONT]), float(start[REAR]))
    states, chassis = [car], chassis_of(parameters)
    for steer, pedal in held[: len(reference) - 1].tolist():
        states.append(hold(states[-1], Held(steer, pedal), chassis, COMMAND_STEP, round(COMMAND_STEP / SUBSTEP)))
    return np.array(reference), states


def chassis_of(parameters: Any) -> Chassis:
    """A vehicle of CommonRoad for our model."""
    return Chassis(
        front=parameters.a,
        rear=parameters.b,
        mass=parameters.m,
        yaw_inertia=parameters.I_z,
        height=parameters.h_s,
        brake_split=float(parameters.T_sb),
        drive_split=float(parameters.T_se),
        power_speed=parameters.longitudinal.v_switch,
        friction=1.0,
    )


def apart(reference: Array, states: list[Drift]) -> float:
    """How far the centres of gravity are from one another at most [m]."""
    ours = np.array([(state.x, state.y) for state in states])
    return float(np.hypot(*(ours - reference[:, :2]).T).max())


def _reference_step(state: Array, command: list[float], parameters: Any) -> Array:
    """STD over one command. A wheel that stands is taken out of the equations until it would turn, and the instant at
    which one comes to stand is sought: at that edge of its right side a solver finds no step that is small enough.
    """

    def rates(state: Array) -> list[float]:
        return vehicle_dynamics_std([*state[:FRONT], *np.maximum(state[FRONT:], 0.0)], command, parameters)

    time, state = 0.0, state.copy()
    while time < COMMAND_STEP - 1e-12:
        now = rates(state)
        stand = [wheel for wheel in (FRONT, REAR) if state[wheel] <= 0.0 and now[wheel] <= 0.0]
        turning = [wheel for wheel in (FRONT, REAR) if wheel not in stand]

        def held(_: float, state: Array, stand: list[int] = stand) -> list[float]:
            return [0.0 if number in stand else rate for number, rate in enumerate(rates(state))]

        until = min(COMMAND_STEP, time + 0.0005) if stand else COMMAND_STEP
        solved = solve_ivp(
            held,
            (time, until),
            state,
            method="LSODA",
            rtol=TOLERANCE,
            atol=TOLERANCE,
            events=[_comes_to_stand(wheel) for wheel in turning],
        )
        time, state = float(solved.t[-1]) + (1e-12 if solved.status == 1 else 0.0), solved.y[:, -1].copy()
        state[FRONT:][state[FRONT:] < 1e-8] = 0.0
    return state


def _comes_to_stand(wheel: int) -> Callable[[float, Array], float]:
    def event(_: float, state: Array) -> float:
        return state[wheel] + 1e-9

    event.terminal, event.direction = True, -1  # pyright: ignore[reportFunctionMemberAccess]
    return event


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = agreement(options.drives, options.seed)
    if options.json:
        print(json.dumps(asdict(found)))
        return
    print(f"{found.drives} drives: at most {1000.0 * found.farthest:.2f} mm apart (asked for: 1 mm)")
    print(f"{found.stopped} came to rest, {found.spun} spun, in {found.locked} a wheel locked")


if __name__ == "__main__":
    main()
