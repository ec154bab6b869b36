"""What goes through the codec comes back the same, and what a stranger sends does no harm."""

import contextlib
import json
import struct
import subprocess
import sys
import tracemalloc
import warnings
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from nao_course.codec import CodecError, Limits, decode, encode, register

DTYPES = ["?", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f2", "f4", "f8", "c8", "c16", ">f8", ">i4"]
arrays = hnp.arrays(
    st.sampled_from([np.dtype(name) for name in DTYPES]), hnp.array_shapes(min_dims=0, min_side=0, max_side=4)
)
plain = st.none() | st.booleans() | st.integers(-(2**500), 2**500) | st.floats() | st.complex_numbers()
leaves = plain | st.binary() | st.text(st.characters(exclude_categories=["Cs"])) | arrays
numbers = st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.floats(allow_nan=False)
keys = st.recursive(
    numbers | st.text(max_size=3), lambda of: st.lists(of, max_size=3).map(tuple), max_leaves=4
)


def containers(inner):
    lists = st.lists(inner, max_size=4)
    return lists | lists.map(tuple) | st.dictionaries(st.text(max_size=5) | keys, inner, max_size=4)


values = st.recursive(leaves, containers, max_leaves=12)


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
def test_a_value_comes_back_as_it_was_and_has_the_same_bytes(value):
    assert same(value, decode(encode(value)))
    assert encode(value) == encode(decode(encode(value)))


def test_dataclasses_generators_numbers_and_views_travel_and_long_doubles_become_doubles():
    rng = np.random.default_rng(5)
    pair = decode(encode(Pair(np.arange(3), (rng, None))))
    assert isinstance(pair, Pair) and pair.second[0].random() == rng.random()
    for number in (np.float32(0.1), np.int8(-3), np.bool_(True)):
        back = decode(encode(number))
        assert type(back) is type(number) and back == number
    array = np.arange(12).reshape(3, 4)
    for view in (array.T, array[::-1, ::2], np.broadcast_to(array[0], (5, 4))):
        np.testing.assert_array_equal(decode(encode(view)), view)
    for number in (np.longdouble(0.1), np.clongdouble(0.1 + 2j)):
        for value in (number, np.full((2, 3), number)):
            back = np.asarray(decode(encode(value)))
            assert back.dtype in ("f8", "c16") and np.all(back == value)
    assert peak(lambda: encode(np.broadcast_to(np.longdouble(1), (10**6, 10**6)))) < 10**6


class Pretends:
    """Says that it is an array, and raises when it is asked for one."""

    __class__ = np.ndarray

    def __array__(self, *_):
        raise ZeroDivisionError


class Broken(np.random.Generator):
    @property
    def bit_generator(self):
        raise ZeroDivisionError


class Nameless(type):
    @property
    def __module__(cls):
        raise ZeroDivisionError


class Loud(np.ndarray):
    """An array all of whose properties are a stranger's code."""

    def __array__(self, *_, **__):
        raise AssertionError

    dtype = nbytes = shape = property(__array__)  # type: ignore[assignment]
    tobytes = astype = __array__  # type: ignore[assignment]


def test_what_comes_back_is_plain_and_its_own_and_a_type_that_cannot_be_sent_is_named():
    given_array = np.zeros(3).view(Loud)
    back = decode(encode(given_array))
    assert type(back) is np.ndarray
    back[0] = 1
    assert np.ndarray.tobytes(given_array) == bytes(24)
    assert type(decode(encode(np.ma.masked_array([1.0], [True])))) is np.ndarray
    endless = []
    endless.append(endless)
    for value, said in (((1, lambda: 1), "type function"), (endless, "deeper")):
        with pytest.raises(CodecError, match=said):
            encode(value)
    back = decode(frame('{"a":"|b1","shape":[3],"b":3}', b"\0\1\2"))
    assert back.tobytes() == b"\0\1\1"


@pytest.mark.parametrize(
    "value",
    [
        *(lambda: 1, object(), {1, 2}, {b"x": 2}, {np.nan: 2}, {(1, (2.0, None, frozenset())): 2}, range(3)),
        *(iter([]), np.array([object()]), np.array(["text"]), np.array(["2020"], dtype="datetime64")),
        *(np.zeros(2, dtype="i4,f8"), 2**600, "half \ud800", np.random.Generator(np.random.Philox(1))),
        *(CodecError("x"), Pair, Pretends(), object.__new__(Pair), Broken(np.random.PCG64(1))),
        Nameless("Odd", (), {})(),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_is_not_plain_cannot_be_sent(value):
    for wrapped in (value, [value], {"a": value}, Pair(1, value)):
        with pytest.raises(CodecError):
            encode(wrapped)


def peak(action, error=CodecError):
    tracemalloc.start()
    try:
        with pytest.raises(error) if error else contextlib.nullcontext():
            action()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_a_value_too_large_is_refused_before_it_is_made_and_another_takes_about_twice_its_size():
    limits, text = Limits(size=10**6, header=2**18), "x" * 10**5
    lists = ([each] * 10**5 for each in (np.zeros(10**5), text.encode(), text))
    for value, most in (
        *((each, 2e7) for each in (np.broadcast_to(0.0, (10**6, 10**6)), [None] * 10**7, *lists)),
        *((letter * 2**20, 2**18) for letter in ("x", "\N{ROBOT FACE}", "\0")),
    ):
        assert peak(lambda value=value: encode(value, limits)) < most
    array = np.zeros(2**21, np.uint8)
    assert peak(lambda: encode([array[::2]] * 4), error=None) < 2.5 * 2**22


OF_8 = bytes(8)


def of_generator(state):
    return frame('{"g":{"d":{"bit_generator":{"s":"PCG64"}' + state + "}}}")


NO_FRAMES = [
    *(b"", b"NAO1", b"XAO1" + bytes(16)),
    *(struct.pack("<4sQQ", b"NAO1", 2**63, 0), struct.pack("<4sQQ", b"NAO1", 2, 2**63)),
    *map(frame, ("[", "[1]", "1.5", "NaN", '"text"', "{}", '{"z":1}', "[" * 10**5, "1" * 5000, b"\xff\xfe")),
    *map(frame, ('{"i":"zz"}', '{"i":5}', '{"f":"one"}', '{"f":1}', '{"s":1}', '{"b":1}', '{"b":-1}')),
    *map(frame, ('{"l":1}', '{"l":"abc"}', '{"t":{"l":[]}}', '{"d":[]}', '{"l":[' * 100 + "]}" * 100)),
    *map(frame, ('{"s":"\\ud800"}', '{"d":{"\\ud800":1}}', '{"s":"\u00e9"}', '{"s":"x"}'.encode("utf-16"))),
    *map(frame, ("1" + "0" * 160, '{"i":"0x' + "f" * 200 + '"}', '{"o":"os:system","v":{}}')),
    *map(frame, ('{"g":1}', '{"o":["x"],"v":{}}', '{"o":"nao_course.cli:app","v":{}}')),
    frame('{"o":"nao_course.exercises.case:Case","v":{"nothing":1}}'),
    *map(of_generator, ("", ',"state":{"d":{"state":1.0,"inc":1}}')),
    *(frame('{"b":true}', b"x"), frame('{"b":1}', b"xy"), frame('{"n":{"a":"<f8"}}')),
    *(frame(f'{{"a":"<f8","shape":[{size}],"b":8}}', OF_8) for size in ("2", "-1", "true", "1," * 69 + "1")),
    *(frame('{"a":"|O","shape":[1],"b":8}', OF_8), frame('{"a":["<f8"],"shape":[1],"b":8}', OF_8)),
    *(frame('{"a":"<f8","b":8}', OF_8), frame('{"n":{"a":"<f8","shape":[1],"b":8}}', OF_8)),
    frame('{"a":"<f8","shape":[4294967296,4294967296,0,4294967296],"b":1}', bytes(1)),
]


@pytest.mark.parametrize("data", NO_FRAMES)
def test_what_is_no_frame_is_refused(data):
    with pytest.raises(CodecError):
        decode(data)


SAMPLE = encode([{"a": 1.5, "b": "text"}, np.arange(6.0).reshape(2, 3), (None, True, 2**80), Pair(b"xyz", 1)])


def test_a_frame_that_is_truncated_longer_or_refused_by_its_class_is_refused_and_a_long_one_takes_little():
    for data in (*(SAMPLE[:length] for length in range(len(SAMPLE))), SAMPLE + b"x"):
        with pytest.raises(CodecError):
            decode(data)
    broken = encode(Pair("accepted", 1)).replace(b'"accepted"', b'"refused" ')
    with pytest.raises(CodecError, match="ZeroDivisionError"):
        decode(broken)
    rest = ('{"l":[', "null,", "null]}"), ('{"l":[', '{"l":[]},', "null]}")
    for start, part, end in (("[", "[],", "[]]"), *rest):
        data = frame(start + part * 10**5 + end)
        assert peak(lambda data=data: decode(data, Limits(nodes=1000))) < 60 * len(data)
    data = frame('{"s":"' + "x" * 10**6 + '"}')
    assert peak(lambda: decode(data, Limits(header=10**5))) < 10**5


def test_two_classes_of_one_name_cannot_be_registered():
    other = dataclass(type("Pair", (), {"__module__": Pair.__module__, "__qualname__": "Pair"}))
    with pytest.raises(TypeError, match="already"):
        register(other)
    for thing in (int, 5, lambda: 1, "Pair", tuple):
        with pytest.raises(TypeError, match="can be registered"):
            register(thing)
    assert register(Pair) is Pair


def test_only_a_trusted_frame_has_modules_imported_and_only_the_courses():
    code = (
        "import sys; from nao_course.codec import decode, CodecError\n"
        "data = sys.stdin.buffer.read()\n"
        "try: decode(data)\nexcept CodecError as e: print('refused')\n"
        "print('nao_course.sim.light' in sys.modules)\n"
        "try: decode(data, trusted=True)\nexcept CodecError as e: print('refused')\n"
        "print('nao_course.sim.light' in sys.modules)\n"
    )
    data = frame('{"o":"nao_course.sim.light:Nothing","v":{}}')
    run = subprocess.run([sys.executable, "-c", code], input=data, capture_output=True, check=True)
    assert run.stdout.split() == [b"refused", b"False", b"refused", b"True"]
    with pytest.raises(CodecError, match="unknown type"):
        decode(frame('{"o":"this:Nothing","v":{}}'), trusted=True)
    assert "this" not in sys.modules


NUMBERS = st.sampled_from([0, 1, 2, 8, -1, 2**31, 2**62, 2**63 - 1, 2**64, 10**155]) | st.integers()
WORDS = st.sampled_from(
    [
        *("<f8", "<f4", "|b1", "|u1", "<c16", ">f8", "|O", "<U4", "<M8[s]", "0x1.8p+1", "nan", "-inf"),
        *("0x1p99999", "-0xff", "0x" + "f" * 128, "0x" + "f" * 129, "PCG64", "PCG64DXSM", "bit_generator"),
        *(f"nao_course.{name}" for name in ("exercises.case:Case", "exercises.running:Outcome", "cli:app")),
        *("nao_course.exercises.comparisons.values:Close", "csr_array", "coo_matrix", f"{__name__}:Pair"),
        *("builtins:object", "value", "refused", "first", "second", "\ud800", "\udfff\ud800"),
    ]
)
KEYS = st.sampled_from([*"ifsbanltdgovmcuq", "parts", "shape", "first", "second", "args", "status", "\ud800"])
anything = st.recursive(
    st.none() | st.booleans() | NUMBERS | WORDS | st.floats(),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=20,
)


@st.composite
def nodes(draw, depth=3):
    """A header's node that is right but for what it is made of."""
    if depth == 0 or draw(st.integers(0, 9)) == 0:
        return draw(anything)
    inner, fixed = nodes(depth - 1), st.fixed_dictionaries
    shape = st.lists(st.sampled_from([0, 1, 1, 2, 3, -1, True, 2**32, 2**62, 2**63]), max_size=4)
    dtype = st.sampled_from(["<f8", "|b1", "|u1", "<c16", "<f2", "|O"])
    array = fixed({"a": dtype, "shape": shape, "b": NUMBERS})
    long_shape = array.map(lambda node: node | {"shape": [1] * draw(st.integers(30, 70)), "b": 1})
    state = fixed({"d": fixed({"state": NUMBERS, "inc": NUMBERS})})
    rest = dict.fromkeys(("has_uint32", "uinteger"), NUMBERS | inner)
    generator = fixed({"bit_generator": st.just({"s": "PCG64"}), "state": state} | rest)
    of = dict.fromkeys("ifu", WORDS) | dict.fromkeys("lt", st.lists(inner, max_size=3))
    of |= {"n": array, "b": NUMBERS, "s": WORDS | st.text(), "d": st.dictionaries(WORDS, inner, max_size=3)}
    of |= {"g": fixed({"d": generator}), "c": st.lists(WORDS, min_size=2, max_size=2)}
    of |= {"m": st.lists(st.lists(inner, min_size=2, max_size=2), max_size=3)}
    whole = {"o": WORDS, "v": st.dictionaries(KEYS, inner, max_size=2)}
    sparse = {"q": WORDS, "shape": shape, "parts": st.lists(array, max_size=3)}
    kinds = [{name: strategy} for name, strategy in of.items()] + [whole, sparse]
    return draw(st.one_of(NUMBERS, array, long_shape, *map(fixed, kinds)))


def lawful(data, limits=None):
    """Decode: it is refused, or a value that can be sent on; nothing else, and not a word on the way."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            value = decode(data, limits)
        except CodecError:
            return
        encode(value)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(nodes(), st.binary(max_size=40))
@example({"d": {"x": {"s": "\ud800"}}}, b"")
@example({"l": [10**155]}, b"")
@example({"i": "0x" + "f" * 129}, b"")
def test_a_frame_of_the_right_words_gives_what_can_be_sent_on_or_a_refusal(node, body):
    lawful(frame(json.dumps(node), body))


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(nodes(), st.binary(max_size=40), st.data())
def test_a_key_that_is_given_twice_gives_a_value_or_a_refusal(node, body, data):
    text = json.dumps(node)
    at = data.draw(st.sampled_from([i for i, letter in enumerate(text) if letter == "{"] or [0]))
    extra = json.dumps(data.draw(anything))
    lawful(frame(f'{text[: at + 1]}"{data.draw(KEYS.filter(str.isascii))}":{extra},{text[at + 1 :]}', body))


def parts(data):
    header, _ = struct.unpack("<4xQQ", data[:20])
    return data[20 : 20 + header], data[20 + header :]


@settings(max_examples=500, deadline=None)
@given(values, values, st.data())
def test_true_frames_that_are_cut_flipped_and_spliced_give_a_value_or_a_refusal(one, other, data):
    (header, body), (header2, body2) = parts(encode(one)), parts(encode(other))
    for _ in range(data.draw(st.integers(1, 3))):
        first, second = data.draw(st.integers(0, len(header))), data.draw(st.integers(0, len(header2)))
        match data.draw(st.sampled_from(["splice", "cut", "flip", "bodies"])):
            case "splice":
                header = header[:first] + header2[second:]
            case "cut":
                header = header[:first]
            case "flip" if header:
                changed = bytearray(header)
                changed[min(first, len(header) - 1)] ^= 1 << data.draw(st.integers(0, 7))
                header = bytes(changed)
            case _:
                body = body + body2
    lawful(frame(header, body))


@given(st.integers(0, 2**64 - 1), st.integers(0, 2**64 - 1), st.binary(max_size=30))
def test_announced_lengths_are_believed_only_where_they_are_true(header, body, rest):
    data = struct.pack("<4sQQ", b"NAO1", header, body) + rest
    assert header + body == len(rest) or peak(lambda: decode(data)) < 10**5


SMALL = Limits(size=2**20, header=2**18, nodes=5000)
EMPTY = ",".join(f'{{"a":"{kind}","shape":[0],"b":0}}' for kind in ("<f8", "<i4", "<i4"))
HOSTILE = {
    "empty lists": "[]",
    "empty dicts": "{}",
    "dicts of one": '{"":0}',
    "lists of one": '{"l":[{"l":[]}]}',
    "empty arrays": '{"a":"<f8","shape":[0],"b":0}',
    "arrays of no rows": '{"a":"<f8","shape":[0,1099511627776],"b":0}',
    "texts": '{"s":"' + "x" * 40 + '"}',
    "long numbers": "1" * 4300,
    "long hexadecimal numbers": '{"i":"0x' + "f" * 10_000 + '"}',
    "floats": '{"f":"0x1p1"}',
    "generators": '{"g":{"d":{"bit_generator":{"s":"PCG64"}}}}',
    "maps": '{"m":[[1,2]]}',
    "complex numbers": '{"c":["0x1p1","0x1p1"]}',
    "sparse matrices": '{"q":"coo_array","shape":[1000000,1000000],"parts":[' + EMPTY + "]}",
    "types": f'{{"o":"{__name__}:Pair","v":{{"first":1,"second":1}}}}',
}


def filled(each, length):
    """A header of about some length that holds one thing over and over."""
    return frame('{"l":[' + ",".join([each] * (length // (len(each) + 1) - 2)) + "]}")


@pytest.mark.slow
@pytest.mark.parametrize("kind", HOSTILE)
def test_a_full_frame_takes_memory_by_the_limits_only(kind):
    data = filled(HOSTILE[kind], SMALL.header)
    assert peak(lambda: lawful(data, SMALL), error=None) < 40 * SMALL.header + 1500 * SMALL.nodes


@pytest.mark.slow
@pytest.mark.parametrize("kind", HOSTILE)
def test_a_frame_of_the_largest_header_is_read_or_refused(kind):
    lawful(filled(HOSTILE[kind], Limits().header), Limits())
