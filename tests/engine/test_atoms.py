"""The common refinement of labelings."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from scenewidget.engine.atoms import common_refinement

labelings = hnp.arrays(np.int32, (3, 12), elements=st.integers(-1, 4))


@given(labelings)
def test_atoms_are_the_coarsest_on_which_all_are_constant(columns):
    atoms = common_refinement(columns, 12)
    distinct = {tuple(row) for row in columns.T}
    assert len(atoms.first_face) == len(distinct) == atoms.face_atom.max() + 1
    for labels in columns:
        table = atoms.table(labels)
        np.testing.assert_array_equal(table[atoms.face_atom], labels)


@given(labelings)
def test_a_labeling_that_cuts_an_atom_has_no_table(columns):
    atoms = common_refinement(columns[:1], 12)
    is_finer = len({tuple(row) for row in columns[:2].T}) > len(set(columns[0].tolist()))
    assert (atoms.table(columns[1]) is None) == is_finer


def test_labels_with_huge_numbers_are_no_problem():
    columns = [np.array([0, 2**31 - 2, 5]), np.array([2**31 - 2, 7, 7])]
    assert common_refinement(columns, 3).face_atom.tolist() == [0, 2, 1]
