"""The course's language, as far as a pattern can judge it.

``python -m tests.language FILE ...`` lists a file's offences with their lines.
"""

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from tests.paths import PROJECT


@dataclass(frozen=True)
class Banned:
    """A pattern that must not appear in prose; a space matches any white space, also the end of a line."""

    pattern: str
    say: str  # instead
    # Contexts in which the pattern is right, each with the reason: patterns whose match includes the offence's.
    allowed: dict[str, str] = field(default_factory=dict)


PERSON = (
    r"(?:you|us|me|them|her|him|students?|someone"
    r"|(?:the|a|each|your) (?:student|reader|teacher|instructor|author)s?)"
)
THING = r"(?:the|a|an|each|this|that|its)"
PROSE = (
    # The glossary's left column
    Banned(r"slopes?", "derivative, gradient, Jacobian", {
        rf"slopes? of {THING} (?:\w+ )?(?:lines?|edges?|segments?|ramp|ground|lawn|floor|hill|curve|graph)":
            "geometry: a line in a picture has a slope",
        r"uphill slope|downhill slope": "a hill"}),
    Banned(r"doubt(?:s|ed|ful)?", "uncertainty, standard deviation, covariance", {
        r"(?:no|any|without(?: a)?|beyond|in|when in) doubt": "plain English: a person decides"}),
    Banned(r"unsure|how (?:sure|surely)|as sure as|surely", "uncertainty, standard deviation, covariance"),
    Banned(r"surpris(?:e|es|ed|ing)", "innovation (of a filter), residual (of a graph)", {
        rf"surpris(?:e|es|ed|ing) {PERSON}|{PERSON} (?:is |are |was |were |be )?surprised": "a person is surprised",
        r"surprising(?:ly)? (?:well|few|many|small|large|often|result|fact)": "plain English about a result"}),
    Banned(r"spread of (?:the|an|its|each) innovations?|innovation's spread", "innovation covariance S"),
    Banned(r"sights?", "measurement, observation; frame, if it is a picture", {
        r"lines? of sight|(?:in|out of|at first|lose|loses|lost|within) sight": "plain English"}),
    Banned(r"(?:a|one|the|each|every|per|single|new|first|second|last|next|another|this|that|its|of) looks?(?!-)"
           r"|(?:many|few|several|two|three|four|five|ten|\d+|these|those|all|more|whose|without|by) looks",
           "measurement, observation; frame, if it is a picture", {
        r"(?:take|have|worth|takes|has) a (?:close |closer |second )?look at": "plain English: a person looks",
        r"(?:each|every|one|this|that|the \w+) looks (?:like|as|at|for|up|into|the same|right|wrong|down)": "a verb"}),
    Banned(r"takes? (?:a|\w+) looks? .{0,20}in\b", "update with a measurement"),
    Banned(r"(?:dis)?honest(?:ly|y)?", "consistent (a filter); correct, legitimate (a person's work)"),
    Banned(r"lean(?:s|t|ed|ing)?", "body tilt; tilts, tilted", {
        r"lean(?:s|ed|ing)? (?:against|back)": "a person or a ladder"}),
    Banned(r"told", "commanded (a motion), given (a value), reported; for two things: distinguished"),
    Banned(r"tells?", "shows, gives, says, reports, means; for two things: distinguish", {
        rf"tells? (?:\w+ly )?{PERSON}": "a person is told something", r"tells? [^.;:]{1,60} apart": "an idiom",
        r"tell : callable": "a parameter's name"}),
    Banned(r"believe[sd]?|believing", "estimate(s), estimated; belief is the field's noun"),
    Banned(r"straight lines? (?:about|at the estimate)|by a straight line", "linearisation at"),
    Banned(r"com(?:e|es|ing) from (?:nothing|nowhere)", "initialisation without a prior"),
    Banned(r"gone|goes before|go before|going before", "removed, discarded, missing"),
    Banned(r"frame's parent", "the map frame"),
    Banned(r"the sum of (?:the |all |its |your )?points", "the total score"),
    Banned(r"(?:somebody|someone|nobody)'s page|my NAO's page", "feedback page"),
    Banned(r"somebody(?:'s)?", "someone, a student, a person: say who"),
    Banned(r"(?:experiment's|the) ways of (?:an|the) experiment|experiment's ways", "variants, configurations"),
    Banned(r"wrong in (?:two|both|several) places", "has two errors"),
    Banned(r"pieces? of (?:\w+ )?lines?", "line segments"),
    Banned(r"what(?:ever)? (?:is|was) left", "the remainder, the residual"),
    Banned(r"lent|lends?|lending", "the reference implementation is used in its place"),
    Banned(r"second chances?", "retry"),
    Banned(r"hoards?|deaf|nursery|nurseries", "buffer, non-interruptible: say what it is"),
    Banned(r"bells?", "watchdog, alarm", {r"bell(?: |-)(?:curve|shaped)": "the shape of a Gaussian"}),
    Banned(r"middles|middle of (?:a|the|its|this|that|each) (?:\w+ )?(?:circle|arc|line|segment)s?",
           "centre, midpoint"),
    Banned(r"(?:the|of|remov\w+|without|many|no|before|as|are) doubles", "duplicates"),
    Banned(r"(?:takes?|taking) in", "update with, include, use"),
    # Constructions of rules 4 and 5
    Banned(r"ones? (?:that|which|who|whose|of which)", "repeat the noun: 'a function that'"),
    Banned(r"that of", "repeat the noun: 'the time of the slowest call'", {r"note that of": "a conjunction"}),
    Banned(r"those (?:of|whose|that|which)", "repeat the noun: 'the cases whose'"),
    Banned(r"(?:is|are|was|were|be) (?-i:none)", "is not a NOUN", {
        r"there (?:is|are|was|were|may be) (?-i:none)": "plain English"}),
    Banned(r"(?:is|are|was|were) no", "is not a NOUN", {
        r"(?:there|it) (?:is|are|was|were) no|there (?:is|are) \w+ and (?:is|are) no": "there is no NOUN",
        r"(?:is|are|was|were) no (?:longer|more|less|different|better|worse|larger|smaller|faster|slower)":
            "a comparison",
        r"(?:is|are|was|were) no (?:reason|need|coincidence|accident|wonder)": "an idiom"}),
    Banned(r"what is [^.?!]{1,40} and (?:is |has )?(?:no|not|none)",
           "name the things: 'white pixels outside the lines'"),
    Banned(r"what of|of what (?:is|was|are|it)", "name the thing"),
    Banned(r"(?:has|have|is|does|do) not, and (?:is|has|does|are|do)", "a riddle: say both facts"),
    Banned(r"(?:came|comes?) of", "result, follow: 'the outcome of'"),
    Banned(r"but for", "except"),
    Banned(r"(?:is|are) wanted", "FUNCTION should return ..."),
    Banned(r"one raises|raises one", "name what raises"),
    Banned(r"(?:sees|hears|knows|says|does|gives|has) (?:it|them|this) never", "never before the verb"),
    Banned(r"(?:of|from|to|with) (?-i:none)", "say it with 'not' or 'no NOUN'"),
)  # fmt: skip

