"""For mkdocs: pages that lie outside of docs/, and links that lead there, so that README and site are one text.

README.md is the site's first page, CONTRIBUTING.md and CHANGELOG.rst are pages, and files that pages link to, such as
those of config/, are copied beside them.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.rst": "changes.md"}
_LINK = re.compile(r"(\]\()([^)#\s]+)(#[^)]*)?(\))")


def on_files(files: Files, config: Any) -> Files:
    """Adds the pages, and each file of the repository that any page links to."""
    for name, page in PAGES.items():
        text = (ROOT / name).read_text(encoding="utf-8")
        files.append(
            File.generated(config, page, content=relinked(_markdown(text) if name.endswith(".rst") else text, ROOT))
        )
    texts = [(ROOT / name).read_text(encoding="utf-8") for name in PAGES]
    wanted = {path for text in texts for path in _outside(text, ROOT)}
    for page in (ROOT / "docs").glob("*.md"):
        wanted |= _outside(page.read_text(encoding="utf-8"), ROOT / "docs")
    for path in sorted(wanted):
        name = path.relative_to(ROOT).as_posix()
        files.append(File.generated(config, name, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Links of docs/ that lead out of it."""
    return markdown if page.file.src_uri in PAGES.values() else relinked(markdown, ROOT / "docs")


def relinked(text: str, folder: Path) -> str:
    """The text with the links as they are on the site. :param folder: where the text lies."""

    def moved(found: re.Match[str]) -> str:
        opening, target, anchor, closing = found.groups()
        path = (folder / target).resolve()
        if "://" in target or not path.is_relative_to(ROOT):
            return found[0]
        name = path.relative_to(ROOT).as_posix()
        return f"{opening}{PAGES.get(name, name.removeprefix('docs/'))}{anchor or ''}{closing}"

    return _LINK.sub(moved, text)


def _outside(text: str, folder: Path) -> set[Path]:
    """Files that are linked, lie in the repository, and are neither pages nor in docs/."""
    paths = {(folder / target).resolve() for _, target, _, _ in _LINK.findall(text) if "://" not in target}
    own = {ROOT / name for name in PAGES}
    return {p for p in paths - own if p.is_file() and p.is_relative_to(ROOT) and not p.is_relative_to(ROOT / "docs")}


def _markdown(text: str) -> str:
    """The changelog's reStructuredText: headings underlined by =, - or ^, lists, ``code``."""
    levels = {"=": "#", "-": "##", "^": "###", "~": "####"}
    text = re.sub(r"^\^+\n(.+)\n\^+$", r"# \1", text, flags=re.M)
    text = re.sub(r"^(\S.*)\n([=\-^~])\2{2,}$", lambda m: f"{levels[m[2]]} {m[1]}", text, flags=re.M)
    return text.replace("``", "`")
