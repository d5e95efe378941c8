"""Answers to the course: right ones in any form, wrong ones with the hint for their mistake, garbage."""

import itertools
import re
import threading
import time
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy import sparse

import scenewidget as sw
from scenewidget import exercises
from scenewidget.datasets import analytic
from scenewidget.engine import consensus, distances, kmedoids
from scenewidget.exercises import agreement, graphs, laplacians, medoids, paths, poisson, reading, spectra
from scenewidget.exercises.judging import (
    FunctionExercise,
    NumberExercise,
    Verdict,
)

ALL = {name: exercises._exercise(name) for name in exercises.names()}


def of_kind(kind):
    return [name for name, exercise in ALL.items() if isinstance(exercise, kind)]


def right_answer(name):
    exercise = ALL[name]
    return exercise.right if isinstance(exercise, FunctionExercise) else exercise.right()


def foreseen():
    """(name, hint) of each mistake that is foreseen."""
    return [(name, hint) for name, exercise in ALL.items() for hint in exercise.mistakes]


def test_each_notebook_has_five_or_more_of_three_levels():
    for notebook in exercises._HOME:
        found = exercises.names(notebook)
        assert found == [f"{notebook}.{i + 1}" for i in range(len(found))]
        assert len(found) >= 5
        assert {ALL[name].level for name in found} == {1, 2, 3}


@pytest.mark.parametrize("name", ALL)
def test_its_own_solution_is_right(name):
    verdict = exercises.verdict(name, right_answer(name))
    assert verdict == Verdict(True, f"right: {ALL[name].why}")


@pytest.mark.parametrize("name", of_kind(NumberExercise))
def test_a_right_number_is_right_in_any_form(name):
    right = float(right_answer(name))
    forms = [right, np.float64(right), np.array(right), np.array([[right]]), [right], (right,), {right}]
    forms += [
        repr(right),
        f" {right} ",
        f"{right:.12g} m",
        Fraction(right),
        complex(right),
        {"answer": right},
    ]
    forms += (
        [f"{right:.3e}", f"{100 * right!r} %"] if right != round(right) else [round(right), f"{right:.0f}/1"]
    )
    if not (ALL[name].is_whole or ALL[name].is_exact):
        forms += [float(f"{right:.3g}"), float(f"{right:.2g}")]
    for form in forms:
        assert exercises.verdict(name, form).is_right, form


def test_numbers_in_words_of_their_own():
    for name, forms in {
        "03.1": ("1/4", "0,25", "¼", "2^-2", "25 %", "0.25 m", "1 ÷ 4"),
        "03.4": ("1/sqrt(3)", "1/√3", "0.577", "sqrt(3)/3", "3**-0.5"),
        "04.4": ("1000/(4π)", "250/pi", "79.6", "80"),
        "04.5": ("√5", "sqrt 5", "5**0.5", "2.24"),
    }.items():
        for form in forms:
            assert exercises.verdict(name, form).is_right, form


def test_words_and_lists_in_any_dress():
    for form in ("Upper Tip", '"upper tip"', ["upper tip"], b"upper  tip", np.array(["upper tip"])):
        assert exercises.verdict("05.1", form).is_right
    for form in (
        (190, 0),
        "190, 0",
        np.array([190, 0]),
        "[190 0]",
        {"first": 190, "last": 0},
        iter([190, 0.0]),
    ):
        assert exercises.verdict("06.2", form).is_right
    for form in ([5, 4, 3], {3, 4, 5}, "3,4,5", np.array([[3], [4], [5]]), range(3, 6)):
        assert exercises.verdict("07.5", form).is_right
    for form in ([0, 1, 2], "0 1 2", [1, 2, 12]):  # by number or by place
        assert exercises.verdict("07.1", form).is_right


def test_functions_may_give_sparse_dense_or_a_diagonal_matrix():
    for change in (
        lambda W, A: (sparse.csr_array(W), sparse.diags_array(A)),
        lambda W, A: [W.tolist(), np.diag(A)],
        lambda W, A: (W.astype(np.float32), A[:, None]),
    ):
        assert exercises.verdict("03.8", lambda v, f, c=change: c(*laplacians.assemble(v, f))).is_right
    for form in (lambda x, y: x**2 - y**2, lambda x, y: y * y - x * x + 3 * x):
        assert exercises.verdict("03.2", form).is_right
    assert exercises.verdict("03.2", laplacians.saddle().reshape(21, 21)).is_right
    pairs_both_ways = lambda faces: {(t, s) for s, t in graphs.neighbours(faces)}  # noqa: E731
    assert exercises.verdict("02.5", pairs_both_ways).is_right


