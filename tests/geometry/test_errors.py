import hypothesis.strategies as st
import pytest
from hypothesis import given

from multisrt.geometry.errors import (
    MAX_CITED,
    MAX_REASON,
    MapFormatError,
    escaped,
    reason_of,
    shortened,
    shown,
)


@given(st.text(), st.integers(4, 80))
def test_shortened_text_is_short_and_printable(text, length):
    short = shortened(text, length)
    assert len(short) <= length
    assert short.isprintable()
    whole = escaped(text)
    if len(whole) <= length:
        assert short == whole
    else:
        assert short.endswith("...")
        assert whole.startswith(short[:-3])


@given(st.text() | st.floats() | st.lists(st.integers()) | st.binary() | st.none())
def test_shown_values_are_short(value):
    assert len(shown(value)) <= MAX_CITED
    assert shown(value).isprintable()


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("hall", "'hall'"),
        ("a" * 58, repr("a" * 58)),
        ("a" * 59, "'" + "a" * 56 + "..."),
        (10**400, "1" + "0" * 56 + "..."),
        (1 << 20_000, "a whole number of 20,001 bits"),
        ([1, [2]], "a list of 2"),
    ],
    ids=lambda value: "",  # pytest cannot print the long number
)
def test_values_are_shown_as_in_python(value, text):
    assert shown(value) == text


def test_reasons_are_short_lines_without_names_of_files():
    long = OSError(36, "File name too long", "a" * 5000)
    assert reason_of(long) == "File name too long"
    assert reason_of(ValueError("one\n  two.")) == "one two"
    assert reason_of(KeyError()) == "KeyError"
    assert len(reason_of(ValueError("x" * 10**6))) == MAX_REASON


def test_messages_about_maps_are_printable():
    assert str(MapFormatError("a\x1b[2J\u2028b")) == "a\\x1b[2J\\u2028b"
