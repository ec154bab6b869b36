"""Thousands of broken zips, notebooks and answers: each has a reason or a verdict, soon, and nothing is written beside.

More of them, with other seeds: ``NAO_COURSE_MUTATIONS=20000 pytest tests/attacks/test_mutations.py``.
"""

import contextlib
import copy
import io
import json
import os
import random
import shutil
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from nao_course.codec import CodecError, decode, encode, registry
from nao_course.exercises import Case, Close, Derivative, Each, Exact, judging
from nao_course.exercises.comparisons import Methods, Points, Sampled, Unordered
from nao_course.exercises.comparisons.jacobians import jacobian
from nao_course.exercises.notebook_text import read_notebook
from nao_course.exercises.running import Outcome
from nao_course.instructor.autograding.failures import definition_lines
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.files import read
from nao_course.instructor.collecting.submissions import gather
from nao_course.instructor.sandbox import worker
from nao_course.instructor.sandbox.protocol import REPLY
from tests.attacks.accidents import FILE, HONEST, TEXT, packed
from tests.attacks.range import LESSON

MANY = int(os.environ.get("NAO_COURSE_MUTATIONS", 0))
SECONDS = 5.0  # of processor time for one: a guard against what grows without an end
WORDS = [b"PK\1\2", b"PK\3\4", b"PK\5\6", b"PK\6\6", b"PK\6\7"]
WORDS += [b"\0" * 8, b"\xff" * 8, b"../", b"\x1b[2J", b"\n"]
ODD = [
    *(None, True, 0, -1, 2**63, 10**400, 1e308, float("nan")),
    *("", "\ud800", "\0", "x" * 10_000, "code", ["\u2028"]),
    *([], {}, [[]], {"": {}}, [None] * 1000, {"cell_type": "code"}, {"nbgrader": {"grade_id": []}}),
]


def mutated(rng: random.Random, data: bytes) -> bytes:
    """Bytes with a few of them changed, lost, doubled, or words of a zip among them."""
    made = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(made) + 1)
        end = min(at + rng.choice((1, 2, 4, 30, 500)), len(made))
        match rng.randrange(6):
            case 0:
                made[at:end] = bytes(rng.randrange(256) for _ in range(end - at))
            case 1:
                del made[at:end]
            case 2:
                made[at:at] = made[at:end] * rng.randint(1, 5)
            case 3:
                made[at : at + 4] = rng.choice(WORDS)
            case 4:
                made[at : at + 4] = rng.choice((0, 1, 0xFFFF, 2**31, 2**32 - 1)).to_bytes(4, "little")
            case _:
                made[at:at] = rng.choice(WORDS)
    return bytes(made)


def odd(rng: random.Random, value: object) -> object:
    """A value of JSON with a few parts that are something else."""
    value = copy.deepcopy(value)
    for _ in range(rng.randint(1, 4)):
        at = value
        while isinstance(at, dict | list) and at:
            key = rng.choice(list(at)) if isinstance(at, dict) else rng.randrange(len(at))
            if rng.random() < 0.4 or not isinstance(at[key], dict | list):
                at[key] = copy.deepcopy(rng.choice(ODD))
                break
            at = at[key]
    return value


