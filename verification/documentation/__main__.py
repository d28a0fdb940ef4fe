"""Makes the documentation site: ``python -m verification.documentation [-o out/documentation]``.

The pages are gathered in a folder (``docs/`` as it is, and those that are made), and zensical builds the site beside them
with ``mkdocs.yml``, strictly: a broken link ends it. Needs the extra ``saoflow[docs]``.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

from verification.documentation.reference import flagship_page, library_page, symbols_page

ROOT = Path(__file__).resolve().parents[2]


def gather(folder: Path) -> None:
    """Put every page of the site into a folder."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder)
    pictures = folder / "flagship"
    pictures.mkdir()
    made = {"symbols.md": symbols_page(), "library.md": library_page(), "flagship.md": flagship_page(pictures)}
    for name, text in made.items():
        (folder / name).write_text(text + "\n", encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    # The README's links are seen from the root: pages of docs/ lie beside it here, files of the repository stay text.
    readme = re.sub(r"\]\(docs/", "](", readme)
    (folder / "index.md").write_text(readme, encoding="utf-8")
    for page in folder.rglob("*.md"):
        page.write_text(_links(page.read_text(encoding="utf-8"), folder, page), encoding="utf-8")


def _links(text: str, folder: Path, page: Path) -> str:
    """Links to files of the repository that are no pages become text."""

    def link(match: re.Match[str]) -> str:
        target = match[2].partition("#")[0]
        if not target or "://" in target or (page.parent / target).exists():
            return match[0]
        return match[1] if (ROOT / "docs" / target).resolve().exists() or (ROOT / target).exists() else match[0]

    return re.sub(r"(?<!!)\[([^\]]+)\]\(([^)\s]+)\)", link, text)


def _present(config: str, sources: Path) -> str:
    """The configuration without pages that are not there."""

    def there(line: str) -> bool:
        page = re.match(r"\s+- .*?: (\S+\.md)$", line)
        return page is None or (sources / page[1]).exists()

    return "\n".join(line for line in config.split("\n") if there(line))


def main() -> int:
    """Gather and build."""
    parser = argparse.ArgumentParser(description="Make the documentation site.")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/documentation"), help="Folder to work in.")
    folder: Path = parser.parse_args().output.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    gather(folder / "docs")
    config = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    (folder / "mkdocs.yml").write_text(_present(config, folder / "docs"), encoding="utf-8")
    command = [sys.executable, "-m", "zensical", "build", "--strict", "--clean", "-f", str(folder / "mkdocs.yml")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        said = done.stdout + done.stderr.partition("Traceback")[0]
        print(re.sub(r"\x1b\[[\d;]*m", "", said), file=sys.stderr)
        return 1
    print(folder / "site" / "index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
