"""Coulomb friction between a sliding body and the road, at its two axles."""

import math

import pymunk

from engine.world.bodies import Axle, Physique

REST_SPEED = 0.01
"""A body slower than this stands still [m/s]; so does one that turns no faster, in rad/s."""


def rub(body: pymunk.Body, actor: Physique, duration: float) -> bool:
    """Slow a free body down for a time [s]; whether it stands still afterwards.

    Each axle in turn gets an impulse against its own motion, at most its load times the duration and at most what
    stops it there, so that friction never reverses a motion and energy never rises.
    """
    (vx, vy), spin = body.velocity, body.angular_velocity
    cos, sin = math.cos(body.angle), math.sin(body.angle)
    for axle in actor.axles:
        vx, vy, spin = _rub_axle(axle, actor, (cos, sin), (vx, vy, spin), duration)
    still = vx * vx + vy * vy < REST_SPEED**2 and abs(spin) < REST_SPEED
    body.velocity, body.angular_velocity = ((0.0, 0.0), 0.0) if still else ((vx, vy), spin)
    return still


def _rub_axle(
    axle: Axle,
    actor: Physique,
    heading: tuple[float, float],
    motion: tuple[float, float, float],
    duration: float,
) -> tuple[float, float, float]:
    """Velocity and spin after the friction of one axle."""
    vx, vy, spin = motion
    arm_x, arm_y = axle.offset * heading[0], axle.offset * heading[1]
    slide_x, slide_y = vx - spin * arm_y, vy + spin * arm_x
    slide = math.hypot(slide_x, slide_y)
    if slide == 0.0:
        return motion
    x, y = slide_x / slide, slide_y / slide
    lever = arm_x * y - arm_y * x
    stopping = slide / (1.0 / actor.mass + lever * lever / actor.inertia)
    impulse = min(axle.load * duration, stopping)
    return vx - impulse * x / actor.mass, vy - impulse * y / actor.mass, spin - impulse * lever / actor.inertia