def empty(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()


@pytest.fixture
def rngs():
    """Generators of one seed each; each mutation has to be done within its time."""

    def make(fewest):
        for seed in range(MANY or fewest):
            began = time.process_time()
            yield random.Random(seed)
            assert time.process_time() - began < SECONDS, f"seed {seed}"

    return make


ZIPS = [
    packed((FILE, TEXT), ("helper.py", "x = 1"), ("receipt.json", '{"time": "2026-03-01T12:00:00+00:00"}')),
    packed((f"a/b/{FILE}", TEXT), (f"{LESSON} (1).ipynb", TEXT), ("../x.py", "x"), method=zipfile.ZIP_STORED),
    packed(("inner.zip", packed((FILE, TEXT))), (FILE, TEXT)),
]


@pytest.mark.slow
def test_a_broken_zip_has_a_reason_and_costs_little(rngs, tmp_path):
    taken = 0
    for rng in rngs(4000):
        data = mutated(rng, rng.choice(ZIPS))
        folder, scratch = tmp_path / "in" / "ada", tmp_path / "scratch"
        folder.mkdir(parents=True, exist_ok=True)
        empty(scratch)
        (folder / "work.zip").write_bytes(data)
        found = gather(tmp_path / "in", scratch, [LESSON])
        for each in (*found.submissions, *found.refused):
            assert each.student == "ada" and all(word.isprintable() for word in (each.reason, *each.notes))
            with contextlib.suppress(Refused):
                taken += bool(read(each).notebook)
        assert found.submissions or found.refused or found.not_graded, "somebody's work vanished"
    assert taken > 0
    assert {each.name for each in tmp_path.iterdir()} == {"in", "scratch"}
    assert not [each for each in (tmp_path / "in").rglob("*") if each.name not in ("ada", "work.zip")]


@pytest.mark.slow
def test_a_platforms_broken_zip_is_refused_as_a_whole_or_read(rngs, tmp_path):
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name in ("Ada L_1_assignsubmission_file_/", "Eve_2_assignsubmission_file_/", "bob/"):
            archive.writestr(name + FILE, TEXT)
            archive.writestr(name + "work.zip", ZIPS[0])
    for rng in rngs(1500):
        empty(tmp_path / "scratch")
        (tmp_path / "in.zip").write_bytes(mutated(rng, made.getvalue()))
        try:
            found = gather(tmp_path / "in.zip", tmp_path / "scratch", [LESSON])
        except ValueError:
            continue
        for each in found.submissions:
            with contextlib.suppress(Refused):
                read(each)
    assert {each.name for each in tmp_path.iterdir()} == {"in.zip", "scratch"}


@pytest.mark.slow
def test_a_broken_notebook_is_read_or_has_a_reason(rngs, tmp_path):
    path, good = tmp_path / FILE, 0
    for rng in rngs(4000):
        data = json.dumps(odd(rng, HONEST)).encode() if rng.random() < 0.7 else mutated(rng, TEXT.encode())
        path.write_bytes(data)
        try:
            text = read_notebook(path)
        except ValueError:
            pass
        else:
            good += 1
            assert all(isinstance(each, str) for pair in text.cells for each in pair)
            encode((dict(text.written), text.lesson, text.version))  # it goes to the grader
        assert all(isinstance(line, str) for _, line in definition_lines(data, "clamp"))
    assert good > 0


def answers():
    import sympy

    x = sympy.Symbol("x")
    at = {"x": np.arange(3.0)}
    raw = jacobian(lambda: (sympy.Matrix([x**2]), sympy.Matrix([2 * x])), at, ["x"])
    rows = np.arange(12.0).reshape(6, 2)
    law = {"law": (1.0, 1.0, True), "drawn": np.ones(4), "calls": 8}
    return [
        (Close(), Case((1.0,), expected=rows), rows),
        (Exact(), Case((1.0,), expected=("a", 3, True)), ("a", 3, True)),
        (Points(), Case((1.0,), expected=rows), rows),
        (Unordered(), Case((1.0,), expected=[1.0, (2.0, 3.0)]), [(2.0, 3.0), 1.0]),
        (Each({0: Exact()}), Case((1.0,), expected=(1, {"a": rows})), (1, {"a": rows})),
        (Methods(), Case(((), [("go", ())]), expected=[("go", rows)]), [("go", rows)]),
        (Sampled(), Case((1.0, 4), expected=law), [1.0, 2.0] * 4),
        (Derivative(("x",)), Case((at, ["x"])), raw),
    ]


@pytest.mark.slow
def test_a_broken_answer_has_a_verdict(rngs):
    kinds, read_whole = answers(), 0
    for rng in rngs(6000):
        comparison, case, value = rng.choice(kinds)
        frame = encode(Outcome("value", value))
        length = int.from_bytes(frame[4:12], "little")
        header, body = frame[20 : 20 + length], frame[20 + length :]
        if rng.random() < 0.8:
            header = json.dumps(odd(rng, json.loads(header))).encode()
        else:
            header, body = mutated(rng, header), mutated(rng, body)
        sizes = len(header).to_bytes(8, "little") + len(body).to_bytes(8, "little")
        try:
            outcome = decode(frame[:4] + sizes + header + body, REPLY)
        except CodecError:
            continue
        if not worker._well_formed(outcome) or outcome.status != "value":
            continue
        read_whole += 1
        gathered = judging.answer(comparison, lambda _, outcome=outcome: outcome, case)  # it must not raise
        try:
            with np.errstate(all="ignore"):
                judging.judge(comparison, case, gathered)
        except (ValueError, TypeError, KeyError, IndexError, AttributeError, OverflowError):
            pass  # the grader says that it could not be read
    assert read_whole > 0


@pytest.mark.slow
def test_no_value_of_the_courses_classes_takes_long_to_make_whatever_is_in_it(rngs):
    nodes = [None, True, -1, 2**40, {"f": "nan"}, {"f": "0x1p1000"}, {"s": ""}, {"s": "x" * 1000}, {"l": []}]
    nodes += [{"l": [2**40] * 50}, {"d": {}}, {"d": {"a": 1}}, {"t": [1, 2]}, {"c": ["nan", "nan"]}]
    for rng in rngs(3000):
        name, registered = rng.choice(sorted(registry._TYPES.items()))
        fields = {each: rng.choice(nodes) for each in registered.fields if rng.random() < 0.9}
        header = json.dumps({"o": name, "v": fields}).encode()
        try:
            decode(b"NAO1" + len(header).to_bytes(8, "little") + bytes(8) + header, REPLY)
        except CodecError:
            continue
