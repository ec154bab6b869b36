"""Pages as one HTML file: escaped by construction, no script, no address, light and dark, from 360 pixels on."""

import base64
import hashlib
import os
import re
import secrets
from html import escape
from pathlib import Path

_UNSEEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\ufffe\uffff"
    "\ud800-\udfff\U000e0000-\U000e0fff]"
)
_STACKED = re.compile(
    r"([\u0300-\u036f\u0483-\u0489\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff\ufe20-\ufe2f]{4})(?:[\u0300-\u036f\u0483-\u0489\u1ab0-\u1aff\u1dc0-\u1dff\u20d0-\u20ff\ufe20-\ufe2f]+)"
)
_CODE = re.compile(r"`([^`\n]+)`")
_EMPHASIS = re.compile(r"(?<![\w*])\*(?=[^\s*])([^*\n]*[^\s*])\*(?![\w*])")
_VOID = {"meta", "img"}

STYLE = """
:root { color-scheme: light dark; --paper: #fbfaf7; --card: #ffffff; --ink: #1d2327; --soft: #565f66;
  --line: #dcdfe0; --good: #116329; --good-paper: #e4f4e6; --warn: #7d4800; --warn-paper: #fff1d6;
  --bad: #9c1c28; --bad-paper: #fde9e9; --calm: #1f4f8f; --calm-paper: #e7effa; --code: #f1f2f0; --track: #d5d9da; }
@media (prefers-color-scheme: dark) { :root { --paper: #14181b; --card: #1d2327; --ink: #e6e9ea; --soft: #a7b0b5;
  --line: #39424a; --good: #7fd693; --good-paper: #17301d; --warn: #f0bd6b; --warn-paper: #372811;
  --bad: #ff9d9d; --bad-paper: #3b1c1f; --calm: #9dc4f8; --calm-paper: #1a2a40; --code: #11161a; --track: #3d4750; } }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0; background: var(--paper); color: var(--ink); overflow-wrap: anywhere;
  font: 1rem/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
main { max-width: 46rem; margin: 0 auto; padding: 1.25rem 1rem 3rem; }
main.wide { max-width: 64rem; }
h1 { font-size: 1.5rem; line-height: 1.25; margin: 0.2rem 0 0; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 0.7rem; }
h3 { font-size: 1.05rem; margin: 0; }
p, ul, ol, dl { margin: 0.6rem 0 0; }
ul, ol { padding-left: 1.3rem; }
li + li { margin-top: 0.25rem; }
pre, code { font-family: ui-monospace, SFMono-Regular, Menlo, Consolas, "Liberation Mono", monospace; }
code { font-size: 0.94em; }
p code, li code { background: var(--code); border-radius: 0.25rem; padding: 0.05rem 0.25rem; }
pre { font-size: 0.88rem; background: var(--code); border: 1px solid var(--line); border-radius: 0.4rem;
  padding: 0.55rem 0.7rem; margin: 0.6rem 0 0; white-space: pre-wrap; }
a { color: var(--calm); }
svg, img { display: block; max-width: 100%; }
.soft { color: var(--soft); }
.small { font-size: 0.9rem; }
.score { font-size: 2rem; font-weight: 700; line-height: 1.2; margin-top: 0.9rem; }
.score span { font-size: 1.1rem; font-weight: 400; color: var(--soft); }
.bar { width: 100%; height: 0.7rem; margin-top: 0.6rem; border-radius: 0.35rem; }
.bar .track { fill: var(--track); } .bar .got { fill: var(--good); } .bar .open { fill: var(--calm); }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 0.6rem; padding: 0.9rem 1rem;
  margin: 0.8rem 0 0; }
.top { display: flex; flex-wrap: wrap; gap: 0.15rem 0.8rem; align-items: baseline; justify-content: space-between; }
.points { font-variant-numeric: tabular-nums; white-space: nowrap; color: var(--soft); }
.state { font-weight: 600; margin-top: 0.35rem; }
.good { color: var(--good); } .warn { color: var(--warn); } .bad { color: var(--bad); } .calm { color: var(--calm); }
.label { font-size: 0.9rem; font-weight: 600; margin: 0.9rem 0 0; }
.label + * { margin-top: 0.25rem; }
.box { border-left: 4px solid; border-radius: 0.3rem; padding: 0.5rem 0.8rem; margin: 0.8rem 0 0; }
.box > :first-child { margin-top: 0; }
.box h2 { font-size: 1rem; }
.box.good { background: var(--good-paper); border-color: var(--good); }
.box.warn { background: var(--warn-paper); border-color: var(--warn); }
.box.bad { background: var(--bad-paper); border-color: var(--bad); }
.box.calm { background: var(--calm-paper); border-color: var(--calm); }
.box p, .box li { color: var(--ink); }
.right { list-style: none; padding: 0; }
.right li { display: flex; flex-wrap: wrap; gap: 0 0.8rem; justify-content: space-between; padding: 0.45rem 0;
  border-top: 1px solid var(--line); margin: 0; }
.right li:first-child { border-top: 0; }
.right p { flex-basis: 100%; margin: 0.1rem 0 0 1.4rem; }
.kept { white-space: pre-wrap; }
.sides { display: grid; grid-template-columns: repeat(auto-fit, minmax(20rem, 1fr)); gap: 0 1rem; }
mark { background: var(--warn-paper); color: inherit; box-shadow: inset 0 -2px var(--warn); }
.said { white-space: pre-wrap; border-left: 3px solid var(--line); padding-left: 0.8rem; margin: 0.4rem 0 0; }
table { border-collapse: collapse; width: 100%; margin-top: 0.6rem; font-size: 0.95rem; }
th, td { text-align: left; padding: 0.35rem 0.6rem 0.35rem 0; border-bottom: 1px solid var(--line);
  vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
th[scope="row"] { min-width: 7rem; }
th:not([scope="row"]) { overflow-wrap: normal; }
.scroll { overflow-x: auto; }
.scroll th, .scroll td { white-space: nowrap; padding-right: 1rem; }
main > h3 { margin-top: 1.6rem; }
.card > table { margin-top: 0; }
tr:last-child > * { border-bottom: 0; }
figure { margin: 0.8rem 0 0; }
figure img { background: #ffffff; border-radius: 0.4rem; width: 100%; min-width: 34rem; max-width: none; }
figcaption { font-size: 0.9rem; color: var(--soft); margin-top: 0.4rem; }
footer { margin-top: 2.5rem; padding-top: 0.8rem; border-top: 1px solid var(--line); font-size: 0.85rem;
  color: var(--soft); }
@media print { body { background: #ffffff; } .card { break-inside: avoid; } }
"""
_STYLE_HASH = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
_POLICY = f"default-src 'none'; style-src 'sha256-{_STYLE_HASH}'; img-src data:; base-uri 'none'; form-action 'none'"


