"""How long the language server takes to answer on the flagship: medians of processor time, after the first check.

Requests are answered as the server does, without the transport; the bar is 100 ms.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

from saoflow.diagrams.store import SHIPPED
from saoflow.lsp import answers
from saoflow.lsp.completion import complete
from saoflow.lsp.workspace import Sheets

REPEAT = 15


def median_ms(answer: Callable[[int], object]) -> float:
    """The median of several answers [ms]."""
    taken = []
    for k in range(REPEAT):
        start = time.process_time()
        answer(k)
        taken.append(1000 * (time.process_time() - start))
    return statistics.median(taken)


def main() -> None:
    """Print the table."""
    path = (SHIPPED / "cmhe_fte" / "cmhe_fte.yaml").resolve()
    text = path.read_text(encoding="utf-8")
    sheets = Sheets()
    sheets.open(path, text)
    start = time.process_time()
    sheets.check(path)
    print(f"check, in the background     {1000 * (time.process_time() - start):8.1f} ms")
    readable = sheets.sheet(path)
    assert readable is not None
    wires = [p for p in readable.places if p.kind == "wire"]
    lines = text.splitlines()
    line = next(i for i, content in enumerate(lines) if "filtered.y" in content)

    def typed(k: int) -> None:
        """Hover right after a letter was typed: the sheet is read anew."""
        sheets.open(path, text + f"# {k}\n")
        answers.hover(sheets, path, wires[k])

    print(f"hover                        {median_ms(lambda k: answers.hover(sheets, path, wires[k])):8.1f} ms")
    print(f"hover after a change         {median_ms(typed):8.1f} ms")
    print(f"definition                   {median_ms(lambda k: answers.definition(sheets, path, wires[-k])):8.1f} ms")
    print(f"references in the folder     {median_ms(lambda k: answers.references(sheets, path, wires[k])):8.1f} ms")
    print(f"completion                   {median_ms(lambda k: complete(sheets, path, lines, line, 20)):8.1f} ms")


if __name__ == "__main__":
    main()
