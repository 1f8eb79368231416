"""What the laws of a flight read and write, checked when it is built."""

from __future__ import annotations

from collections.abc import Sequence

from uavftc.core.signals import ROW
from uavftc.core.stage import Block, PythonBlock

PRESCRIBED = frozenset(["t", "x1_c", "effectiveness", "bias", "d1", "d2", "wind_n", "gust_rates"])
"""Fields that the scenario gives, filled in before a row is flown."""

DEFAULT = frozenset(["d1_hat", "status"])
"""Fields that are zero where no law writes them; zero means that nothing happens."""

CUSTOM = frozenset(["v2"])
"""What a step in plain Python, and a law that does not say what it writes, is assumed to write."""


def check_flow(blocks: Sequence[Block | PythonBlock]) -> None:
    """Check that each law reads only what was written before it in the row.

    Raises
    ------
    ValueError
        If one reads a field that nothing before it has written.
    """
    written = set(PRESCRIBED | DEFAULT)
    for block in blocks:
        stage = block.stage if isinstance(block, Block) else None
        if stage is None or stage.writes is None:
            written |= CUSTOM
        if stage is None:
            continue
        reads, writes = stage.reads or frozenset(), stage.writes or frozenset()
        # a law on each effector may add up what it writes into the row, and begins by itself
        summed = reads & writes & frozenset(ROW.names or ()) if stage.on_effector else frozenset()
        missing = reads - summed - written
        if missing:
            raise ValueError(f"{block.name} reads {', '.join(sorted(missing))}, which nothing before it has written")
        written |= writes
