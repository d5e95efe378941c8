"""Observers that fail."""

import numpy as np
import pytest
import traitlets

import scenewidget as sw
from scenewidget.datasets import analytic
from scenewidget.widget.observing import FaultTolerant
from scenewidget.widget.scene_view import SceneView


def broken(change):
    raise ZeroDivisionError("theirs")


class Lamp(FaultTolerant):
    is_on = traitlets.Bool()


def test_a_broken_observer_is_shown_and_the_others_are_told(capsys):
    lamp, heard = Lamp(), []
    lamp.observe(broken, "is_on")
    lamp.observe(heard.append, "is_on")
    lamp.is_on = True
    assert [change["new"] for change in heard] == [True]
    assert "ZeroDivisionError: theirs" in capsys.readouterr().err
    lamp.unobserve(broken, "is_on")
    lamp.unobserve(heard.append, "is_on")
    lamp.is_on = False
    assert len(heard) == 1


def test_a_computation_goes_well_whoever_listens_badly(capsys):
    w = sw.SceneWidget(analytic.square(3), sw.Params(n_runs=2, n_graph_runs=2), autosave=False)
    for owner, name in ((w, "segmentation"), (w, "busy"), (w.view, "status"), (w.view, "progress")):
        owner.observe(broken, name)
    w.params = w.params.replace(seed=1)
    assert w.wait(60).n_segments >= 1
    assert (w.view.error, w.busy) == ("", False)
    assert "theirs" in capsys.readouterr().err
    w.close()


def test_own_methods_still_raise():
    class Fuse(FaultTolerant):
        is_on = traitlets.Bool()

        def check(self, change):
            raise ValueError("own")

    fuse = Fuse()
    fuse.observe(fuse.check, "is_on")
    with pytest.raises(ValueError, match="own"):
        fuse.is_on = True


def test_a_view_tells_others_too():
    view, heard = SceneView(analytic.square(2)), []
    view.observe(broken, "n_segments")
    view.observe(heard.append, "n_segments")
    view.set_segments(np.zeros(8, int))
    assert len(heard) == 1
    view.close()
