"""What is said of files that compile: params and requirements that do nothing, and better ways to write them."""

from collections.abc import Callable

import pytest

Said = Callable[..., list[str]]
BREAK = "    while K > 0:\n        wait\n        if K > 3:\n            break\n"
HEAD = "param V = Range(1, 9) m/s\nparam K = Range(1, 9)\n"
USED = "car = new Car behind ego, with behavior B\n"


@pytest.mark.parametrize(
    "text",
    [
        "behavior B():\n    take SetSpeedAction(V)\n",
        f"behavior B():\n    if K < 0:\n        take SetSpeedAction(V)\n    wait\n{USED}require K < 3\n",
        f"behavior B():\n    if K < 0 and self.speed > 1:\n        do FollowLaneBehavior(V)\n{USED}require K < 3\n",
        f"behavior B():\n    take SetSpeedAction(V * 0 + 3)\n{USED}require K < 3\n",
        "behavior B(v):\n    wait\ncar = new Car behind ego, with behavior B(V)\nrequire K < 3\n",
        f"behavior B():\n    wait\n    v = V\n    while True:\n        v = v\n        wait\n{USED}require K < 3\n",
        f"behavior B():\n    while True:\n        wait\n    take SetSpeedAction(V)\n{USED}require K < 3\n",
        f"behavior B():\n    wait\n    return\n    take SetSpeedAction(V)\n{USED}require K < 3\n",
        f"behavior B():\n    try:\n        wait\n    interrupt when K > 20:\n        take SetSpeedAction(V)\n{USED}",
        "x = V\nrequire K < 3\n",
        "x = V if K > 0 else 3\nrequire K < 3\n",
        "x = K if K > 0 else V\nrequire x < 3\n",
    ],
)
def test_dead_params(said: Said, text: str) -> None:
    """A param whose every use is in a place that is never reached, or makes no difference."""
    assert "SCN222" in said(HEAD + text)


@pytest.mark.parametrize(
    "text",
    [
        "require V < 3\nrequire K < 3\n",
        f"behavior B():\n    if K < 5:\n        take SetSpeedAction(V)\n    wait\n{USED}",
        f"behavior B():\n    take SetSpeedAction(V * K)\n{USED}",
        "behavior B(v):\n    take SetSpeedAction(v * K)\ncar = new Car behind ego, with behavior B(V)\n",
        f"behavior B():\n    v = 1 m/s\n    while K > 2:\n        take SetSpeedAction(v)\n        v = v + V\n{USED}",
        f"behavior B():\n{BREAK}    take SetSpeedAction(V)\n{USED}",
        f"behavior B():\n    do FollowLaneBehavior(target_speed=V) until self.speed > K\n{USED}",
        "terminate when ego.speed > V\nterminate when ego.speed > K\n",
        "x = V if K > 5 else 3\nrequire x < 2\n",
    ],
)
def test_live_params(said: Said, text: str) -> None:
    """A param that something depends on, whatever stands in between."""
    assert "SCN222" not in said(HEAD + text)


def test_a_param_that_chooses_is_alive(said: Said) -> None:
    """The choice of a lane is in no expression, but in what the variants are."""
    text = "param L = Uniform(*network.lanes)\ncar = new Car in globalParameters.L.centerline\n"
    assert "SCN222" not in said(text)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("require V > 10 m/s\n", "SCN423"),
        ("require V * 2 < 1 m/s\n", "SCN423"),
        ("require not V < 20 m/s\n", "SCN423"),
        ("require V < 5 and K > 10\n", "SCN423"),
        ("require V < 20 m/s\n", "SCN480"),
        ("require V > 0 or K > 5\n", "SCN480"),
        ("require (distance from ego to intersection) >= 0\n", "SCN480"),
        ("require Range(1, 2) < 3\n", "SCN480"),
    ],
)
def test_requirements_that_are_decided(said: Said, text: str, code: str) -> None:
    """The ranges alone decide them: never is an error, always a warning."""
    assert code in said(HEAD + text)


@pytest.mark.parametrize(
    "text",
    [
        "require V > 9 m/s or K > 5\n",
        "require V <= 8.99 m/s\n",
        "require V >= 9 m/s\n",
        "require[0.5] V > 10 m/s\n",
        "lane2 = Uniform(*network.lanes)\nrequire lane2 is lane\n",
        "require (distance from ego to intersection) > 0\n",
    ],
)
def test_requirements_that_are_open(said: Said, text: str) -> None:
    """What some values of the params make true, and others false."""
    codes = said(HEAD + text)
    assert "SCN423" not in codes
    assert "SCN480" not in codes


