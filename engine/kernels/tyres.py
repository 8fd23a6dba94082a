"""Forces of a tyre: the magic formula, along and across the plane of an upright wheel, with combined slip.

Sources: Pacejka, "Tire and Vehicle Dynamics", 3rd ed., section 4.3.2; coefficients of Althoff and Würsching,
"CommonRoad: Vehicle Models" (2020), table 7 (from the handbook of ADAMS). `friction` is Pacejka's lambda_mu, a factor
on the peaks. Slip is 1 - R omega / u, so positive under brake.
"""

import math

from engine.kernels.jit import inlined


@inlined
def _magic(x: float, stiffness: float, shape: float, bend: float) -> float:
    """Return C atan(B x - E (B x - atan(B x))), the angle of the magic formula."""
    scaled = stiffness * x
    return shape * math.atan(scaled - bend * (scaled - math.atan(scaled)))


@inlined
def tyre_along(slip: float, angle: float, load: float, friction: float) -> float:
    """Return the force along a wheel's plane [N]; Pacejka (4.E9) to (4.E18), then (4.E50) to (4.E57) for the share left
    by a slip angle. In the documentation the vertical shift is within the sine.
    """
    peak, along = 1.1739 * friction, -slip
    angle_of_pure = _magic(along + 0.0012297, 22.303 / (1.6411 * peak), 1.6411, 0.46403)
    pure = peak * load * math.sin(angle_of_pure - 8.8098e-06 * load)
    stiffness = 13.276 * math.cos(math.atan(-13.778 * slip))
    shift = math.cos(_magic(0.0050722, stiffness, 1.2568, 0.65225))
    return pure / shift * math.cos(_magic(angle + 0.0050722, stiffness, 1.2568, 0.65225))


@inlined
def tyre_across(slip: float, angle: float, load: float, friction: float) -> float:
    """Return the force across a wheel's plane [N]; Pacejka (4.E19) to (4.E30), then (4.E58) to (4.E67)."""
    peak = 1.0489 * friction
    pure = peak * load * math.sin(_magic(angle, -21.92 / (1.3507 * peak), 1.3507, -0.0074722))
    stiffness = 7.1433 * math.cos(math.atan(9.1916 * (angle + 0.027856)))
    shift = math.cos(_magic(5.7448e-06, stiffness, 1.0719, -0.27572))
    aside = peak * load * -0.027825 * math.cos(math.atan(12.12 * angle)) * math.sin(1.9 * math.atan(-10.704 * slip))
    return pure / shift * math.cos(_magic(slip + 5.7448e-06, stiffness, 1.0719, -0.27572)) + aside
