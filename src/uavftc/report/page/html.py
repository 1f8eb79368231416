"""A page put together: template, style, scripts and data in one file, with nothing that is loaded from elsewhere."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from importlib import metadata, util
from importlib.resources import files
from typing import Any

from uavftc.errors import InputError

_NEEDS = ("plotly", "jinja2")
_SCRIPTS = ("base.js", "theme.js", "plots.js", "time.js", "view.js", "points.js", "start.js")
MAX_BYTES = 6_000_000
"""Of a page."""
_AROUND = 120_000  # bytes of style, scripts, tables and texts of a page


def require_extra(what: str) -> None:
    """Make sure that what a page is made with is installed.

    Parameters
    ----------
    what
        What asks for it, such as `--report`.

    Raises
    ------
    InputError
        If the extra is missing.
    """
    missing = [name for name in _NEEDS if util.find_spec(name) is None]
    if missing:
        raise InputError(
            what,
            found=f"no package {' and no package '.join(missing)}",
            expected="the extra 'report', which report.html is made with",
            remedy="install it: pip install 'uavftc[report]'",
        )


@functools.cache
def plotly_js() -> str:
    """Return plotly.js, minified, as the Python package carries it."""
    text = (files("plotly") / "package_data" / "plotly.min.js").read_text(encoding="utf-8")
    return text.replace("</script", "<\\/script")


def budget_bytes() -> float:
    """Return how many bytes the curves of a page may take, so that it stays below `MAX_BYTES`."""
    return MAX_BYTES - _AROUND - len(plotly_js().encode())


def render(template: str, data: Mapping[str, Any], **parts: Any) -> str:
    """Return a page as HTML; every text of the user's in it is escaped.

    Parameters
    ----------
    template
        Name of a file among the templates.
    data
        What the scripts draw: a JSON document.
    parts
        What the template writes.
    """
    import jinja2  # noqa: PLC0415 - of the extra

    loader = jinja2.FunctionLoader(lambda name: _asset("templates", name))
    environment = jinja2.Environment(
        loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}
    return environment.get_template(template).render(
        data=data,
        plotly=plotly_js(),
        style=_asset("assets", "style.css"),
        scripts=[_asset("assets", name) for name in _SCRIPTS],
        version=metadata.version("uavftc"),
        **parts,
    )


def _asset(folder: str, name: str) -> str:
    return (files("uavftc.report.page") / folder / name).read_text(encoding="utf-8")


def listed(names: Sequence[str]) -> list[str]:
    """Return the files of a result folder that a page links to, those to be looked at first."""
    first = [name for name in names if name.endswith(".png")]
    return [*sorted(set(names) - set(first)), *sorted(first)]