_NAMES = """
slope slopes: derivative, gradient, jacobian
doubt doubts unsure surely: sigma, covariance, uncertainty
surprise surprises surprising: innovation, residual
sight sights look looks: measurement, observation, frame; appearance, style
honest honesty: consistent, consistency
lean leans leaning: tilt, tilted
told: commanded, given, reported
believed believes believe: estimate, estimated
lent lend lends lending: reference, stand_in
hoard bell deaf nursery: buffer, watchdog
middle middles: centre, midpoint
doubles: duplicates
somebody somebodys: someone; feedback
chances: retries
gone: removed, discarded
ways: variants, configurations
"""
NAMES = {
    word: say
    for line in _NAMES.strip().split("\n")
    for words, _, say in [line.partition(": ")]
    for word in words.split()
}
WHOLE_NAMES = {
    "about": "linearised_at",
    "apart": "decorrelated",
    "Rows": "LinearisedMeasurement",
    "WholePicture": "JointUpdate",
    "whole_picture": "joint_update",
    "Sight": "Frame",
    "DriveNoise": "OdometryNoise",
    "FieldOdometry": "OdometryNoise",
}
ALLOWED_NAMES = {
    **dict.fromkeys(
        ("look", "look_at", "look_around", "look_ahead", "look_down"), "a verb: the head turns there"
    ),
    "remove_doubles": "exercise 3.5: students' notebooks of all releases define it",
}

