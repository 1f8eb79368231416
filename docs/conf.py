"""The documentation site: `sphinx-build -W --keep-going docs build/site` (extra `docs`).

The pages are Markdown that is read on a code host as well. So links lead to files next to the page, and this file makes
those that leave `docs/` work on the site: see `outside`.
"""

from __future__ import annotations

import re
import tomllib
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import ziamath
from docutils.nodes import SkipNode

if TYPE_CHECKING:
    from docutils import nodes
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

DOCS = Path(__file__).parent
ROOT = DOCS.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = "uavftc"
author = copyright = "The uavftc developers"
version = release = PROJECT["version"]

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_static"]
nitpicky = False

# Pages
myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
nb_execution_mode = "off"  # tests/docs/test_notebook.py runs the notebook and compares what it prints
suppress_warnings = ["mystnb.unknown_mime_type"]

# API
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_numpy_docstring = True
napoleon_use_ivar = True
default_role = "code"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88

ziamath.config.svg2 = False  # each picture has its own letters

# Look
html_theme = "furo"
html_title = f"uavftc {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_math_renderer = "drawn"
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
pygments_style = "friendly"
pygments_dark_style = "monokai"

LINK = re.compile(r"(?<!!)\[([^\]\n]+)\]\((?!https?://|#)([^)#\s]+)(#[^)\s]*)?\)")


def outside(page: Path, text: str) -> str:
    """Return a page with its links out of `docs/` as the site can have them.

    With a repository in pyproject.toml (`project.urls.Repository`) they lead there. Without one a file is carried
    along, to be downloaded (MyST does that), and the name of a folder is left without a link.
    """
    repository = PROJECT.get("urls", {}).get("Repository")

    def link(found: re.Match[str]) -> str:
        name, target = found[1], (page.parent / found[2]).resolve()
        if target.is_relative_to(DOCS) and not target.is_dir():
            return found[0]
        if repository and target.is_relative_to(ROOT):
            kind = "tree" if target.is_dir() else "blob"
            return f"[{name}]({repository}/{kind}/main/{target.relative_to(ROOT).as_posix()}{found[3] or ''})"
        return name if target.is_dir() else found[0]

    return LINK.sub(link, text)


def read(app: Sphinx, name: str, source: list[str]) -> None:
    """Change the text of a page as it is read."""
    page = Path(app.env.doc2path(name))
    if page.suffix == ".md":
        source[0] = outside(page, source[0])


def drawn(tex: str, size: float, inline: bool) -> str:
    """Return an equation as a picture of its letters, the same in every browser: no script, no network, no font."""
    latex = ziamath.Latex(tex.strip(), size=size, color="currentColor", inline=inline)
    picture = f'<svg role="img" aria-label="{escape(tex.strip(), quote=True)}" '
    if inline:
        picture += f'style="vertical-align: {latex.getyofst():.2f}px" '
    return picture + latex.svg().removeprefix("<svg ")


def inline_math(self: HTML5Translator, node: nodes.math) -> None:
    """Write an equation in a line."""
    self.body.append(f'<span class="math">{drawn(node.astext(), 17, inline=True)}</span>')
    raise SkipNode


def block_math(self: HTML5Translator, node: nodes.math_block) -> None:
    """Write a displayed equation."""
    self.body.append(f'<div class="math">{drawn(node.astext(), 18, inline=False)}</div>')
    raise SkipNode


def setup(app: Sphinx) -> None:
    """Connect what this file adds to Sphinx."""
    app.connect("source-read", read)
    app.add_html_math_renderer("drawn", (inline_math, None), (block_math, None))
