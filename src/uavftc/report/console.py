"""The console that everything is printed on: rich's, but what a terminal would obey does not pass as text."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

_OBEYED = {code: "?" for code in (*range(0x20), *range(0x7F, 0xA0)) if chr(code) not in "\n\t"}
"""Control characters, one for one, so that widths stay as they are; error messages spell them out."""


class Terminal(Console):
    """A console on standard output, or standard error; colours are rich's own, where there is somebody to see them."""

    def __init__(self, *, stderr: bool = False, **options: Any) -> None:
        super().__init__(stderr=stderr, highlight=False, **options)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Render as rich does, with a question mark for each control character in what is shown."""
        for segment in super().render(renderable, options):
            text = segment.text if segment.control else segment.text.translate(_OBEYED)
            yield segment if text == segment.text else Segment(text, segment.style)

    def on_broken_pipe(self) -> None:
        """Say no more: whoever read this has seen enough, and what was flown is on disk."""
        self.quiet = True
