"""Large sparse matrices stay sparse."""

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

from nao_course.exercises.comparisons.large_sparse import without_dense


def test_a_large_sparse_matrix_refuses_to_be_dense_and_does_everything_else():
    large = scipy.sparse.eye_array(1800, format="csr")
    guarded = without_dense(large)
    with pytest.raises(MemoryError, match="1800 x 1800 numbers, most of them 0: leave it sparse"):
        guarded.toarray()
    with pytest.raises(MemoryError, match="leave it sparse"):
        guarded.todense()
    assert scipy.sparse.linalg.splu(guarded.tocsc()).solve(np.ones(1800)).sum() == 1800
    small = scipy.sparse.eye_array(4, format="coo")
    assert without_dense(small) is small
    guarded = without_dense(scipy.sparse.diags_array(np.arange(1.0, 1801.0), format="csc"))
    some = np.array([3, 5])
    assert np.array_equal(guarded[some][:, some].toarray(), np.diag([4.0, 6.0]))
    columns = scipy.sparse.linalg.spsolve(guarded, scipy.sparse.csc_array(np.eye(1800, 2)))
    assert columns.toarray()[1, 1] == 0.5 and columns[[1]].todense().shape == (1, 2)
