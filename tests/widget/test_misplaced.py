"""What is given to the wrong object is refused with the place where it belongs."""

import operator
from types import SimpleNamespace

import pytest
import traitlets

import scenewidget as sw
from scenewidget.datasets import analytic

MESH = analytic.square(2)
GIVEN = sw.Segmentation.from_labels(MESH, [0, 0, 0, 0, 1, 1, 1, 1])


@pytest.fixture(scope="module")
def made():
    """One of each, by the letter that messages use."""
    w = sw.SceneWidget(MESH, sw.Params(n_runs=2, n_graph_runs=2), autosave=False)
    found = {"w": w, "v": w.view, "c": sw.Compare(MESH, GIVEN, GIVEN)}
    found |= {"o": w.controls, "s": sw.Session(MESH, GIVEN)}
    yield found
    w.close()
    found["c"].close()


@pytest.mark.parametrize(
    ("which", "name", "hint"),
    [
        ("w", "width", "write w.layout.width = '600px'"),
        ("w", "truth", r"give it when the widget is made: SceneWidget\(…, truth=…\)"),
        ("w", "cost_exponent", r"write w.params = w.params.replace\(cost_exponent=…\)"),
        ("w", "section", "write w.view.section = …"),
        ("w", "heigth", "did you mean 'height'"),
        ("c", "theme", r"write w.views\[0\].theme = …"),
        ("c", "disagreement", r"give it when the widget is made: Compare\(…, disagreement=…\)"),
        ("c", "other", "did you mean 'others'"),
        ("v", "colour_by", "did you mean 'color_by'"),
        ("v", "backfaces", "did you mean 'back_faces'"),
        ("v", "background", "the theme chooses it"),
        ("v", "camera", r"call fit\(\), look_from_above"),
        ("v", "zoom", "there are: back_faces, boxes"),
        ("w", "labels", "it follows from the segmentation, which w.session edits"),
        ("o", "n_segments", r"write w.params = w.params.replace\(n_segments=…\)"),
        ("c", "params", r"each side has its own: write a = Params"),
        ("s", "labels", r"write session.paint\(faces, onto_face\)"),
        ("s", "colour", "names of your own begin with an underscore"),
    ],
)
def test_names_that_belong_elsewhere_are_not_set(made, which, name, hint):
    with pytest.raises(AttributeError, match=f"no '{name}' to set; {hint}"):
        setattr(made[which], name, 1)


def test_names_of_ones_own_are_told_apart_from_mistakes(made):
    class Mine(sw.SceneView):
        pass

    for widget in made.values():
        widget._my_notes = "the lamp"
        assert widget._my_notes == "the lamp"
    with pytest.raises(AttributeError, match="no 'sides' to set; names of your own begin with an underscore"):
        made["c"].sides = 3
    mine = Mine(MESH)
    mine.my_notes = "the lamp"
    mine.close()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("segmentation", r"read-only; w.session.resegment\(segmentation\) puts another one"),
        ("session", r"read-only; w.restore\(path\)"),
        ("params", r"expected a Params, not the int 3; write w.params = w.params.replace"),
    ],
)
def test_what_can_not_be_set_says_what_to_do(made, name, message):
    with pytest.raises(traitlets.TraitError, match=message):
        setattr(made["w"], name, 3)


@pytest.mark.parametrize(
    ("which", "name", "way"),
    [
        ("w", "pipeline", "another scan needs another widget"),
        ("w", "view", "write w.view.color_by = …"),
        ("w", "children", r"a box of yours holds it and more: VBox\(\[w, ...\]\)"),
        ("c", "children", "a box of yours holds it"),
        ("c", "views", "views of a Compare can.t be set"),
        ("v", "mesh", r"another view: SceneView\(mesh\)"),
        ("s", "mesh", "another scan needs another session"),
        ("s", "edits", "merge, split, paint … add to it"),
        ("s", "segmentation", r"session.resegment\(segmentation\)"),
    ],
)
def test_what_stays_is_not_exchanged(made, which, name, way):
    before = getattr(made[which], name)
    with pytest.raises(AttributeError, match=way):
        setattr(made[which], name, ())
    after = getattr(made[which], name)
    assert after is before or after == before


def test_edits_are_made_not_appended(made):
    with pytest.raises(TypeError, match="isn't noticed; merge, split, paint … make an edit"):
        made["s"].edits.append(3)
    assert made["s"].edits == []


def test_a_closed_widget_computes_no_more():
    w = sw.SceneWidget(MESH, sw.Params(n_runs=2, n_graph_runs=2), autosave=False)
    w.wait()
    w.close()
    for act in (lambda: setattr(w, "params", sw.Params()), lambda: w.restore("room.swproj")):
        with pytest.raises(RuntimeError, match="this SceneWidget is closed and computes no more"):
            act()


def test_a_handler_that_would_never_be_called_is_refused(made):
    with pytest.raises(ValueError, match="SceneWidget has no 'segmentations' to observe; did you mean 'seg"):
        made["w"].observe(print, "segmentations")
    with pytest.raises(ValueError, match="SceneView has no 'zoom' to observe; there are: back_faces, boxes"):
        made["v"].observe(print, ["level", "zoom"])


@pytest.mark.parametrize(
    ("name", "way"),
    [
        ("export", r"write sw.export\(w.segmentation, w.mesh, path\)"),
        ("run", "it computes by itself: set w.params"),
        ("show", "w as the last line of a cell"),
        ("on_click", r"w.observe\(handler, 'segmentation'\)"),
        ("screenshot", r"w.view.to_html\(path\)"),
        ("view.screenshot", r"to_html\(path\) a page"),
        ("view.reset_camera", r"call fit\(\)"),
        ("session.labels", "it is session.segmentation.labels"),
        ("session.rename", r"write session.relabel\(face, 'chair'\)"),
        ("session.smooth", "did you mean 'smooth_border'"),
        ("c.left", r"the pictures are views\[0\]"),
        ("c.color_by", r"it is views\[0\].color_by"),
    ],
)
def test_the_way_is_told_to_what_is_done_otherwise(made, name, way):
    made["w"].wait()
    with pytest.raises(AttributeError, match=way):
        operator.attrgetter(name)(SimpleNamespace(**made) if name[1] == "." else made["w"])


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        (sw.SceneWidget, {"n_segments": 3, "seed": 1}, r"Widget\(mesh, Params\(n_segments=3, seed=1\)\)"),
        (sw.Compare, {"n_runs": 3}, r"write Compare\(mesh, Params\(n_runs=3\)\)"),
        (sw.SceneWidget, {"color_by": "scan"}, "no option 'color_by'; set it of the picture"),
        (sw.SceneWidget, {"width": 300}, "no option 'width'; it fills its place"),
        (sw.SceneWidget, {"vocabluary": "nyu40"}, "did you mean 'vocabulary'"),
        (sw.Compare, {"x": 3}, "no option 'x'; there are: mesh, a, b, others, truth, disagreement, height"),
    ],
)  # fmt: skip
def test_options_that_belong_elsewhere_are_refused_before_anything_is_computed(kind, options, message):
    with pytest.raises(TypeError, match=message):
        kind(MESH, **options)


def test_the_height_of_a_comparison_is_that_of_all_its_pictures(made):
    made["c"].height = 300
    assert [made["c"].height, *(view.height for view in made["c"].views)] == [300, 300, 300]
