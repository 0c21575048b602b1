"""HTML of tables and pictures in notebooks."""

import base64
import re

from multisrt.extras.notebook import is_notebook, picture_html, table_html

EVIL = '<script>alert("1")</script>&\''


def test_all_texts_of_a_table_are_escaped():
    made = table_html(EVIL, [EVIL], [[EVIL]], notes=[EVIL])
    assert "<script" not in made
    assert made.count("&lt;script&gt;alert(&quot;1&quot;)&lt;/script&gt;&amp;&#x27;") == 5


def test_tables_have_no_colour_of_their_own():
    made = table_html("Times", ["world", "s"], [["maze", "12.0"]], notes=["note"])
    colours = re.findall(r"#[0-9a-f]{3,6}|rgba?\([^)]*\)", made)
    assert set(colours) == {"rgba(128, 128, 128, 0.45)"}
    assert "<script" not in made


def test_labels_are_left_and_numbers_right():
    made = table_html("", ["a", "b"], [["x", "1"]])
    assert re.findall(r"text-align: (\w+)", made) == ["left", "right", "left", "right"]


def test_pictures_are_images_so_that_nothing_in_them_clashes():
    made = picture_html("<svg onload='x()'/>", EVIL)
    assert "onload" not in made
    assert "<script" not in made
    data = re.search(r"base64,([^\"]+)\"", made)
    assert data is not None
    assert base64.b64decode(data[1]) == b"<svg onload='x()'/>"


def test_tests_run_in_no_notebook():
    assert not is_notebook()
