"""Every kind of value that a lesson hands over: it comes back as what it is, and no class of a stranger's has a say."""

import collections
import enum
import json
import subprocess
import sys
import time
import tracemalloc
from typing import NamedTuple

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from nao_course.codec import CodecError, Limits, decode, encode, register, register_function
from nao_course.codec.format import MAGIC, PREFIX
from nao_course.geometry import Pose
from nao_course.sim import CameraView, Field, Landmark, OdometryNoise, Picture, SensorNoise
from nao_course.sim.render import VisibleLandmark
from nao_course.slam import Estimate, Measurement, Motion

nan = float("nan")
VIEW = CameraView((64, 48), 1.0, 0.8, 0.5, 0.3)
ESTIMATE = Estimate(Pose(1.0, 2.0, 3.0), np.eye(3), [[1.0, 2.0]], [np.eye(2)], ("post",))


@register
class Row(NamedTuple):
    bearing: float
    range: float = 1.0


@register
def double(value):
    return 2 * value


register_function("numpy:hypot", np.hypot)


class Size(enum.IntEnum):
    SMALL = 3


class Name(str):
    """A text that lies about itself."""

    def lie(self, *_):
        raise AssertionError

    __str__ = __repr__ = encode = __len__ = __iter__ = __format__ = isascii = lie  # type: ignore[assignment]


class Numbers(list):
    def __iter__(self):
        return iter([b"lie"])


class Table(dict):
    def items(self):
        raise AssertionError

    __iter__ = keys = values = __len__ = __getitem__ = items  # type: ignore[assignment]


class Whole(int):
    def bit_length(self):
        raise AssertionError

    __int__ = __index__ = bit_length


class Pair(NamedTuple):
    first: object
    second: object


class Liar(Pair):
    _fields = ("first", "second", "third")  # type: ignore[misc]


def frame(header, body=b""):
    text = json.dumps(header).encode()
    return PREFIX.pack(MAGIC, len(text), len(body)) + text + body


