"""What `uavftc reproduce` says on the terminal: scores, answers to the claims, and where the page is."""

from __future__ import annotations

from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from uavftc.jobs.paper.page import claims_summary
from uavftc.jobs.paper.reproduction import Reproduction
from uavftc.jobs.paper.tables import scored


def print_reproduction(console: Console, result: Reproduction, folder: Path) -> None:
    """Print the closing block of a reproduction."""
    title = Text(f"rms of ln(ours / printed), {scored()} integral metrics of NNDONDI-L1", style="bold")
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("plant")
    table.add_column("units")
    for name in ("all", "Table 2", "Table 3", "Table 5"):
        table.add_column(name, justify="right")
    for plant, kinds in result.scores.items():
        for kind, values in kinds.items():
            cells = [f"{values[k]:.3f}" for k in ("all", "table 2", "table 3", "table 5")]
            table.add_row(Text(plant), Text(kind), *map(Text, cells))
    console.print(table)
    for plant, claims in result.claims.items():
        console.print(Text(f"Tables 4 and 6 on {plant}, {len(claims)} claims: {claims_summary(claims)}"))
    for finding in result.findings:
        if finding.plant == result.plants[-1]:
            console.print(Text.assemble(("finding: ", "cyan"), finding.title))
    console.print(Text(f"results: {folder / 'reproduction.md'}"), soft_wrap=True)
