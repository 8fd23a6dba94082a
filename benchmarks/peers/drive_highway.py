"""Rates of highway-env with two cars: `python drive_highway.py STEP EVERY SECONDS`.

The other car is an IDM vehicle that chooses lanes by MOBIL, its default. Prints one JSON object of
vehicle-seconds per second of processor time: of its road alone, and of the environment with its default observation.
Runs in an environment of its own and imports nothing of ours.
"""

# pyright: reportMissingImports=false, reportAttributeAccessIssue=false

import json
import sys
import time

import gymnasium
import highway_env

CARS = 2


def main(step: str, every: str, seconds: str) -> None:
    """Drive at steps of `step` [s], with an action each `every` [s], for so long [s]."""
    highway_env.register_highway_envs() if hasattr(highway_env, "register_highway_envs") else None
    config = {
        "vehicles_count": CARS - 1,
        "simulation_frequency": round(1.0 / float(step)),
        "policy_frequency": round(1.0 / float(every)),
        "duration": 40,
    }
    env = gymnasium.make("highway-v0", config=config, render_mode=None)
    print(
        json.dumps(
            {
                "driven": of_road(env, float(step), float(seconds)),
                "asked": of_environment(env, float(every), float(seconds)),
            }
        )
    )


def of_road(env: gymnasium.Env, step: float, seconds: float) -> float:
    """Vehicle-seconds per second of the vehicles' own acts and steps."""
    simulated, begun = 0.0, time.process_time()
    while (spent := time.process_time() - begun) < seconds:
        env.reset(seed=round(simulated))
        road = env.unwrapped.road
        if len(road.vehicles) != CARS:
            raise SystemExit(f"highway-env made {len(road.vehicles)} cars")
        for _ in range(round(40.0 / step)):
            road.act()
            road.step(step)
            simulated += CARS * step
    return simulated / spent


def of_environment(env: gymnasium.Env, every: float, seconds: float) -> float:
    """Vehicle-seconds per second of the environment, with an action that costs nothing."""
    env.reset(seed=0)
    simulated, begun = 0.0, time.process_time()
    while (spent := time.process_time() - begun) < seconds:
        _, _, terminated, truncated, _ = env.step(1)
        simulated += CARS * every
        if terminated or truncated:
            env.reset()
    return simulated / spent


if __name__ == "__main__":
    main(*sys.argv[1:])