@pytest.mark.parametrize(
    "value",
    [
        *(Pose(1.0, 2.0, 3.0), Motion(1.0, 0.5), Measurement(0.1, 2.0, "post"), ESTIMATE, VIEW),
        *(Landmark(1.0, 2.0, "corner", "L"), Field(2013, False, Pose()), OdometryNoise(), SensorNoise(0.1)),
        VisibleLandmark(Landmark(1.0, 2.0, "post", "post"), (1.5, 2.5), 3.0, 0.1, False),
        *([Pose(), {3: Pose(1.0)}], {3: [Motion()], "3": None}, {(1, "a"): 1, None: 2, True: 3, 2.5: 4}),
        *(Row(1.0, 2.0), [Row(1.0)], 1 + 2j, complex(nan, -0.0), np.hypot, double, {"distance": np.hypot}),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_value_of_the_library_comes_back_as_it_was(value):
    back = decode(encode(value))
    assert type(back) is type(value)
    assert repr(back) == repr(value) and encode(back) == encode(value)


def test_a_picture_comes_back_as_it_was_and_a_dict_of_texts_is_written_as_ever():
    picture = Picture(np.arange(64 * 48 * 3, dtype=np.uint8).reshape(48, 64, 3), VIEW, "top")
    back = decode(encode(picture))
    assert back.view == VIEW and np.array_equal(back.pixels, picture.pixels)
    assert b'{"d":{"a":1,"b":null}}' in encode({"a": 1, "b": None})
    assert b'"m"' in encode({1: 1})


@pytest.mark.parametrize(
    ("value", "plain"),
    [
        *((np.str_("text"), "text"), (np.bytes_(b"abc"), b"abc"), (Name("text"), "text"), (Whole(5), 5)),
        *((Size.SMALL, 3), (Numbers([1, 2]), [1, 2]), (Table({"a": 1}), {"a": 1}), (Pair(1, "x"), (1, "x"))),
        *((Liar(1, "x"), (1, "x")), (collections.OrderedDict(a=1), {"a": 1})),
        (collections.defaultdict(list, {1: [2]}), {1: [2]}),
        (collections.Counter("aab"), {"a": 2, "b": 1}),
        ({np.int64(3): 1, np.str_("a"): 2, np.bool_(True): 3}, {3: 1, "a": 2, True: 3}),
        ({Size.SMALL: 1, Name("k"): 2, Pair(1, np.int8(2)): 3}, {3: 1, "k": 2, (1, 2): 3}),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_value_of_a_subclass_becomes_a_plain_one_without_its_class_being_asked(value, plain):
    back = decode(encode([value]))[0]
    assert type(back) is type(plain) and back == plain
    if isinstance(plain, dict):
        assert [type(key) for key in back] == [type(key) for key in plain]


def test_what_is_no_key_cannot_be_sent_nor_another_function_of_a_name():
    for key in [nan, 1j, b"x", frozenset(), (1, nan), np.bytes_(b"k"), Pose()]:
        with pytest.raises(CodecError):
            encode({"k": 1, key: 1})
        with pytest.raises(CodecError, match="two keys"):
            encode({Same("a"): 1, Same("a"): 2})

    def double(value):
        return value

    double.__qualname__ = "double"
    with pytest.raises(TypeError, match="already"):
        register(double)
    with pytest.raises(TypeError, match="functions"):
        register_function("x", "not a function")  # type: ignore[arg-type]
    with pytest.raises(CodecError, match="function"):
        encode(double)


class Same(str):
    """A text that equals no other, so that a dict can hold it twice."""

    __eq__ = object.__eq__
    __hash__ = str.__hash__


PERIOD = 2**61 - 1  # of the hash of whole numbers: all its multiples have one hash


@pytest.mark.parametrize("key", [lambda i: i * PERIOD, lambda i: {"t": [i * PERIOD, 1]}])
def test_keys_that_are_made_to_be_alike_are_refused_before_a_dict_takes_minutes(key):
    began = time.process_time()
    with pytest.raises(CodecError, match="alike"):
        decode(frame({"m": [[key(i), None] for i in range(30_000)]}))
    assert time.process_time() - began < 5
    for step in (1, 2**20, 10**6, 1e-3):  # keys of a grid are none of those
        cells = {(i * step, -j * step): None for i in range(60) for j in range(60)}
        assert decode(encode(cells)) == cells
        row = {i * step: None for i in range(-5000, 5000)}
        assert decode(encode(row)) == row


@pytest.mark.parametrize("function", [np.sin, len, lambda: 0, [].append, json.JSONEncoder().encode])
def test_a_function_that_was_not_called_is_named(function):
    with pytest.raises(CodecError, match="call this function with its arguments"):
        encode(function)


def test_an_expression_of_sympy_is_told_from_other_strangers_and_no_class_passes_for_a_registered_one():
    for value in (sympy.cos(1), [sympy.cos(1)], np.array([1.0, sympy.cos(1)]), sympy.Matrix([1, 2])):
        with pytest.raises(CodecError, match=r"expressions of SymPy: use np\.cos"):
            encode(value)
    with pytest.raises(CodecError, match="dtype object cannot be sent$"):
        encode(np.array([1.0, None]))
    claims = {"__module__": Row.__module__, "__qualname__": Row.__qualname__}
    impostor = type("Row", (), {**claims, "bearing": 1.0, "range": 2.0})
    with pytest.raises(CodecError, match="type Row cannot be sent"):
        encode(impostor())


TYPE = f"{__name__}:Row"
POSE, FIELD = "nao_course.geometry:Pose", "nao_course.sim.field:Field"
SENSELESS = [
    *({"m": each} for each in (1, [[1]], [[1, 2, 3]], [[1, 2], [True, 3]], [[{"f": "0x1p0"}, 2], [1, 3]])),
    *({"m": [[key, 2]]} for key in ({"f": "nan"}, {"l": []}, {"t": [{"d": {}}]})),
    *({"c": each} for each in (["0x1p0"], [1, 2], "ab", ["0x1p99999", "0x1p0"])),
    *({"u": each} for each in ("os:system", "nao_course.exercises.running:call", 1, f"{__name__}:frame")),
    *({"o": TYPE, "v": each} for each in ({}, {"bearing": 1, "other": 2})),
    *({"o": POSE, "v": {"x": each}} for each in ({"f": "nan"}, {"l": []})),
    *({"o": FIELD, "v": each} for each in ({"rules": {"l": []}}, {"pose": 1})),
    {"o": f"{__name__}:Pair", "v": {"first": 1, "second": 2}},
    {"o": "nao_course.slam:Measurement", "v": {"bearing": 1, "range": -1}},
    {"o": "nao_course.slam:Measurement", "v": {"bearing": 1, "range": 1, "kind": {"s": "cat"}}},
    {"o": "nao_course.sim.nao:SensorNoise", "v": {"bearing": -1}},
    {"o": "nao_course.sim.nao:Picture", "v": {"pixels": 1, "view": 1, "camera": 1}},
]


@pytest.mark.parametrize("header", SENSELESS, ids=lambda header: json.dumps(header)[:60])
def test_a_frame_with_what_makes_no_sense_is_refused(header):
    for wrapped in (header, {"l": [header]}):
        with pytest.raises(CodecError):
            decode(frame(wrapped))


FORMATS = ("csr_array", "csc_array", "coo_array", "csr_matrix", "csc_matrix", "coo_matrix")


@settings(deadline=None)
@given(st.sampled_from(FORMATS), st.integers(0, 4), st.integers(0, 4), st.integers(0, 2**32))
def test_a_sparse_matrix_comes_back_in_its_format(kind, rows, columns, seed):
    rng = np.random.default_rng(seed)
    dtype = rng.choice(["f8", "f4", "i4", "?", "c16", "u1"])
    dense = (rng.normal(size=(rows, columns)) * 3 * rng.integers(0, 2, (rows, columns))).astype(dtype)
    matrix = getattr(sparse, kind)(dense)
    back = decode(encode(matrix))
    assert type(back) is type(matrix) and back.dtype == matrix.dtype and back.shape == matrix.shape
    assert np.array_equal(back.toarray(), dense)
    assert encode(back) == encode(matrix)


def test_entries_at_one_place_are_summed_and_other_formats_become_csr():
    for kind in ("lil_array", "dok_matrix", "dia_array", "bsr_matrix"):
        back = decode(encode(getattr(sparse, kind)(np.diag([1.0, 2.0]))))
        assert back.format == "csr" and back.toarray().tolist() == [[1, 0], [0, 2]]
    half = sparse.csr_array(np.eye(2))
    half.data = half.data.astype(np.float16)
    assert decode(encode(half)).dtype == np.float32
    back = decode(encode(Lies(np.eye(2))))
    assert type(back) is sparse.csr_array and back.toarray().tolist() == [[1, 0], [0, 1]]
    places = (np.array([1, 0, 0]), np.array([0, 1, 1]))
    given_matrix = sparse.csc_array(sparse.coo_array((np.array([5.0, 1.0, 2.0]), places), shape=(2, 2)))
    back = decode(encode(sparse.coo_matrix((np.array([5.0, 1.0, 2.0]), places), shape=(2, 2))))
    assert back.nnz == 2 and back.toarray().tolist() == [[0, 3], [5, 0]]
    arrived = decode(encode(given_matrix))
    before = encode(arrived)
    arrived.sort_indices()
    arrived.sum_duplicates()
    assert encode(arrived) == before


class Lies(sparse.csr_array):
    """A sparse matrix whose methods are a stranger's code."""

    def tocsr(self, copy=False):
        raise AssertionError

    tocoo = sum_duplicates = copy = toarray = tocsr  # type: ignore[assignment]


def arrays(*given):
    nodes, body = [], b""
    for each in given:
        data = np.asarray(each)
        nodes.append({"a": data.dtype.str, "shape": list(data.shape), "b": data.nbytes})
        body += data.tobytes()
    return nodes, body


FINE = ([1.0, 2.0], np.array([0, 1], "i4"), np.array([0, 1, 2], "i4"))
ONES = [1.0, 2.0]
NO_SPARSE = [
    *(("csr_array", [2, 2], (ONES, indices, [0, 1, 2])) for indices in ([0, 2], [0, -1], [0], [0.0, 1.0])),
    *(("csr_array", [2, 2], (ONES, [0, 1], ends)) for ends in ([0, 2, 1], [1, 1, 2], [0, -5, 2], [0, 2])),
    ("csr_array", [2, 2], (ONES, [0, 1], np.array([0, 2**63 + 1, 2], np.uint64))),
    *(("csr_array", [2, 2], given) for given in (([ONES], [0, 1], [0, 1, 2]), (ONES, [0, 1]))),
    *(("csr_array", shape, FINE) for shape in ([2, 10**9], [2, -1], [2, 2.0], [2, True], [2], [2, 2, 1])),
    *(("csc_matrix", [1, 2], FINE), ("lil_array", [2, 2], FINE), ("linalg", [2, 2], FINE)),
    *(("coo_array", [2, 2], (ONES, *places)) for places in (([0, 2], [0, 1]), ([0, 1], [0, 1, 1]))),
    ("coo_matrix", [10**9, 10**9], (np.zeros(0), np.zeros(0, "i8"), np.zeros(0, "i8"))),
]


@pytest.mark.parametrize(("kind", "shape", "given"), NO_SPARSE)
def test_a_frame_that_is_no_sparse_matrix_is_refused(kind, shape, given):
    nodes, body = arrays(*FINE)
    assert decode(frame({"q": "csr_array", "shape": [2, 2], "parts": nodes}, body)).nnz == 2
    nodes, body = arrays(*given)
    with pytest.raises(CodecError, match="sparse matrix"):  # it is not scipy that has to notice
        decode(frame({"q": kind, "shape": shape, "parts": nodes}, body))


INDICES = st.sampled_from([[], [0], [0, 1], [0, 1, 2], [0, 0, 2], [2, 1], [-1, 0], [0, 2**31], [0, 1, 2**62]])
SIZES = st.sampled_from([0, 1, 2, 3, 10**6, 10**6 + 1, -1, True, 2**62, None, "2"])


@settings(max_examples=300, deadline=None)
@given(
    st.sampled_from([*FORMATS, "dia_array", "save_npz", 1, None]),
    st.lists(SIZES, max_size=3),
    st.sampled_from(["<f8", "|b1", "<c16", "<f2", "|u1"]),
    st.lists(INDICES, max_size=3),
    st.sampled_from(["<i4", "<i8", "<u8", "<f8", "|b1"]),
)
def test_a_sparse_matrix_of_any_parts_is_one_that_can_be_sent_on_or_refused(kind, shape, dtype, given, of):
    with np.errstate(all="ignore"):
        indices = [np.array(each, dtype=np.int64).astype(of) for each in given]
    data = np.ones(len(given[0]) if given else 0, dtype=dtype)
    nodes, body = arrays(data, *indices)
    try:
        value = decode(frame({"q": kind, "shape": shape, "parts": nodes}, body))
    except CodecError:
        return
    encode(value)
    value.toarray if max(value.shape) > 9 else value.toarray()


def test_a_sparse_matrix_too_large_is_refused_before_it_is_copied():
    many = np.broadcast_to(1.0, 10**6)
    for matrix in (
        sparse.coo_array((10**9, 10**9)),
        sparse.dok_array((10**7, 10**7)),
        sparse.csr_array((many, np.zeros(10**6, "i4"), [0, 10**6]), shape=(1, 1)),
        sparse.dia_array((many[None], [0]), shape=(10**6, 10**6)),
    ):
        tracemalloc.start()
        with pytest.raises(CodecError):
            encode(matrix, Limits(size=10**6))
        assert tracemalloc.get_traced_memory()[1] < 10**6
        tracemalloc.stop()


def test_scipy_is_imported_for_a_sparse_matrix_only_and_may_be_imported_meanwhile(monkeypatch):
    code = (
        "import sys, nao_course.exercises, nao_course.geometry\n"
        "from nao_course.exercises import decode, encode, Close\n"
        "assert Close().compare({1: 1.0}, decode(encode({1: 1.0})))\n"
        "print('scipy.sparse' in sys.modules, 'scipy' in sys.modules)\n"
        "decode(sys.stdin.buffer.read())\n"
        "print('scipy.sparse' in sys.modules)\n"
    )
    data = encode(sparse.csr_array(np.eye(2)))
    run = subprocess.run([sys.executable, "-c", code], input=data, capture_output=True, check=True)
    assert run.stdout.split() == [b"False", b"False", b"True"]
    monkeypatch.setitem(sys.modules, "scipy.sparse", type(sys)("scipy.sparse"))
    assert decode(encode([Pose(), np.hypot])) == [Pose(), np.hypot]
