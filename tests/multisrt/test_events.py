from typing import get_args

from multisrt import events


def test_every_event_is_offered_and_may_be_in_a_recording():
    defined = {
        kind for kind in events.Event.__subclasses__() if kind.__module__.startswith("multisrt.")
    }
    assert defined == set(get_args(events.AnyEvent))
    assert all(getattr(events, kind.__name__) is kind for kind in defined)
    assert {kind.__name__ for kind in defined} <= set(events.__all__)


def test_events_have_tags_of_their_own():
    tags = [kind.__struct_config__.tag for kind in get_args(events.AnyEvent)]
    assert len(set(tags)) == len(tags)
    assert set(get_args(events.NotedEvent)) < set(get_args(events.AnyEvent))