def test_what_the_command_line_pins_is_no_slip(said: Said) -> None:
    """`-p` decides a requirement that the file leaves open, and may leave params without effect."""
    text = HEAD + "require V < 5 m/s\nrequire K < 3 or V < 4 m/s\n"
    assert "SCN480" not in said(text, {"V": "2"})
    assert "SCN222" not in said(text, {"V": "2"})


@pytest.mark.parametrize(
    ("value", "outside"),
    [("5", False), ("1", False), ("9", False), ("9.5", True), ("36 km/h", True), ("18 km/h", False), ("-3", True)],
)
def test_an_override_outside_its_range(said: Said, value: str, outside: bool) -> None:
    """A run that no search of the file could find is said to be one."""
    assert ("SCN482" in said(HEAD + "require V < 5\nrequire K < 3\n", {"V": value})) is outside


@pytest.mark.parametrize(
    "condition",
    [
        "abs((distance from car to intersection) - 9 m) <= 2 m",
        "abs(9 m - (distance from car to intersection)) < 2 m",
        "5 m <= (distance from car to intersection) <= 9 m",
    ],
)
@pytest.mark.parametrize(
    "placed", ["car = new Car in lane.centerline\n", "p = new OrientedPoint in lane.centerline\ncar = new Car at p\n"]
)
def test_a_window_on_a_uniform_placement(said: Said, placed: str, condition: str) -> None:
    """However it is written."""
    assert "SCN481" in said(f"{placed}require {condition}\n")


@pytest.mark.parametrize(
    "text",
    [
        "car = new Car at (0, 0)\nrequire 5 m <= (distance from car to intersection) <= 9 m\n",
        "car = new Car in lane.centerline\nrequire (distance from car to intersection) <= 9 m\n",
        "car = new Car in lane.centerline\nrequire 5 < (distance from car to lane) < 9  # allow SCN481: meant\n",
    ],
)
def test_no_window(said: Said, text: str) -> None:
    """Where nothing is gained, or the file says that it means it."""
    assert "SCN481" not in said(text)


def test_a_comment_allows_what_it_names(said: Said) -> None:
    """Warnings and hints, never errors, and no other code."""
    text = "gap = 9 m\nrequire ego.speed < 300 m/s or 1 < 2\n"
    assert {"SCN223", "SCN480"} <= set(said(text))
    assert "SCN223" not in said(text + "# allow SCN223, SCN481: as the paper has it\n")
    assert "SCN480" in said(text + "# allow SCN223\n")
    assert "SCN423" in said("require 1 > 2  # allow SCN423\n")


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("gap = 9 m\n", 1),
        ("_gap = 9 m\n", 0),
        ("a, b = (1, 2)\n", 0),
        ("cars = [new Car behind ego]\n", 0),
        (f"behavior B(x):\n    y = 3\n    wait\n{USED.replace('B', 'B(1)', 1)}", 2),
        (f"behavior B(x):\n    y = x\n    take SetBrakeAction(y)\n{USED.replace('B', 'B(1)', 1)}", 0),
    ],
)
def test_names_that_are_never_read(said: Said, text: str, count: int) -> None:
    """Assigned ones and arguments; objects exist without being named again."""
    assert said(text).count("SCN223") == count


def test_names_of_what_is_built_in(said: Said) -> None:
    """Hiding one is pointed out, except for names that a message asks files to assign."""
    assert "SCN211" in said("max = 3\nrequire ego.speed < max\n")
    assert "SCN211" not in said("intersection = Uniform(*network.intersections)\nrequire ego in intersection\n")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("car = new Car ahead of ego by {}\n", "SCN322"),
        ("require (distance from ego to intersection) < {}\n", "SCN322"),
        ("behavior B():\n    do FollowLaneBehavior() for {}\n" + USED, "SCN323"),
        ("car = new Car behind ego, with behavior FollowLaneBehavior(max_lateral={})\n", "SCN324"),
    ],
)
def test_bare_numbers_that_look_like_another_unit(said: Said, text: str, code: str) -> None:
    """Only where the size is absurd; what Scenic's own scripts hold is not."""
    assert code in said(text.format(2000))
    assert code not in said(text.format(9))
