import os
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multisrt.environments.formats import worldfile
from multisrt.environments.formats.worldfile import Entity, parse_worldfile
from multisrt.geometry.errors import MapFormatError


@pytest.fixture
def parse(tmp_path):
    def write_and_parse(text, **files):
        for name, content in files.items():
            (tmp_path / f"{name}.inc").write_text(content)
        path = tmp_path / "a.world"
        path.write_text(text, newline="")
        return parse_worldfile(path)

    return write_and_parse


def values(entity):
    return {name: found.values for name, found in entity.properties.items()}


def tree(entity):
    return entity.kind, values(entity), [tree(child) for child in entity.children]


def test_properties_entities_comments_and_tuples(parse):
    text = """# a comment with "quotes" ( and [ brackets
    resolution .02 name "a # b"  # the end
    window ( size [ 635.000 -6. ] scale 1e1
      center [ ] )
    robot(name "r0" laser ( pose[0 0
    90 ] point[0] [1 "x"] ) )"""
    for ends in ("\n", "\r\n"):
        root = parse(text.replace("\n", ends)).root
        assert tree(root) == (
            "",
            {"resolution": (0.02,), "name": ("a # b",)},
            [
                ("window", {"size": (635.0, -6.0), "scale": (10.0,), "center": ()}, []),
                (
                    "robot",
                    {"name": ("r0",)},
                    [("laser", {"pose": (0.0, 0.0, 90.0), "point[0]": (1.0, "x")}, [])],
                ),
            ],
        )


def test_macros_are_expanded_and_overridden_in_order(parse):
    root = parse(
        """define base model ( color "red" size [1 1 1] ranger ( fov 1 ) )
        define derived base ( color "blue" ranger ( fov 2 ) )
        define derived position ( color "green" )
        derived ( size [2 2 2] color "gray" color "black" block ( points 3 ) )"""
    ).root
    (entity,) = root.children
    assert (entity.kind, entity.word) == ("model", "derived")
    assert values(entity) == {"color": ("black",), "size": (2.0, 2.0, 2.0)}
    assert [tree(child) for child in entity.children] == [
        ("ranger", {"fov": (1.0,)}, []),
        ("ranger", {"fov": (2.0,)}, []),
        ("block", {"points": (3.0,)}, []),
    ]
    assert root.children[0].place.endswith("a.world, line 4")


def test_a_macro_may_be_named_as_a_type(parse):
    (entity,) = parse("block ( pose [1 2 0 0] ) define block model ( )").root.children
    assert (entity.kind, entity.word) == ("model", "block")


def test_includes_are_read_where_they_stand(parse):
    found = parse(
        'a ( include "one.inc" c 3 )\ninclude "two.inc"\ninclude "none.inc" include "none.inc"',
        one='b 2 include "two.inc"',
        two="d ( )",
    )
    inner: tuple = ("d", {}, [])
    assert tree(found.root) == ("", {}, [("a", {"b": (2.0,), "c": (3.0,)}, [inner]), inner])
    assert found.missing == ("none.inc",)
    assert found.root.children[0].children[0].place.endswith("two.inc, line 1")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a ( b 1", r"line 1: the \( of a is not closed"),
        ("a 1\n)", r"line 2: a \) closes nothing"),
        ("pose [1, 2]", r"line 1: ',' does not belong in .* separated by spaces"),
        ("pose [1 2", r"line 1 is the end of the file; the tuple of pose is not closed"),
        ("pose [1 [2] ]", r"line 1: '\[' is in the tuple of pose"),
        ("pose [1 x]", r"line 1: 'x' is in the tuple of pose"),
        ("\nname robot1\n", r"line 2: name is followed by 'robot1'; a value is"),
        ('name "a\nb"', "line 1: a string has no closing quote"),
        ("name", "line 1 is the end of the file; name is followed by a value"),
        ("12 a", "line 1: '12' stands where a name is expected"),
        ("a 1.2.3", "line 1: '1.2.3' is not a number"),
        ("a -", "line 1: '-' is not a number"),
        ("a 5cm", "line 1: '5cm' is not a number"),
        (f"a {'9' * 400}", "line 1: '9+[.]*.* is too large"),
        ("a % 2", "line 1: '%' does not belong in a world file"),
        ("a é", "line 1: 'é' does not belong in a world file"),
        ("define a ( )", "line 1: define is followed by a name, a type and"),
        ("define a b 1", "line 1: define is followed by a name, a type and"),
        ("define a", "line 1 is the end of the file; define is followed by"),
        ("a ( define b c ( ) )", "line 1: define is followed by 'b'"),
        ("include 5", "line 1: include is followed by '5'"),
        ("include", "ends after include"),
        ('include "../b.inc"', r"line 1 names the file '\.\./b\.inc', which is not in the folder"),
        ('include "/etc/passwd"', "line 1 names the file '/etc/passwd', which is not in the fold"),
        ('include "loop.inc"', "again.inc, line 1: loop.inc includes itself"),
        ('include "a.world"', "line 1: a.world includes itself"),
        ('include "bad.inc"', r"bad\.inc, line 3: a \) closes nothing"),
        ("define a a ( ) a ( )", "line 1: a is defined by itself"),
        ("define a b ( ) define b a ( ) b ( )", "line 1: b is defined by itself"),
        ("define a model ( a ( ) ) a ( )", "line 1: entities are nested more than 32 deep"),
        ("a (" * 40 + ")" * 40, "line 1: entities are nested more than 32 deep"),
    ],
)
def test_fault_is_named_with_its_place(parse, text, message):
    with pytest.raises(MapFormatError, match=message):
        parse(
            text,
            bad="\n\n)",
            loop='a 1\ninclude "again.inc"',
            again='include "loop.inc"\ninclude "again.inc"',
        )