@pytest.mark.parametrize(("name", "hint"), foreseen())
def test_each_mistake_gets_its_own_hint(name, hint):
    mistake = ALL[name].mistakes[hint]
    answer = mistake if isinstance(ALL[name], FunctionExercise) else mistake(right_answer(name))
    assert exercises.verdict(name, answer) == Verdict(False, f"not yet: {hint}")


def edited():
    """A session on another mesh, with one edit."""
    mesh = analytic.square(2)
    session = sw.Session(mesh, sw.Segmentation.from_labels(mesh, [0] * 4 + [1] * 4))
    session.relabel(0, "table")
    return session


@pytest.mark.parametrize(
    ("name", "answer", "text"),
    [
        ("03.2", lambda x, y: x * y, "the diagonals of this grid all run one way"),
        ("03.2", lambda x, y: x + y, "linear"),
        ("03.2", lambda x, y: x**2 + y**2, "a bowl"),
        ("03.2", lambda x, y: x**2 - 2 * y**2, "not equally much"),
        ("03.2", [1, 2], "441 vertices"),
        ("03.1", True, "not True or False"),
        ("03.1", "a quarter", "can't be read as a number"),
        ("03.1", [1, 2], "one number is asked for"),
        ("03.1", laplacians.radius, "call it"),
        ("03.1", float("nan"), "finite number"),
        ("02.1", 0.5, "whole number"),
        ("05.1", "left tip", "one of these is asked for: middle, right tip"),
        ("06.2", [1], "2 numbers are asked for"),
        ("06.2", [190, 7], "1 of 2 stand right"),
        ("07.1", [1, 4, 7], "the \\*best\\* result"),
        ("07.1", [1, 1, 2], "three different"),
        ("07.1", [-1, 4, 99], "0 to 8"),
        ("07.2", [0, 1], "give its name, without brackets"),
        ("07.2", lambda D, labels, k: None, "is there a `return`"),
        ("07.2", lambda D, labels, k: [0], "of shape 3 is asked for, yours is 1"),
        ("07.2", lambda D: 1, "it is called as update\\(D, labels, k\\)"),
        ("07.2", lambda D, labels, k: D[99], "raised IndexError"),
        ("05.6", lambda values, vectors, times: np.full((36, 7), np.nan), "holds NaN"),
        ("09.4", "yours", "an edited session is asked for"),
        ("09.4", edited(), "a session on the room of this notebook"),
        ("99.1", 1, "name must be that of an exercise, such as \".*\", got '99.1'"),
        (None, 1, "got something else \\(NoneType\\)"),
    ],
)
def test_wrong_forms_get_a_sentence_about_the_form(name, answer, text):
    verdict = exercises.verdict(name, answer)
    assert not verdict.is_right
    assert re.search(text, verdict.text), verdict.text


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("nothing", [..., None, "", [], {}, np.array([])], ids=repr)
def test_no_answer_is_no_mistake(name, nothing):
    verdict = exercises.verdict(name, nothing)
    is_function = isinstance(ALL[name], FunctionExercise) and nothing is not ... and nothing is not None
    assert verdict.text == "not answered yet" or is_function


def forever(*_):
    while True:
        pass


def stubborn(*_):
    while True:
        try:
            forever()
        except Exception:
            continue


class Nasty:
    """An answer whose every method raises."""

    def __getattribute__(self, name):
        raise RuntimeError("no")

    def __iter__(self):
        raise RuntimeError("no")

    def __float__(self):
        raise SystemExit

    def __len__(self):
        return 10**9


class Endless:
    def __iter__(self):
        return iter(int, 1)

    def __float__(self):
        forever()


def raises_something_unprintable(*_):
    class MuteError(Exception):
        def __str__(self):
            raise ValueError

    raise MuteError


GARBAGE = [
    Nasty(), Endless(), np.broadcast_to(0.0, (10**6, 10**6)), [0.5] * 10**6, "9" * 10**6, 10**5000,
    "((((" * 60, "9**9**9**9", b"\xff\xfe", object(), int, {1: {2: {}}}, [[[[]]]], np.array([None]),
    np.array("x"), 1j, sparse.csr_array((10**6, 10**6)), iter(int, 1), [float("inf")],
    np.zeros(2, [("a", int)]), slice(3),
]  # fmt: skip
BAD_FUNCTIONS = [
    forever, stubborn, raises_something_unprintable, lambda: 1, lambda *_: GARBAGE[0], lambda *_: GARBAGE[2],
    lambda *_: GARBAGE[3], lambda *_: "text", lambda *_: forever, lambda *_: {}, lambda *_: iter(int, 1),
    lambda *_: exit(3), lambda *_: time.sleep(3), lambda *_: (1, 2, 3), lambda *_: [[1], [1, 2]],
]  # fmt: skip


