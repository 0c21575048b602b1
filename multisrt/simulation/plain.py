"""What explorers yield as plain data: numbers of numpy become builtin ones, the rest is refused.

Everything that enters the simulation passes here once, so that no later computation, comparison or
recording depends on the type of a number.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import chain, pairwise
from typing import Any, NoReturn, cast, get_args

import msgspec
import numpy as np

from multisrt.events import AnyEvent, Ended, Event, NotedEvent, Purpose
from multisrt.geometry.errors import reason_of
from multisrt.geometry.numerics.arrays import builtin
from multisrt.planners.motion.trajectory import Trajectory, Waypoint
from multisrt.recording.flaws import waypoints_flaw
from multisrt.robots.defects import ExplorerDefect, brief, described, refuse
from multisrt.robots.explorer import Done, Move, Receive
from multisrt.robots.messages import Message
from multisrt.validation_errors import explained

PURPOSES = get_args(Purpose)

_EVENTS = frozenset(get_args(NotedEvent))

_ENCODER = msgspec.msgpack.Encoder(enc_hook=builtin)
_BUILTIN_ENCODER = msgspec.msgpack.Encoder()
_DECODER = msgspec.msgpack.Decoder(AnyEvent)

SAME_TIME_S = 1e-6
"""Times that differ by less are one, in seconds."""

_NOT_FINITE = re.compile(rb"\xcb[\x7f\xff][\xf0-\xff]")
"""How floats that are infinite or no number begin in MessagePack; other data may look the same."""


def timeout_s(receive: Receive, robot: int) -> float | None:
    """Return how long a robot waits at most, in seconds; None: without limit."""
    if receive.timeout_s is None:
        return None
    limit_s = _number(receive.timeout_s, robot, "timeout_s of its Receive", or_inf=True)
    return None if limit_s == math.inf else limit_s


def addressee(to: Any, robot: int) -> int | None:
    """Return the robot that a message is for, None for all."""
    if to is None:
        return None
    if isinstance(to, int | np.integer) or (_is_single(to) and to.dtype.kind in "iu"):
        return int(to)
    _refuse_value(robot, "to of its Send", to, "give the number of a robot, as int(x), or None")


def size_bytes(message: Any, robot: int) -> int:
    """Return the size of a message."""
    if not isinstance(message, Message):
        refuse(
            robot,
            f"it sent {brief(message)}, which is no message",
            "derive a class from multisrt.robots.messages.Message, and send an instance",
        )
    if not isinstance(message.sender, int | np.integer) or message.sender != robot:
        _refuse_value(robot, "sender of its message", message.sender, f"give sender={robot}")
    if not isinstance(message.kind, str) or not _is_writable(message.kind):
        kind = f"kind of {type(message).__name__}"
        _refuse_value(robot, kind, message.kind, "set it to a name in the class")
    try:
        _flag(message.wakes, robot, f"wakes of {type(message).__name__}")
        return message.size_bytes
    except ExplorerDefect:
        raise
    except Exception as error:  # of the user's own classes, too
        found = _first_unwritable(message, arrays=True)
        refuse(
            robot,
            "it sent a message that cannot be written: "
            + (f"{found[0]} is {described(found[1])}" if found else _reason(error)),
            "messages hold numbers, text, tuples, structures and read-only numpy arrays",
        )


def motion(move: Move, robot: int) -> Move:
    """Return a motion with builtin numbers: the same one if it has them already."""
    trajectory = _trajectory(move.trajectory, robot)
    guard_m, purpose = move.guard_m, move.purpose
    if guard_m is not None:
        guard_m = _number(guard_m, robot, "guard_m of its Move")
        if guard_m <= 0.0:
            _refuse_value(robot, "guard_m of its Move", guard_m, "give a positive number, or None")
    listen = _flag(move.listen, robot, "listen of its Move")
    if not isinstance(purpose, str) or purpose not in PURPOSES:
        allowed = f"give one of {', '.join(map(repr, PURPOSES))}"
        _refuse_value(robot, "purpose of its Move", purpose, allowed)
    if trajectory is move.trajectory and guard_m is move.guard_m and listen is move.listen:
        return move
    return Move(trajectory=trajectory, purpose=purpose, guard_m=guard_m, listen=listen)


def ended(done: Done, robot: int, now_s: float) -> Ended:
    """Return the event of an end.

    Parameters
    ----------
    done : Done
        The action.
    robot : int
        Its robot.
    now_s : float
        The time in seconds.

    Returns
    -------
    Ended
        The event, in builtin types.

    Raises
    ------
    ExplorerDefect
        If a field of the action has a value of another type.
    """
    if not isinstance(done.reason, str) or not _is_writable(done.reason):
        _refuse_value(robot, "reason of its Done", done.reason, "say why it ends, as text")
    what = "frontier of its Done"
    remedy = "give a tuple of segments (x0, y0, x1, y1) in metres"
    if not _is_sequence(done.frontier):
        _refuse_value(robot, what, done.frontier, remedy)
    segments = []
    for segment in done.frontier:
        if not _is_sequence(segment) or len(segment) != 4:
            _refuse_value(robot, f"a segment of the {what}", segment, remedy)
        x0, y0, x1, y1 = (_number(v, robot, f"a coordinate of the {what}") for v in segment)
        segments.append((x0, y0, x1, y1))
    return Ended(
        time_s=now_s,
        robot=robot,
        reason=str(done.reason),
        complete=_flag(done.complete, robot, "complete of its Done"),
        frontier=tuple(segments),
    )


def is_on_call(done: Done, robot: int) -> bool:
    """Return whether messages are still delivered to a robot that is done."""
    return _flag(done.on_call, robot, "on_call of its Done")


def event(noted: Any, robot: int, now_s: float, *, is_ours: bool = False) -> AnyEvent:
    """Return an event as it can be recorded.

    Parameters
    ----------
    noted : object
        What the explorer records.
    robot : int
        Its robot.
    now_s : float
        The time in seconds, which is that of the event: runs are measured by when things happened.
    is_ours : bool
        Whether code of this package made it, whose values have the declared types.

    Returns
    -------
    Event
        That of `as_declared`; the same event if it is ours and all that is in it can be written.

    Raises
    ------
    ExplorerDefect
        If it is not an event that explorers put on record, has another time, or `as_declared`
        raises it.
    """
    found = _recordable(noted, robot, is_ours)
    if abs(found.time_s - now_s) > SAME_TIME_S:
        refuse(
            robot,
            f"its {type(found).__name__} has time_s={found.time_s:g} at {now_s:g} s",
            "give the present time: every outcome has it as time_s, those of Sense, Move, Stop and "
            "Receive (also TimedOut), and at the start its RobotSelf",
        )
    return found


def _recordable(noted: Any, robot: int, is_ours: bool) -> AnyEvent:
    # To write an event costs little; to read it again would cost 2 to 4 percent of a run.
    if is_ours and type(noted) in _EVENTS and type(noted.time_s) is float and noted.robot == robot:
        try:
            if _NOT_FINITE.search(_BUILTIN_ENCODER.encode(noted)) is None:
                return cast(AnyEvent, noted)
        except (TypeError, ValueError, OverflowError, RecursionError):
            pass
    if not isinstance(noted, Event):
        refuse(
            robot,
            f"it put {brief(noted)} on record",
            f"give Note an instance of a class of multisrt.events, with robot={robot}",
        )
    if type(noted) not in _EVENTS:
        refuse(
            robot,
            f"it put a {type(noted).__name__} on record, which explorers do not note",
            f"note {', '.join(sorted(kind.__name__ for kind in _EVENTS))} only",
        )
    return as_declared(noted, robot)


def as_declared(noted: Event, robot: int) -> AnyEvent:
    """Return a copy of an event whose values have exactly the types that its class declares.

    Raises
    ------
    ExplorerDefect
        If it is an event of another robot, or has a field whose value cannot be converted or is
        no finite number.
    """
    kind = type(noted).__name__
    try:
        data = _ENCODER.encode(noted)
        if _NOT_FINITE.search(data):
            _refuse_unwritable(noted, robot)
        declared: AnyEvent = _DECODER.decode(data)
    except msgspec.ValidationError as error:
        refuse(
            robot,
            f"its {kind} is not as its class declares: {explained(error, type(noted))}",
            "see multisrt.events for its fields; float(x) and int(x) convert numbers",
        )
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        _refuse_unwritable(noted, robot)
        what = f"its {kind} cannot be recorded: {_reason(error)}"
        refuse(robot, what, "give numbers, text and tuples")
    if declared.robot != robot:
        refuse(
            robot,
            f"it put an event of robot {declared.robot} on record",
            f"give its {kind} robot={robot}: a robot speaks for itself alone",
        )
    return declared


def _trajectory(trajectory: Any, robot: int) -> Trajectory:
    found = _with_builtins(trajectory, robot)
    times_s = [0.0, *(waypoint.time_s for waypoint in found.waypoints)]
    for number, (before_s, after_s) in enumerate(pairwise(times_s)):
        if after_s < before_s or (number == 0 and after_s != 0.0):
            refuse(
                robot,
                f"waypoint {number} of its trajectory is at {after_s:g} s, after {before_s:g} s",
                "times of a trajectory count from 0 at its start and never fall",
            )
    if flaw := waypoints_flaw(found.waypoints):
        refuse(robot, f"its trajectory: {flaw}", "see multisrt.planners.motion.trajectory")
    return found


def _with_builtins(trajectory: Any, robot: int) -> Trajectory:
    remedy = "give a Trajectory of Waypoint(time_s, x, y, heading) with finite numbers"
    if not isinstance(trajectory, Trajectory):
        _refuse_value(robot, "trajectory of its Move", trajectory, remedy)
    waypoints = trajectory.waypoints
    if (
        type(waypoints) is tuple
        and waypoints
        and all(type(waypoint) is Waypoint for waypoint in waypoints)
        and all(type(value) is float for value in chain.from_iterable(waypoints))
        and math.isfinite(sum(chain.from_iterable(waypoints)))
    ):
        return trajectory
    found = []
    if not _is_sequence(waypoints):
        _refuse_value(robot, "waypoints of its trajectory", waypoints, remedy)
    for k, waypoint in enumerate(waypoints):
        field = f"waypoint {k} of its trajectory"
        if not _is_sequence(waypoint) or len(waypoint) != 4:
            _refuse_value(robot, field, waypoint, remedy)
        found.append(Waypoint(*(_number(value, robot, field) for value in waypoint)))
    if not found:
        refuse(robot, "its trajectory has no waypoint", remedy)
    return Trajectory(tuple(found))


def _number(value: Any, robot: int, field: str, *, or_inf: bool = False) -> float:
    if not (isinstance(value, int | float | np.integer | np.floating) or _is_single(value)):
        _refuse_value(robot, field, value, "give a number: float(x)")
    try:
        number = float(value)
    except OverflowError:
        _refuse_value(robot, field, value, "give a finite number")
    if not (math.isfinite(number) or (or_inf and number == math.inf)):
        _refuse_value(robot, field, number, "give a finite number" + " or inf" * or_inf)
    return number


def _flag(value: object, robot: int, field: str) -> bool:
    if not isinstance(value, bool | np.bool_):
        _refuse_value(robot, field, value, "give True or False: bool(x)")
    return bool(value)


def _is_sequence(value: Any) -> bool:
    return isinstance(value, tuple | list) or (isinstance(value, np.ndarray) and value.ndim > 0)


def _is_writable(text: str) -> bool:
    # Halves of surrogate pairs have no form in UTF-8.
    return text.isascii() or text == text.encode(errors="replace").decode()


def _is_single(value: object) -> bool:
    # An array without dimensions that holds a real number.
    return isinstance(value, np.ndarray) and value.ndim == 0 and value.dtype.kind in "iuf"


def _refuse_value(robot: int, field: str, value: object, remedy: str) -> NoReturn:
    refuse(robot, f"{field} is {described(value)}", remedy)


def _refuse_unwritable(noted: Event, robot: int) -> None:
    if (found := _first_unwritable(noted)) is not None:
        place, value = found
        is_float = isinstance(value, float | np.floating)
        remedy = "give a finite number" if is_float else "give plain numbers: float(x) or int(x)"
        _refuse_value(robot, f"{place} of what it put on record", value, remedy)


def _first_unwritable(value: Any, *, arrays: bool = False) -> tuple[str, object] | None:
    try:
        return next(_unwritable(value, type(value).__name__, arrays=arrays), None)
    except RecursionError:
        return None


def _reason(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return "something in it holds itself, or is nested too deep"
    return reason_of(error)


def _unwritable(value: Any, place: str, *, arrays: bool = False) -> Iterator[tuple[str, object]]:
    # The values in an event or a message that cannot be written, each with its place.
    parts: Iterator[tuple[str, Any]] = iter(())
    match value:
        case msgspec.Struct():
            # Fields without a value are not written.
            fields = [f for f in value.__struct_fields__ if getattr(value, f) is not msgspec.UNSET]
            parts = ((f"{place}.{field}", getattr(value, field)) for field in fields)
        case list() | tuple():
            parts = ((f"{place}[{k}]", part) for k, part in enumerate(value))
        case dict():
            for key in value:
                yield from _unwritable(key, f"a key of {place}", arrays=arrays)
            parts = ((f"{place}[{brief(key)}]", part) for key, part in value.items())
        case np.ndarray() if not arrays:
            parts = iter([(place, value.tolist())])
        case float() | np.floating():
            if not (arrays or math.isfinite(value)):
                yield place, value
        case int() | np.integer():
            if not -(2**63) <= value < 2**64:
                yield place, value
        case None | str() | np.bool_() | np.ndarray():
            pass
        case _:
            yield place, value
    for inner, part in parts:
        yield from _unwritable(part, inner, arrays=arrays)
