"""Actions in the order of time: a track for each entity, and remarks on what a replay leaves out."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from engine.interchange.properties import TIME
from engine.interchange.reading.catalogs import Catalogs
from engine.interchange.reading.entities import Entity
from engine.interchange.reading.node import Node, did_you_mean
from engine.interchange.reading.opendrive import OdrNetwork
from engine.interchange.reading.positions import Placed, Surroundings, place
from engine.interchange.reading.storyboard import TimedAction
from engine.interchange.reading.tracks import Coast, Path, Track
from engine.interchange.reading.trajectories import read_path


@dataclass
class _Stage:
    """Where everybody is, action after action."""

    road: OdrNetwork | None
    catalogs: Catalogs
    tracks: dict[str, Track]
    speeds: dict[str, float] = field(default_factory=dict)
    """Of those who begin at a speed."""

    def around(self, time: float) -> Surroundings:
        def other(name: str, node: Node) -> Placed:
            track = self.track(name, node)
            if (placed := track.placed_at(time)) is None:
                raise node.error(f"where `{name[:40]}` is at {time:g} s is not known here", "place it before")
            return placed

        return Surroundings(self.road, other)

    def track(self, name: str, node: Node) -> Track:
        if name not in self.tracks:
            raise node.error(f"nobody is called `{name[:40]}`", did_you_mean(name, self.tracks))
        return self.tracks[name]

    def does(self, timed: TimedAction) -> None:
        track = self.track(timed.entity, timed.action)
        self.tracks[timed.entity] = self._after(track, timed)

    def _after(self, track: Track, timed: TimedAction) -> Track:
        time, action = timed.time, timed.action
        match action.tag:
            case "FollowTrajectoryAction":
                return track.with_leg(read_path(action, time, self.around(time), self.catalogs))
            case "TeleportAction":
                return track.with_leg(self._placed(action, timed))
            case "AddEntityAction":
                return track.enters(time).with_leg(self._placed(action, timed))
            case "DeleteEntityAction":
                return track.leaves(time)
            case _:
                return self._at_speed(track, timed)

    def _placed(self, action: Node, timed: TimedAction) -> Coast:
        placed = place(action.need("Position"), self.around(timed.time))
        return Coast(timed.time, placed, self.speeds.get(timed.entity, 0.0) if timed.time == 0.0 else 0.0, self.road)

    def _at_speed(self, track: Track, timed: TimedAction) -> Track:
        target = timed.action.need("SpeedActionTarget")
        absolute = target.find("AbsoluteTargetSpeed")
        if absolute is None:
            raise target.error("only an absolute speed is read here", "write <AbsoluteTargetSpeed value=…/>")
        speed = absolute.number("value", low=-1000.0, high=1000.0)
        self.speeds[timed.entity] = speed
        legs = tuple(
            Coast(leg.begin, leg.placed, speed, leg.road) if isinstance(leg, Coast) else leg for leg in track.legs
        )
        return Track(legs, track.absent)


def read_tracks(
    entities: Sequence[Entity], actions: Sequence[TimedAction], road: OdrNetwork | None, catalogs: Catalogs
) -> tuple[list[Track], list[str]]:
    """One track for each entity, in their order, and remarks.

    Raises:
        InterchangeError: somebody is moved otherwise than by a trajectory, or has no place.
    """
    stage = _Stage(road, catalogs, {entity.node.text("name"): Track() for entity in entities})
    for timed in actions:
        if timed.is_read:
            stage.does(timed)
        else:
            stage.track(timed.entity, timed.action)
    remarks = _of_others(stage, [timed for timed in actions if not timed.is_read])
    steered = dict.fromkeys(timed.entity for timed in actions if _is_steered(timed.action))
    remarks += [f"{name} may steer along its trajectory (mode `follow`); here it is on it exactly" for name in steered]
    for entity in entities:
        remarks += _of_track(entity, stage.tracks[entity.node.text("name")])
    return list(stage.tracks.values()), remarks


def _is_steered(action: Node) -> bool:
    mode = action.find("TrajectoryFollowingMode")
    return mode is not None and mode.text("followingMode") == "follow"


def _of_others(stage: _Stage, actions: Sequence[TimedAction]) -> list[str]:
    """Remarks on actions that only a simulator could work out, of those who have a trajectory, too."""
    for timed in actions:
        if not stage.tracks[timed.entity].follows:
            raise timed.action.error(
                f"`{timed.entity}` is moved by <{timed.action.tag}>, which only a simulator can work out",
                "record the run in a simulator, and import the recording",
            )
    pairs = dict.fromkeys((timed.entity, timed.action.tag) for timed in actions)
    return [f"<{tag}> of {name} is not replayed: it follows its trajectory alone" for name, tag in pairs]


def _of_track(entity: Entity, track: Track) -> list[str]:
    """Remarks on where a replay had to guess."""
    name = entity.node.text("name")
    if not track.legs:
        raise entity.node.error(f"nothing says where `{name}` is", "place it by a TeleportAction in <Init>")
    said = [f"{name} jumps {distance:.1f} m at {time:g} s" for time, distance in track.jumps()]
    first = track.legs[0]
    instant = len(entity.properties.get(TIME, "").split()) == 1  # there once, in a recording of ours
    if isinstance(first, Coast) and first.speed and not track.follows and not instant:
        said.append(f"{name} follows no trajectory: it goes on at {first.speed:g} m/s, along its lane where known")
    elif isinstance(first, Path) and first.begin > 0.0 and not track.absent:
        said.append(f"nothing says where {name} is before {first.begin:g} s: it waits where its trajectory begins")
    return said
