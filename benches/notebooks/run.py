"""Runs the notebooks of the documentation and compares what they print with their pages.

usage: run.py [--write]

A page is the notebook with its outputs, as Markdown with pictures. --write writes the pages.
"""

import html
import os
import re
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbconvert import MarkdownExporter

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "notebooks"


def page(path: Path) -> tuple[str, dict[str, bytes]]:
    """Runs a notebook; returns its page and its pictures."""
    book = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        # A busy machine sends what one cell prints in several messages.
        client = NotebookClient(
            book, timeout=600, coalesce_streams=True, resources={"metadata": {"path": folder}}
        )
        client.execute()
    for cell in book.cells:
        # Progress is not part of a page.
        cell["outputs"] = [output for output in cell.get("outputs", []) if output.get("name") != "stderr"]
        if cell["cell_type"] != "code":
            del cell["outputs"]
    texts = iter(alternative_texts(book))
    text, resources = MarkdownExporter().from_notebook_node(book)
    text = re.sub(r"!\[png\]", lambda _: f"![{next(texts)}]", text)
    pictures = {}
    for place, (name, data) in enumerate(sorted(resources["outputs"].items())):
        picture_name = f"{path.stem}-{place + 1}{Path(name).suffix}"
        text = text.replace(name, picture_name)
        pictures[picture_name] = data
    text = re.sub(r"[ \t]+$", "", text, flags=re.MULTILINE)
    text = re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"
    return text, pictures


def alternative_texts(book: nbformat.NotebookNode) -> list[str]:
    """Returns what all pictures show, and removes their HTML: pages have the pictures as files.

    The values in the text of a picture are left out.
    """
    texts = []
    for cell in book.cells:
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "image/png" in data:
                found = re.search(r'<img alt="([^"]*)"', data.pop("text/html", ""))
                texts.append(" ".join(html.unescape(found[1]).split()).split(": ")[0] if found else "png")
    return texts


def rounded(text: str) -> str:
    """Returns a page with six digits of each number: other processors and builds round the last ones otherwise."""
    return re.sub(r"-?\d+\.\d{6,}(e-?\d+)?", lambda match: f"{float(match.group()):.6g}", text)


def main() -> int:
    os.environ["SPRUNG_EXAMPLES"] = str(ROOT / "examples")
    write = "--write" in sys.argv[1:]
    differ = []
    for path in sorted(FOLDER.glob("*.ipynb")):
        text, pictures = page(path)
        page_path = path.with_suffix(".md")
        if write:
            page_path.write_text(text, encoding="utf-8")
            for name, data in pictures.items():
                (FOLDER / name).write_bytes(data)
        elif not page_path.exists() or rounded(page_path.read_text(encoding="utf-8")) != rounded(text):
            differ.append(page_path)
            Path(tempfile.gettempdir(), page_path.name).write_text(text, encoding="utf-8")
        print(f"{path.name}: {len(text.splitlines())} lines, {len(pictures)} pictures")
    for page_path in differ:
        print(f"{page_path} is not what its notebook prints: see {tempfile.gettempdir()}/{page_path.name}, or run "
              f"{Path(__file__).name} --write")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
