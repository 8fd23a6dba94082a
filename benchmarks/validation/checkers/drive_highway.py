"""How many vehicle-seconds highway-env simulates in a second of processor time: two cars, no picture, its own view.

    python drive_highway.py STEP EVERY SECONDS

Prints one number. Runs in an environment of its own and imports nothing of ours.
"""

import sys
import time

import gymnasium
import highway_env

CARS = 2


def main(step: float, every: float, seconds: float) -> None:
    """Drive at steps of `step`, asked each `every`, for so long [s]."""
    highway_env.register_highway_envs() if hasattr(highway_env, "register_highway_envs") else None
    config = {
        "vehicles_count": CARS - 1,
        "simulation_frequency": round(1.0 / step),
        "policy_frequency": round(1.0 / every),
        "duration": 40,
    }
    env = gymnasium.make("highway-v0", config=config, render_mode=None)
    env.reset(seed=0)
    simulated, begun = 0.0, time.process_time()
    while (spent := time.process_time() - begun) < seconds:
        _, _, terminated, truncated, _ = env.step(1)
        simulated += CARS * every
        if terminated or truncated:
            env.reset()
    print(simulated / spent)


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
