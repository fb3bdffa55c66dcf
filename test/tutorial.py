"""Follows docs/tutorial.md to the letter: saves its files, runs its commands.

python test/tutorial.py FOLDER [--pictures]     --pictures: puts what it made in place of docs/images
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "tutorial.md"
PICTURES = {  # docs/images/NAME -> what the commands make
    "forklift.png": "forklift.png",
    "forklift_simulated.png": "simulated/preview/0003.png",
    "forklift_found.png": "result/frames/000003_*.png",
}
_BLOCK = re.compile(r"(?:<!-- (.*?) -->\n)?```(\w*)\n(.*?)```", re.DOTALL)
_FILE = re.compile(r"file: ([^,]+)(?:, from (.+) on)?")


@dataclass(frozen=True)
class SaveFile:
    """A file to save; `after`: only its end, from the line that begins so, is replaced."""

    name: str
    text: str
    after: str | None

    def save(self, folder: Path) -> None:
        path = folder / self.name
        if self.after is None:
            path.write_text(self.text, encoding="utf-8")
            return
        kept = path.read_text(encoding="utf-8").partition(f"\n{self.after}")[0]
        path.write_text(f"{kept}\n{self.text}", encoding="utf-8")


@dataclass(frozen=True)
class Command:
    arguments: list[str]
    line: str = ""  # as it stands on the page


def steps(page: Path = PAGE) -> Iterator[SaveFile | Command]:
    """What the page asks for, in its order."""
    for note, language, text in _BLOCK.findall(page.read_text(encoding="utf-8")):
        if found := _FILE.fullmatch(note):
            yield SaveFile(found[1], text, found[2])
        elif language == "sh":
            yield from (Command(shlex.split(line), line) for line in text.splitlines() if line)


def alternatives(page: Path = PAGE) -> list[str]:
    """Blocks that are told beside the way that is followed."""
    blocks = _BLOCK.findall(page.read_text(encoding="utf-8"))
    return [text for note, _, text in blocks if note == "alternative"]


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True)
    for step in steps():
        if isinstance(step, SaveFile):
            step.save(folder)
            continue
        print("$", shlex.join(step.arguments), flush=True)
        subprocess.run(step.arguments, cwd=folder, check=True)
    for name, made in PICTURES.items() if "--pictures" in sys.argv else ():
        shutil.copy(next(folder.glob(made)), ROOT / "docs" / "images" / name)


if __name__ == "__main__":
    main()