@pytest.mark.parametrize(
    "name", ["02.1", "02.5", "03.1", "03.2", "03.8", "05.1", "06.2", "07.1", "08.2", "09.4"]
)
def test_garbage_gets_a_sentence_within_a_second(name):
    exercises.verdict(name, 1)  # what is loaded once
    for answer in GARBAGE + (
        BAD_FUNCTIONS if isinstance(ALL[name], FunctionExercise) else BAD_FUNCTIONS[3:4]
    ):
        start = time.perf_counter()
        verdict = exercises.verdict(name, answer)
        assert time.perf_counter() - start < 2.0  # a second, and a busy machine
        assert not verdict.is_right
        assert "\n" not in verdict.text
        assert len(verdict.text) < 400


@pytest.mark.parametrize("name", ["03.8", "05.1"])
def test_what_is_too_large_to_be_written_out_never_is(name):
    entries = np.broadcast_to(0.0, (10**9,))  # 8 GB, or a list of 30 GB
    lists = [
        [range(10**9)],
        [0, range(10**9)],
        [itertools.count()],
        (range(10**9),) * 2,
        [[0] * 9_999] * 9_999,
    ]
    for large in (entries, lists, *lists):
        for answer in (large, lambda *_, large=large: large):
            assert exercises.verdict(name, answer).text.startswith("not yet: ")


def test_pairs_without_an_end_are_no_pairs():
    with pytest.raises(reading.UnreadableError, match="two columns"):
        reading.rows([itertools.count()] * 3)


def test_loops_that_nobody_waits_for_are_stopped():
    before = threading.active_count()
    assert "does a loop never end" in exercises.verdict("06.3", forever).text.lower()
    deadline = time.monotonic() + 5
    while threading.active_count() > before and time.monotonic() < deadline:
        time.sleep(0.02)
    assert threading.active_count() <= before


leaves = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary() | st.complex_numbers()
)
anything = st.recursive(
    leaves,
    lambda inner: st.lists(inner) | st.tuples(inner, inner) | st.dictionaries(st.text(), inner),
    max_leaves=6,
)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(name=st.sampled_from([name for name in ALL if not name.startswith("02")]), answer=anything)
def test_whatever_comes_a_sentence_comes_back(name, answer):
    for form in (answer, lambda *_: answer):
        verdict = exercises.verdict(name, form)
        assert verdict.text
        assert "\n" not in verdict.text
        assert verdict.is_right == verdict.text.startswith("right: ")


def test_students_may_write_into_what_they_get():
    def careless(D, labels, k):
        found = medoids.update(D.copy(), labels.copy(), k)
        D[:] = 0
        labels[:] = 0
        return found

    assert exercises.verdict("07.2", careless).is_right
    assert exercises.verdict("07.2", medoids.update).is_right


def test_check_prints_the_sentence_and_is_public(capsys):
    assert sw.exercises.check("3.1", Fraction(1, 4)) is None
    assert capsys.readouterr().out == f"right: {ALL['03.1'].why}\n"
    assert sw.exercises.question("03.1").startswith("A sphere")
    with pytest.raises(ValueError, match="name must be that of an exercise"):
        exercises.question("03.99")


# --- worked answers agree with the engine ------------------------------------------------------


def test_worked_answers_agree_with_the_engine():
    starts = ([0, 4, 8], [1, 7, 8], [0, 1, 2])
    for start in starts:
        cost = kmedoids.alternate(medoids.ON_LINE, np.array(start, dtype=np.int32)).cost
        assert medoids._cost_from(start) == cost
    star = np.array([[0, i] for i in range(1, 21)])
    factor = distances.MinPlusFactor(distances.weight_graph(21, star, np.ones(20)))
    assert len(factor.indices) - 20 == paths.fill_of_a_star()[1]  # minimum degree takes the middle last
    found = consensus.peac(np.kron(np.eye(3), np.ones((4, 4))), np.ones(12), 5)
    assert agreement.blocks() == [(found.Y.max(axis=1) > 0.5).sum(), pytest.approx(found.objective, abs=1e-6)]
    co = consensus.co_association(agreement.KEYS)
    np.testing.assert_allclose(co.C[np.ix_(co.base, co.base)], agreement.counts(agreement.KEYS))