def test_a_link_out_of_the_folder_is_not_followed(parse, tmp_path):
    folder = tmp_path / "maps"
    folder.mkdir()
    (tmp_path / "secret.inc").write_text("a 1")
    os.symlink(tmp_path / "secret.inc", folder / "b.inc")
    (folder / "a.world").write_text('include "b.inc"')
    with pytest.raises(MapFormatError, match=r"'b\.inc', which is not in the folder"):
        parse_worldfile(folder / "a.world")


def test_macros_and_includes_are_bounded(parse, monkeypatch):
    doubled = "".join(f"define m{n + 1} model ( m{n} ( ) m{n} ( ) )\n" for n in range(1, 25))
    with pytest.raises(MapFormatError, match=r"more than 200,000 properties and entities when"):
        parse(f"define m1 model ( a 1 )\n{doubled} m25 ( )")
    with pytest.raises(MapFormatError, match="includes at most 64 files, 16 in a chain"):
        parse('include "one.inc"\n' * 65, one="\n")
    monkeypatch.setattr(worldfile, "MAX_TOKENS", 9)
    with pytest.raises(MapFormatError, match="has more than 9 words, with all includes"):
        parse('include "one.inc"\n' * 3, one="a 1 b 2")
    monkeypatch.setattr(worldfile, "MAX_WORLD_BYTES", 9)
    with pytest.raises(MapFormatError, match=r"a\.world has 12 bytes"):
        parse("a ( b 100 ) ")


def test_a_chain_of_includes_is_bounded(tmp_path):
    for number in range(20):
        (tmp_path / f"{number}.inc").write_text(f'include "{number + 1}.inc"')
    with pytest.raises(MapFormatError, match=r"16\.inc, line 1: a world includes at most"):
        parse_worldfile(tmp_path / "0.inc")


# Properties ---------------------------------------------------------------------------------

words = st.from_regex(r"[A-Za-z][A-Za-z0-9._-]{0,5}(\[[0-9]{1,2}\])?", fullmatch=True).filter(
    lambda word: word not in ("define", "include")
)
texts = st.text(
    st.characters(codec="utf-8", exclude_characters='"', exclude_categories=("Cc", "Cs")),
    max_size=6,
)
numbers = st.floats(allow_nan=False, allow_infinity=False)
properties = st.dictionaries(words, st.lists(texts | numbers, max_size=4).map(tuple), max_size=3)
entities: st.SearchStrategy = st.recursive(
    st.tuples(words, properties, st.just([])),
    lambda inner: st.tuples(words, properties, st.lists(inner, max_size=3)),
    max_leaves=6,
)
gaps = st.lists(st.sampled_from([" ", "\t", "\n", "\r\n", '# no ( "\n']), min_size=1, max_size=3)


def written(entity, gap, draw):
    """The text of the content of an entity, with random space between its tokens."""
    _, properties_, children = entity
    words_ = []
    for name, content in properties_.items():
        shown = [f'"{one}"' if isinstance(one, str) else repr(one) for one in content]
        single = len(shown) == 1 and draw(st.booleans())
        words_ += [name, *(shown if single else ["[", *shown, "]"])]
    for child in children:
        words_ += [child[0], "(", written(child, gap, draw), ")"]
    return "".join(word + gap for word in words_)


@settings(deadline=None)
@given(properties, st.lists(entities, max_size=3), gaps.map("".join), st.data())
def test_random_worlds_are_read_back(own, children, gap, data):
    world = ("", own, children)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.world"
        path.write_text(written(world, gap, data.draw) + gap, newline="")
        assert tree(parse_worldfile(path).root) == world


SAMPLE = """unit_angle "degrees" # a comment
define floorplan model ( color "gray30" boundary 1 block ( points 3 point[0] [ 0 0 ] ) )
define robot position ( size [0.6 .4 -1e-2] ranger ( sensor ( range [0 8.] ) ) )
include "map.inc"
floorplan ( name "lab" bitmap "lab.png" size [20.000 20.000 0.500] pose [ -1 0 0 90.000 ] )
robot ( pose [2.451 7.364 0 0] )
"""


@settings(deadline=None, max_examples=200)
@given(
    st.lists(
        st.tuples(
            st.integers(0, len(SAMPLE)),
            st.integers(0, 5),
            st.text('()[]"#.-+e0123 \n\tadefinclub_é', max_size=4),
        ),
        max_size=4,
    )
)
def test_mutated_worlds_are_read_or_refused(changes):
    text = SAMPLE
    for at, length, new in changes:
        text = text[:at] + new + text[at + length :]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.world"
        path.write_text(text, encoding="utf-8")
        try:
            found = parse_worldfile(path)
        except MapFormatError:
            return
        assert isinstance(found.root, Entity)
