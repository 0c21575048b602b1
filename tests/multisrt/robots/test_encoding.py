"""Messages as bytes and back."""

import dataclasses
from typing import Any, ClassVar, NamedTuple

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.geometry.configuration import Configuration
from multisrt.geometry.errors import InvalidInputError
from multisrt.robots.encoding import ARRAY, STRUCTURE, decode, encode
from multisrt.robots.explorer import Send
from multisrt.robots.messages import Message
from multisrt.simulation.stepping import Stepping
from multisrt.spec import CatalogEnvironment, RobotSpec, RunSpec


class Spot(NamedTuple):
    x: float
    y: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Grid:
    cells: np.ndarray
    at: Configuration


class Report(Message, frozen=True, kw_only=True):
    kind: ClassVar[str] = "report of all kinds"
    grid: Grid | None = None
    spots: tuple[Spot, ...] = ()
    named: dict | None = None
    rest: tuple = ()


def are_equal(a: object, b: object) -> bool:
    """Whether values have equal types and contents; arrays are compared by their numbers."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, msgspec.Struct):
        return all(are_equal(getattr(a, k), getattr(b, k)) for k in a.__struct_fields__)
    if dataclasses.is_dataclass(a) and not isinstance(a, type):
        names = [field.name for field in dataclasses.fields(a)]
        return all(are_equal(getattr(a, name), getattr(b, name)) for name in names)
    if isinstance(a, tuple | list) and isinstance(b, tuple | list):
        return len(a) == len(b) and all(map(are_equal, a, b))
    return a == b


def there_and_back(message: Message) -> Any:
    return decode(encode(message))


def test_a_message_of_all_kinds_comes_back_as_it_was():
    grid = Grid(cells=np.arange(6, dtype=np.int8).reshape(2, 3), at=Configuration(1.0, 2.0, 0.5))
    sent = Report(
        sender=3,
        grid=grid,
        spots=(Spot(0.5, 1.5),),
        named={(0, 1): "door", 2: [1, (2,)]},
        rest=(None, True, -7, 2.5, "é", b"\x00", (), [], {}, np.zeros((0, 4))),
    )
    got = there_and_back(sent)
    assert are_equal(got, sent)
    assert encode(got) == encode(sent)
    assert not got.grid.cells.flags.writeable


PLAIN = st.none() | st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats() | st.text()
TREES = st.recursive(
    PLAIN,
    lambda part: st.lists(part) | st.lists(part).map(tuple) | st.dictionaries(PLAIN, part),
    max_leaves=6,
)


@settings(max_examples=40, deadline=None)
@given(st.lists(TREES, max_size=4).map(tuple))
def test_any_nested_content_comes_back(rest):
    got = there_and_back(Report(sender=0, rest=rest))
    assert repr(got.rest) == repr(rest)  # NaN is equal to NaN in words


def test_numbers_of_numpy_come_back_as_builtin_ones():
    got = there_and_back(Report(sender=0, rest=(np.float32(0.5), np.int64(3))))
    assert are_equal(got.rest, (0.5, 3))


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["srt-radial", "utility", "self-bidding"])
def test_all_messages_of_a_team_come_back_as_they_were(strategy):
    spec = RunSpec(
        environment=CatalogEnvironment(name="apartment"),
        strategy=strategy,
        robots=(RobotSpec(),) * 3,
        seed=1,
    )
    kinds = set()
    for step in Stepping(spec):
        if isinstance(step.action, Send) and step.time_s < 30.0:
            message = step.action.message
            assert are_equal(decode(encode(message)), message)
            kinds.add(message.kind)
        elif step.time_s > 30.0:
            break
    assert kinds


@pytest.mark.parametrize("value", [{1, 2}, object(), 1 << 70, np.array(["a"])])
def test_what_cannot_be_sent_is_refused(value):
    with pytest.raises(InvalidInputError, match="report of all kinds message"):
        encode(Report(sender=0, rest=(value,)))


def test_what_is_no_message_is_refused():
    with pytest.raises(InvalidInputError, match="expected a Message, not int"):
        encode(3)  # type: ignore[arg-type]


def extension(code: int, content: object) -> bytes:
    inner = msgspec.msgpack.encode(content)
    return msgspec.msgpack.encode(msgspec.msgpack.Ext(code, inner))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        b"hello",
        msgspec.msgpack.encode([1, 2]),
        encode(Report(sender=0))[:-1],
        extension(ARRAY, ["<f8", [3], b"12345678"]),
        extension(ARRAY, ["O", [1], b"12345678"]),
        extension(ARRAY, ["<f8", [1], b"12345678"]),
        extension(STRUCTURE, ["os.system", {"command": "true"}]),
        extension(STRUCTURE, ["builtins.list", {}]),
        extension(STRUCTURE, [f"{Report.__module__}.Report", {"unknown": 1}]),
        extension(9, []),
    ],
)
def test_bytes_that_hold_no_message_are_refused(data):
    with pytest.raises(InvalidInputError, match=r"hold no message|which no class of messages"):
        decode(data)


@pytest.mark.parametrize("fields", [[1], {"sender": "evil"}, {"sender": 1, "more": 2}, {}])
def test_fields_are_as_their_class_declares(fields):
    content = msgspec.msgpack.encode(["multisrt.robots.messages.Message", fields])
    data = msgspec.msgpack.encode(msgspec.msgpack.Ext(2, content))
    with pytest.raises(InvalidInputError):
        decode(data)


@pytest.mark.parametrize("data", [5, None, "text"])
def test_messages_are_decoded_from_bytes_only(data):
    with pytest.raises(InvalidInputError, match="decoded from bytes, not from"):
        decode(data)
