"""Large sparse matrices stay sparse."""

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

from nao_course.exercises.comparisons.large_sparse import without_dense


def test_a_large_sparse_matrix_refuses_to_be_dense_and_does_everything_else():
    large = scipy.sparse.eye_array(1800, format="csr")
    guarded = without_dense(large)
    with pytest.raises(MemoryError, match="leave it sparse"):
        guarded.toarray()
    assert scipy.sparse.linalg.splu(guarded.tocsc()).solve(np.ones(1800)).sum() == 1800
    small = scipy.sparse.eye_array(4, format="coo")
    assert without_dense(small) is small