_VERBS = """
Accept Add Adjust Advance Align Allow Answer Append Apply Approximate Arrange Ask Assert Assign Associate
Attach Average Avoid Begin Bind Blur Bootstrap Bring Build Calculate Calibrate Call Cancel Carry Change
Check Choose Classify Clean Clear Click Clip Close Cluster Collect Colour Combine Compare Compile
Complete Compose Compress Compute Confine Connect Continue Convert Copy Correct Count Cover Create Crop
Cut Darken Decide Declare Decode Decorrelate Defer Define Delete Deliver Deny Derive Describe Detect
Determine Differentiate Disable Discard Display Distinguish Divide Do Download Draw Drive Drop Eliminate
Empty Enable Encode End Ensure Enter Enumerate Erase Escape Estimate Evaluate Execute Exit Explain
Explore Export Express Extend Extract Factorise Fail Fetch Fill Filter Find Finish Fit Flatten Follow
Force Forget Fork Format Forward Freeze Gather Generate Get Give Go Grade Group Guess Handle Hash Hide
Highlight Hold Identify Ignore Implement Import Include Increase Indent Index Infer Initialise Insert
Inspect Install Integrate Interpolate Interrupt Intersect Invert Iterate Join Judge Keep Kill Label
Launch Lay Leave Let Limit Linearise Link List Listen Load Localise Locate Lock Log Look Lower Make Map
Marginalise Mark Mask Match Maximise Measure Merge Minimise Mix Modify Mount Move Multiply Name Normalise
Note Notify Number Open Optimise Order Overlay Pack Paint Pair Parse Pass Paste Patch Pause Perturb
Photograph Pick Plan Plot Point Pool Post Predict Prepare Prevent Print Process Produce Project Propagate
Propose Protect Prove Provide Publish Put Quote Raise Reach Read Rebuild Receive Recognise Recommend
Recompute Record Redirect Reduce Refresh Refuse Register Reject Relabel Release Remember Remove Rename
Render Reorder Repeat Replace Replay Reply Report Represent Request Require Resample Reset Resolve
Restore Restrict Retry Return Reuse Revert Rewrite Rotate Round Run Sample Save Say Scale Scan Schedule
Score Search Seed Select Send Separate Serialise Serve Set Settle Shift Shorten Show Shrink Shuffle Shut
Sign Signal Silence Simplify Simulate Skip Smooth Snap Solve Sort Split Square Stack Start State Step
Stop Store Strip Submit Substitute Subtract Suggest Suppress Switch Symmetrise Synchronise Take Test
Throw Tie Tilt Time Toggle Trace Track Train Transform Translate Transpose Triangulate Trim Truncate Try
Turn Undo Unlock Unpack Unwrap Update Use Validate Verify Visit Wait Walk Warn Warp Watch Weigh Weight
Whiten Wrap Write Yield Zip Zoom
"""
VERBS = frozenset(_VERBS.split())

_CODE = re.compile(r"``[^`]+``|`[^`\n]+`|https?://\S+|\]\([^)\s]*\)")
_MATHS = re.compile(r"\$\$.*?\$\$|\$[^$\n]+\$", re.DOTALL)
_TAG = re.compile(r"<(?!img)[a-zA-Z/!][^>]*>")
_FENCE = re.compile(r"^(`{3,}|~{3,})[^\n]*\n(.*?)^\1\s*$", re.DOTALL | re.MULTILINE)
_FRONT = re.compile(r"\A---\n.*?\n---\n", re.DOTALL)
_OPTION = re.compile(r"^(?::[\w-]+:.*|\+\+\+.*|%.*)$", re.MULTILINE)
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")


class Offence(NamedTuple):
    """A place in a file that a rule objects to."""

    line: int
    text: str
    say: str


class _Piece(NamedTuple):
    """A piece of prose, and the line that it begins in."""

    line: int
    text: str


def _compiled(pattern: str, end: str = r"\b") -> re.Pattern[str]:
    return re.compile(r"\b(?:" + pattern.replace(" ", r"\s+") + ")" + end, re.IGNORECASE)


_RULES = [
    (each, _compiled(each.pattern), [_compiled(context, "") for context in each.allowed]) for each in PROSE
]
# One pass over a text says whether any rule can match in it at all.
_ANY = re.compile("|".join(f"(?:{rule.pattern})" for _, rule, _ in _RULES), re.IGNORECASE)


def files() -> list[str]:
    """Return the files that are judged, as paths in the project."""
    paths = [
        *(PROJECT / "nao_course").rglob("*.py"),
        *(PROJECT / "solutions").glob("*.md"),
        *(PROJECT / "solutions" / "exercises").glob("*.py"),
        *(PROJECT / "docs").glob("*.md"),
        PROJECT / "README.md",
    ]
    return sorted(path.relative_to(PROJECT).as_posix() for path in paths)


def offences(file: str | Path) -> list[Offence]:
    """Return a file's offences, in the order of its lines."""
    path = PROJECT / file
    text = path.read_text(encoding="utf-8")
    return in_python(text) if path.suffix == ".py" else in_markdown(text)


def in_python(source: str, first: int = 1) -> list[Offence]:
    """Return the offences in Python code whose first line has the number `first`."""
    try:
        tree = ast.parse(source)
    except SyntaxError:  # a cell with a magic
        return []
    nodes = list(ast.walk(tree))
    found = [each for piece in _python_prose(source, nodes) for each in in_prose(*piece)]
    found += [*_names(tree), *_first_lines(nodes)]
    return sorted({each._replace(line=each.line + first - 1) for each in found})


