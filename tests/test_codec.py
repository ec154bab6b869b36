"""What goes through the codec comes back the same, and what a stranger sends does no harm."""

import contextlib
import struct
import subprocess
import sys
import tracemalloc
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from nao_course.exercises.codec import CodecError, Limits, decode, encode, register

DTYPES = ["?", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f2", "f4", "f8", "c8", "c16", ">f8", ">i4"]
arrays = hnp.arrays(
    st.sampled_from([np.dtype(name) for name in DTYPES]),
    hnp.array_shapes(min_dims=0, min_side=0, max_side=4),
)
leaves = (
    st.none()
    | st.booleans()
    | st.integers(-(2**500), 2**500)
    | st.floats()
    | st.text(st.characters(exclude_categories=["Cs"]))
    | st.binary()
    | arrays
)
values = st.recursive(
    leaves,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(inner, max_size=4).map(tuple)
        | st.dictionaries(st.text(max_size=5), inner, max_size=4)
    ),
    max_leaves=12,
)


@register
@dataclass(frozen=True)
class Pair:
    first: object
    second: object

    def __post_init__(self):
        if isinstance(self.first, str) and self.first == "refused":
            raise ZeroDivisionError


def same(one, other):
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.shape == other.shape and one.tobytes() == other.astype(one.dtype).tobytes()
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    return one == other or (one != one and other != other)


def frame(header, body=b""):
    header = header if isinstance(header, bytes) else header.encode()
    return struct.pack("<4sQQ", b"NAO1", len(header), len(body)) + header + body


@given(values)
@example(-0.0)
@example("\u2028 é 🤖 \0")
@example(2**53 + 1)
def test_a_value_comes_back_as_it_was(value):
    assert same(value, decode(encode(value)))


@given(values)
def test_the_same_value_has_the_same_bytes(value):
    assert encode(value) == encode(decode(encode(value)))


def test_registered_dataclasses_and_generators_travel():
    rng = np.random.default_rng(5)
    pair = decode(encode(Pair(np.arange(3), (rng, None))))
    assert isinstance(pair, Pair)
    assert pair.second[0].random() == rng.random()


def test_numpy_numbers_keep_their_type():
    for number in (np.float32(0.1), np.int8(-3), np.bool_(True)):
        back = decode(encode(number))
        assert type(back) is type(number)
        assert back == number


def test_what_comes_back_is_plain_and_its_own():
    class Liar(np.ndarray):
        def __eq__(self, other):
            return True

    given_array = np.zeros(3).view(Liar)
    back = decode(encode(given_array))
    assert type(back) is np.ndarray
    back[0] = 1
    assert np.asarray(given_array)[0] == 0
    assert type(decode(encode(np.ma.masked_array([1.0], [True])))) is np.ndarray


def test_a_view_comes_back_in_its_own_order():
    array = np.arange(12).reshape(3, 4)
    for view in (array.T, array[::-1, ::2], np.broadcast_to(array[0], (5, 4))):
        np.testing.assert_array_equal(decode(encode(view)), view)


class Text(str):
    pass


@pytest.mark.parametrize(
    "value",
    [
        lambda: 1,
        object(),
        {1, 2},
        {1: 2},
        range(3),
        iter([]),
        Text("x"),
        np.array([object()]),
        np.array(["text"]),
        np.array(["2020"], dtype="datetime64"),
        np.zeros(2, dtype="i4,f8"),
        np.longdouble(1),
        2**600,
        "half \ud800",
        np.random.Generator(np.random.Philox(1)),
        CodecError("x"),
        Pair,
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_is_not_plain_cannot_be_sent(value):
    for wrapped in (value, [value], {"a": value}, Pair(1, value)):
        with pytest.raises(CodecError):
            encode(wrapped)


def test_a_type_is_named_when_it_cannot_be_sent():
    with pytest.raises(CodecError, match="type function"):
        encode((1, lambda: 1))


def test_an_endless_value_ends():
    endless = []
    endless.append(endless)
    with pytest.raises(CodecError, match="deeper"):
        encode(endless)


def peak(action):
    tracemalloc.start()
    try:
        with pytest.raises(CodecError):
            action()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "value",
    [
        np.broadcast_to(0.0, (10**6, 10**6)),
        [np.zeros(10**5)] * 10**5,
        [b"x" * 10**5] * 10**5,
        ["x" * 10**5] * 10**5,
        [None] * 10**7,
    ],
    ids=["one huge array", "one array often", "bytes", "text", "many"],
)
def test_a_value_too_large_is_refused_before_it_is_made(value):
    limits = Limits(size=10**6)
    assert peak(lambda: encode(value, limits)) < 2 * 10**7


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"NAO1",
        b"XAO1" + bytes(16),
        struct.pack("<4sQQ", b"NAO1", 2**63, 0),
        struct.pack("<4sQQ", b"NAO1", 2, 2**63),
        frame("["),
        frame("[1]"),
        frame("1.5"),
        frame("NaN"),
        frame('"text"'),
        frame("{}"),
        frame('{"z":1}'),
        frame('{"i":"zz"}'),
        frame('{"i":5}'),
        frame('{"f":"one"}'),
        frame('{"f":1}'),
        frame('{"s":1}'),
        frame('{"b":1}'),
        frame('{"b":-1}'),
        frame('{"b":true}', b"x"),
        frame('{"b":1}', b"xy"),
        frame('{"l":1}'),
        frame('{"l":"abc"}'),
        frame('{"t":{"l":[]}}'),
        frame('{"d":[]}'),
        frame('{"a":"|O","shape":[1],"b":8}', bytes(8)),
        frame('{"a":"<f8","shape":[2],"b":8}', bytes(8)),
        frame('{"a":"<f8","shape":[-1],"b":8}', bytes(8)),
        frame('{"a":"<f8","shape":[true],"b":8}', bytes(8)),
        frame('{"a":"<f8","shape":' + str([1] * 70) + ',"b":8}', bytes(8)),
        frame('{"a":"<f8","shape":[4294967296,4294967296,0,4294967296],"b":1}', bytes(1)),
        frame('{"a":["<f8"],"shape":[1],"b":8}', bytes(8)),
        frame('{"a":"<f8","b":8}', bytes(8)),
        frame('{"n":{"a":"<f8"}}'),
        frame('{"o":"os:system","v":{}}'),
        frame('{"o":"nao_course.cli:app","v":{}}'),
        frame('{"o":["x"],"v":{}}'),
        frame('{"o":"nao_course.exercises.exercise:Case","v":{"nothing":1}}'),
        frame('{"g":{"d":{"bit_generator":{"s":"PCG64"}}}}'),
        frame('{"g":1}'),
        frame("[" * 100_000),
        frame('{"l":[' * 100 + "]}" * 100),
        frame("1" * 5000),
        frame(b"\xff\xfe"),
    ],
)
def test_what_is_no_frame_is_refused(data):
    with pytest.raises(CodecError):
        decode(data)


