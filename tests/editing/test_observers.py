"""Who is told of what, and when."""

import threading

import pytest
from editing_strategies import box_session

pytestmark = pytest.mark.filterwarnings("ignore:.*edits do not apply:UserWarning")


def test_observers_hear_of_every_change_in_order_until_they_stop():
    session, heard = box_session(), []
    stop = session.observe(heard.append)
    session.merge(0, 40)
    session.undo()
    session.redo()
    session.vocabulary = ["desk", "chair", "desk"]
    session.resegment(session.automatic)
    stop()
    session.undo()
    assert [event.kind for event in heard] == ["edit", "undo", "redo", "vocabulary", "segmentation"]
    assert [event.revision for event in heard] == [1, 2, 3, 4, 5]
    assert session.vocabulary == ("desk", "chair")


def test_whoever_is_told_of_a_walk_through_the_history_does_not_hold_others_up():
    session = box_session()
    session.merge(0, 40)
    session.merge(40, 70)
    seen = []

    def look_from_elsewhere(event):
        looking = threading.Thread(target=lambda: seen.append((event.kind, len(session.history))))
        looking.start()
        looking.join(10)
        assert not looking.is_alive()

    session.observe(look_from_elsewhere)
    session.go_to(0)
    session.go_to(2)
    assert seen == [("undo", 0), ("undo", 0), ("redo", 2), ("redo", 2)]