class Markup(str):
    """HTML that `element` made; any other text is escaped where it is put into a page."""

    __slots__ = ()


Content = str | None  # None is left out


def visible(text: str) -> str:
    r"""Replace invisible characters by their code points: control characters, bidirectional overrides, lone surrogates.

    >>> visible("a\u202eb")
    'a⟨U+202E⟩b'
    """
    if text.isascii() and text.isprintable():
        return text
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    text = _UNSEEN.sub(lambda found: f"⟨U+{ord(found.group()):04X}⟩", text)
    return _STACKED.sub(r"\1", text)


def element(tag: str, *content: Content, **attributes: str) -> Markup:
    """Make an element; content that is not Markup is escaped.

    A trailing underscore of an attribute is dropped ("class_"), others become hyphens.
    """
    words = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{escape(visible(value))}"'
        for name, value in attributes.items()
    )
    if tag in _VOID:
        return Markup(f"<{tag}{words}>")
    return Markup(f"<{tag}{words}>{join(*content)}</{tag}>")


def join(*content: Content) -> Markup:
    """Join contents; content that is not Markup is escaped."""
    return Markup(
        "".join(
            each if isinstance(each, Markup) else escape(visible(each))
            for each in content
            if each is not None
        )
    )


def prose(text: str) -> Markup:
    """Return the text with parts in `backticks` set as code."""
    parts = _CODE.split(text)
    return join(*(element("code", part) if at % 2 else part for at, part in enumerate(parts)))


def markdown(text: str) -> Markup:
    """Return an author's text with parts in `backticks` set as code and parts in *asterisks* emphasised.

    >>> markdown("2 * 3 *or* `a*b*c`")
    '2 * 3 <em>or</em> <code>a*b*c</code>'
    """
    parts = _CODE.split(text)
    return join(*(element("code", part) if at % 2 else _emphasised(part) for at, part in enumerate(parts)))


def _emphasised(text: str) -> Markup:
    parts = _EMPHASIS.split(text)
    return join(*(element("em", part) if at % 2 else part for at, part in enumerate(parts)))


def card(*content: Content, class_: str = "card") -> Markup:
    """Return a card, a block with a border."""
    return element("div", *content, class_=class_)


def bar(got: float, waiting: float, whole: float) -> Markup:
    """Draw a score as a bar: what is there, what a person has still to mark, the rest. Its words stand beside it."""
    whole = max(whole, got + waiting, 1e-9)
    parts = [
        ("track", 0.0, 100.0),
        ("got", 0.0, 100 * got / whole),
        ("open", 100 * got / whole, 100 * waiting / whole),
    ]
    drawn = [
        element("rect", class_=name, x=f"{start:.2f}", width=f"{max(width, 0.0):.2f}", height="4")
        for name, start, width in parts
    ]
    return element(
        "svg", *drawn, class_="bar", viewBox="0 0 100 4", preserveAspectRatio="none", aria_hidden="true"
    )


def page(title: str, *content: Content, wide: bool = False) -> str:
    """Make a whole page. The title is the window's; a `wide` page may be wider than a text that is read."""
    head = (
        element("meta", charset="utf-8"),
        Markup(f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="color-scheme", content="light dark"),
        element("title", title),
        Markup(f"<style>{STYLE}</style>"),
    )
    body = element("main", *content, **({"class_": "wide"} if wide else {}))
    whole = element("html", element("head", *head), element("body", body), lang="en")
    return f"<!DOCTYPE html>\n{whole}\n"


def number(value: float) -> str:
    """Write points as short as they are: 2, 1.5, 0.33."""
    return f"{round(value, 2) + 0.0:.2f}".rstrip("0").rstrip(".")


def lesson_title(lesson: str) -> str:
    """Turn a lesson's name into words: "01_hsl_filtering" -> "Lesson 01: hsl filtering"."""
    head, _, rest = lesson.partition("_")
    words = rest.replace("_", " ")
    return f"Lesson {head}: {words}" if head.isdigit() and words else f"Lesson {lesson}"


def write_whole(path: Path, content: str | bytes) -> Path:
    """Write a file so that a reader finds the old one or the new one, never half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{secrets.token_hex(8)}.tmp")
    try:
        beside.write_bytes(content if isinstance(content, bytes) else content.encode())
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)
    return path