def test_the_gradient_is_that_of_the_objective():
    def f(Y, C, a):
        return a @ (C - Y.T @ Y) ** 2 @ a

    for Y, C, a in agreement._soft().values():
        expected = np.zeros_like(Y)
        for m, j in np.ndindex(*Y.shape):
            h = np.zeros_like(Y)
            h[m, j] = 1e-5
            expected[m, j] = (f(Y + h, C, a) - f(Y - h, C, a)) / 2e-5
        np.testing.assert_allclose(agreement.gradient(Y, C, a), expected, atol=1e-6)


def test_heat_steps_of_the_engines_matrices_keep_all_heat():
    W, A = sw.engine.operators.cotangent_laplacian(analytic.sphere(1))
    u = np.zeros(A.shape[0])
    u[0] = 1.0
    assert (A @ spectra.heat_step(W, A, u, 0.1)).sum() == pytest.approx((A @ u).sum())


def test_the_divergence_of_the_gradient_is_the_cotangent_matrix():
    mesh = analytic.folded(analytic.square(4), "x", 0.5, 1.0)
    u = np.random.default_rng(0).random(mesh.n_vertices)
    slopes = poisson.gradient(mesh.vertices, mesh.faces, u)
    W, _ = sw.engine.operators.cotangent_laplacian(mesh)
    np.testing.assert_allclose(-poisson.divergence(mesh.vertices, mesh.faces, slopes), W @ u, atol=1e-12)


# --- for teachers ------------------------------------------------------------------------------


def test_one_command_writes_the_solutions(tmp_path, capsys):
    from scenewidget.exercises.__main__ import main

    main(["solutions", str(tmp_path / "new" / "folder")])
    pages = {path.stem: path.read_text() for path in (tmp_path / "new" / "folder").iterdir()}
    assert sorted(pages) == [f"solutions_{notebook}" for notebook in exercises._HOME]
    for name, exercise in ALL.items():
        text = pages[f"solutions_{name[:2]}"]
        assert f"## {name} " in text
        assert exercise.question in text
        assert exercise.why in text
    assert "**0.25**" in pages["solutions_03"]
    assert "def assemble(vertices" in pages["solutions_03"]
    assert len(capsys.readouterr().out.splitlines()) == len(pages)
    (tmp_path / "file").write_text("")
    with pytest.raises(SystemExit):
        main(["solutions", str(tmp_path / "file")])
    assert "FOLDER must be a folder" in capsys.readouterr().err


class OnlyAnArray:
    """As tensors of other packages: a number or numbers that NumPy can ask for, and nothing else."""

    def __init__(self, values):
        self.values = np.asarray(values)

    def __array__(self, dtype=None, copy=None):
        return self.values


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        *(("03.1", answer) for answer in ("r = 1/4", "≈ 0.25 m", "$0.25$", np.matrix([[0.25]]))),
        *(("03.1", answer) for answer in (OnlyAnArray(0.25), pd.DataFrame({"r": [0.25]}), 0.25 + 0j)),
        ("03.1", sparse.dok_array([[0.25]])),
        ("03.5", "80°"),
        ("14.1", "x = 2 and y = 3"),
        ("14.1", OnlyAnArray([2, 3])),
        *(("14.4", answer) for answer in ("“biharmonic”", "*biharmonic*", pd.Series(["biharmonic"]))),
        ("14.4", (word for word in ["biharmonic"])),
        ("02.5", lambda faces: pd.DataFrame(ALL["02.5"].right(faces))),
        ("10.7", lambda a, b, areas: areas[a & b].sum() / areas[a | b].sum() + 0j),
    ],
)
def test_what_is_as_good_as_a_number_a_list_or_a_word_is_read(name, answer):
    assert exercises.verdict(name, answer).is_right


@pytest.mark.parametrize(
    ("name", "answer", "sentence"),
    [
        ("01.2", np.ma.masked, "nothing may be masked"),
        ("03.1", sparse.coo_array(([0.25], ([0], [0])), shape=(10**9, 10**9)), "very long list"),
        ("10.7", lambda a, b, areas: 1j, "imaginary part"),
    ],
)
def test_what_only_looks_like_an_answer_is_told(name, answer, sentence):
    found = exercises.verdict(name, answer)
    assert not found.is_right
    assert sentence in found.text