def test_a_registered_class_that_refuses_its_values_is_no_frame():
    broken = (
        encode(Pair("accepted", 1)).replace(b"accepted", b"refused ").replace(b'"refused "', b'"refused" ')
    )
    with pytest.raises(CodecError, match="ZeroDivisionError"):
        decode(broken)


SAMPLE = encode([{"a": 1.5, "b": "text"}, np.arange(6.0).reshape(2, 3), (None, True, 2**80), Pair(b"xyz", 1)])


@settings(max_examples=500)
@given(st.integers(0, 8 * len(SAMPLE) - 1))
def test_a_flipped_bit_gives_a_value_or_a_refusal(bit):
    data = bytearray(SAMPLE)
    data[bit // 8] ^= 1 << bit % 8
    with contextlib.suppress(CodecError):
        decode(bytes(data))


def test_a_truncated_or_longer_frame_is_refused():
    for length in range(len(SAMPLE)):
        with pytest.raises(CodecError):
            decode(SAMPLE[:length])
    with pytest.raises(CodecError):
        decode(SAMPLE + b"x")


@given(st.binary(max_size=200), st.binary(max_size=50))
def test_noise_in_a_frame_gives_a_value_or_a_refusal(header, body):
    with contextlib.suppress(CodecError):
        decode(frame(header, body))


@pytest.mark.parametrize(
    "data",
    [
        frame("[" + "[]," * 10**6 + "[]]"),
        frame('{"l":[' + "null," * 10**6 + "null]}"),
        frame('{"l":[' + '{"l":[]},' * 10**5 + "null]}"),
    ],
)
def test_a_frame_takes_memory_as_it_is_long(data):
    assert peak(lambda: decode(data, Limits(nodes=1000))) < 60 * len(data)


def test_a_header_that_is_too_long_is_not_read():
    data = frame('{"s":"' + "x" * 10**6 + '"}')
    assert peak(lambda: decode(data, Limits(header=10**5))) < 10**5
    with pytest.raises(CodecError):
        encode("x" * 10**6, Limits(header=10**5))


def test_two_classes_of_one_name_cannot_be_registered():
    other = dataclass(type("Pair", (), {"__module__": Pair.__module__, "__qualname__": "Pair"}))
    with pytest.raises(TypeError, match="already"):
        register(other)
    with pytest.raises(TypeError, match="dataclasses"):
        register(int)
    assert register(Pair) is Pair


def test_only_a_trusted_frame_has_modules_imported():
    code = (
        "import sys; from nao_course.exercises.codec import decode, CodecError\n"
        "data = sys.stdin.buffer.read()\n"
        "try: decode(data)\nexcept CodecError as e: print('refused')\n"
        "print('nao_course.slam' in sys.modules)\n"
        "try: decode(data, trusted=True)\nexcept CodecError as e: print('refused')\n"
        "print('nao_course.slam' in sys.modules)\n"
    )
    data = frame('{"o":"nao_course.slam:Nothing","v":{}}')
    run = subprocess.run([sys.executable, "-c", code], input=data, capture_output=True, check=True)
    assert run.stdout.split() == [b"refused", b"False", b"refused", b"True"]