def in_markdown(text: str) -> list[Offence]:
    """Return the offences in a lesson's text or a page of the docs; its cells of code are judged as Python."""
    found: list[Offence] = []
    for match in _FENCE.finditer(text):
        if re.match(r"[`~]+(?:\{code-cell\}|python|py)\b|[`~]+\{code-cell\}", match[0]):
            code = _OPTION.sub("", match[2])
            found += in_python(code, text.count("\n", 0, match.start(2)) + 1)
    for pattern in (_FRONT, _FENCE, _OPTION):
        text = pattern.sub(_blank, text)
    return sorted({*found, *in_prose(1, text)})


def in_prose(line: int, text: str) -> list[Offence]:
    """Return the offences in a piece of prose that begins in a line."""
    for pattern in (_CODE, _MATHS, _TAG):
        text = pattern.sub(_blank, text)
    if not _ANY.search(text):
        return []
    found = []
    for banned, rule, allowed in _RULES:
        for match in rule.finditer(text):
            if not any(_covers(context, text, match) for context in allowed):
                said = " ".join(match[0].split())
                found.append(Offence(line + text.count("\n", 0, match.start()), said, banned.say))
    return found


def _covers(context: re.Pattern[str], text: str, match: re.Match[str]) -> bool:
    near = context.finditer(text, max(0, match.start() - 80), match.end() + 120)
    return any(each.start() <= match.start() and match.end() <= each.end() for each in near)


def _blank(match: re.Match[str]) -> str:
    """Replace what is not prose by what no rule matches, and keep its lines."""
    return re.sub(r"[^\n]", "·", match[0])


def _python_prose(source: str, nodes: Sequence[ast.AST]) -> Iterator[_Piece]:
    """Comments, docstrings and texts in code; a text of one lower-case word is a key."""
    yield from _comments(source)
    inside = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    for node in nodes:
        if isinstance(node, ast.JoinedStr):
            parts = [part.value if isinstance(part, ast.Constant) else "·" for part in node.values]
            yield _Piece(node.lineno, "".join(map(str, parts)))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in inside:
            yield from [_Piece(node.lineno, node.value)] if _is_sentence(node.value) else []


def _is_sentence(text: str) -> bool:
    return " " in text or text[:1].isupper()


def _comments(source: str) -> Iterator[_Piece]:
    """Comments; those on consecutive lines are one piece."""
    block: list[tuple[int, str]] = []
    if "#" in source:
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            if token.type != tokenize.COMMENT:
                continue
            if block and token.start[0] != block[-1][0] + 1:
                yield _Piece(block[0][0], "\n".join(text for _, text in block))
                block = []
            block.append((token.start[0], token.string.lstrip("#: ")))
    if block:
        yield _Piece(block[0][0], "\n".join(text for _, text in block))


def _names(tree: ast.Module) -> Iterator[Offence]:
    """Public names of modules, classes, functions and arguments that use a banned word."""
    for name, line in _public_names(tree):
        if name in ALLOWED_NAMES:
            continue
        words = {word.lower() for word in _WORD.findall(name)}
        say = WHOLE_NAMES.get(name) or next((NAMES[word] for word in sorted(words & NAMES.keys())), "")
        if say:
            yield Offence(line, f"the name {name}", say)


def _public_names(node: ast.AST) -> Iterator[tuple[str, int]]:
    for each in ast.iter_child_nodes(node):
        if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            if each.name.startswith("_") and each.name != "__init__":
                continue
            yield each.name, each.lineno
            if isinstance(each, ast.ClassDef):
                yield from _public_names(each)
            else:
                arguments = each.args
                for one in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs):
                    yield one.arg, one.lineno
        elif isinstance(each, ast.Assign | ast.AnnAssign):
            targets = each.targets if isinstance(each, ast.Assign) else [each.target]
            for target in targets:
                for name in ast.walk(target):
                    if isinstance(name, ast.Name) and not name.id.startswith("_"):
                        yield name.id, name.lineno


def _first_lines(nodes: Sequence[ast.AST]) -> Iterator[Offence]:
    """Docstrings of functions and methods, properties aside, that do not begin with a verb."""
    for node in nodes:
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        text = ast.get_docstring(node)
        kinds = {ast.unparse(each).split(".")[-1] for each in node.decorator_list}
        if text and not kinds & {"property", "cached_property", "setter"} and not begins_with_a_verb(text):
            said = " ".join(text.split()[:6])
            yield Offence(
                node.body[0].lineno, f"docstring {said!r}", "begin with an imperative verb: 'Return the ...'"
            )


def begins_with_a_verb(docstring: str) -> bool:
    """Return whether a docstring's first word is an imperative, such as in "Count the lines."."""
    first, second, *_ = [*docstring.split(), "", ""]
    return first.rstrip(",.:;") in VERBS and second not in ("of", "is", "are")


def main(paths: Iterable[str]) -> int:
    """List the offences of some files; return 1 if there are any."""
    found = [(path, each) for path in paths for each in offences(Path(path).resolve())]
    for path, each in found:
        print(f"{path}:{each.line}: {each.text} -> {each.say}")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
