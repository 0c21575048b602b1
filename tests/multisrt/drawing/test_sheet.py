from hypothesis import given
from hypothesis import strategies as st

from multisrt.drawing.sheet import round_length, wrapped
from multisrt.drawing.svg import text_width


@given(st.floats(1e-6, 1e7))
def test_scale_bars_are_round_and_long_enough(longest):
    length = round_length(longest)
    assert longest / 2.5 <= length * (1 + 1e-12)
    assert length <= longest
    assert f"{length:e}"[0] in "125"


@given(st.text(max_size=300))
def test_wrapped_text_fits(text):
    for line in wrapped(text, 3.0, 60.0):
        assert text_width(line, 3.0) <= 60.0


def test_no_two_words_are_lost_in_wrapping():
    text = "a run that stalled because " + "x" * 90 + " could not be reached"
    assert "".join(wrapped(text, 3.0, 60.0)).replace(" ", "") == text.replace(" ", "")
