"""Sphinx's settings: pages that need no other host, and run nothing."""

import re
import shutil
import sys
from importlib.resources import files
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

project = "nao_course"
language = "en"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
]

# Lessons: what stands in a notebook is shown, nothing is run, and no widget is asked for its scripts.
nb_execution_mode = "off"
nb_code_prompt_show = "Show the code"
nb_code_prompt_hide = "Hide the code"
nb_ipywidgets_js: dict[str, dict[str, str]] = {}
myst_enable_extensions = ["amsmath", "colon_fence", "dollarmath"]
myst_dmath_double_inline = True
myst_heading_anchors = 4

# Formulas: MathJax lies beside the pages, without its menu, the extensions of its TeX, and its Fraktur, script,
# sans-serif and typewriter letters, which no page uses.
mathjax_path = "mathjax/startup.js"
MATHJAX = ("core", "input/tex", "output/chtml", "a11y/assistive-mml")
mathjax3_config = {"loader": {"load": MATHJAX}, "options": {"enableMenu": False}}
FONTS = "output/chtml/fonts"
UNUSED = re.compile("Calligraphic|Fraktur|SansSerif|Script|Typewriter")

# Reference
default_role = "py:obj"
autodoc_member_order = "groupwise"
autodoc_typehints = "none"  # the docstrings say types, with shapes and units
autosummary_generate = False
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = "nao_course"
html_static_path = ["static", "../nao_course/films/web", "../nao_course/lab/custom"]
html_css_files = ["custom.css", "course.css", "map.css"]
html_js_files = ["map.js", "player.js", "course.js"]
html_use_index = False  # no page leads there: the search finds names
html_domain_indices = False
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_copyright = False
COLON = "\ue000"  # stands for a colon while napoleon reads


def hide_colon(
    app: Sphinx, what: str, name: str, described: object, options: object, lines: list[str]
) -> None:
    """Keep a property's "Middles of lines: (N, 4) ..." a sentence: napoleon would read a type before the colon."""
    if what == "property":
        lines[0] = lines[0].replace(": ", f"{COLON} ")


def show_colon(
    app: Sphinx, what: str, name: str, described: object, options: object, lines: list[str]
) -> None:
    """Bring back what `hide_colon` has hidden."""
    lines[:] = [line.replace(COLON, ":") for line in lines]


def as_written(app: Sphinx, document: nodes.document) -> None:
    """Leave each formula as JupyterLab shows it: Sphinx would wrap one of several lines so that it may have no tag."""
    for formula in document.findall(nodes.math_block):
        text = formula.astext()
        formula.children = [nodes.Text(rf"\[{text}\]")]
        formula["no-wrap"] = True


def copy_mathjax(app: Sphinx, problem: Exception | None) -> None:
    """Copy the part of MathJax that the pages load, 1 of the package's 24 MB, and remove files for debuggers."""
    if problem is None:
        source = Path(str(files("sphinx-mathjax-offline"))) / "static" / "mathjax"
        scripts = [source / f"{name}.js" for name in ("startup", *MATHJAX, f"{FONTS}/tex")]
        fonts = (source / FONTS / "woff-v2").glob("MathJax_*.woff")
        for path in (*scripts, *(path for path in fonts if not UNUSED.search(path.name))):
            target = Path(app.outdir) / "_static" / "mathjax" / path.relative_to(source)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, target)
        for path in Path(app.outdir).rglob("*.map"):
            path.unlink()


def setup(app: Sphinx) -> None:
    """Ask Sphinx to call what stands above."""
    app.connect("autodoc-process-docstring", hide_colon, priority=400)  # napoleon has 500
    app.connect("autodoc-process-docstring", show_colon, priority=600)
    app.connect("doctree-read", as_written)
    app.connect("build-finished", copy_mathjax)
