"""An example or two of each command, for its help."""

from __future__ import annotations

import argparse
import textwrap

EXAMPLES = {
    "train": (
        "artrec train --object lamp.yaml --annotations photos/annotations.json -o lamp_constraints.yaml",
        "artrec train --object lamp.yaml --from-joints -o lamp_constraints.yaml",
    ),
    "learn-colours": (
        "artrec learn-colours --annotations photos/regions.json --classes red=3 blue=2 -o colours.yaml",
        "artrec learn-colours recorded_bag --every 3 --classes red=3 blue=2 -o colours.yaml",
    ),
    "replay": (
        "artrec replay recorded_bag --params-file lamp_params.yaml -o result",
        "artrec replay images/ --params-file lamp_params.yaml --camera-info camera.yaml --images none -o result",
        "artrec replay bags/* --params-file lamp_params.yaml --jobs all --no-video --output-bag -o result",
        "artrec replay /shared/bags/* --params-file /shared/lamp_params.yaml --scheduler tcp://head:8786 -o result",
    ),
    "tune": (
        "artrec tune simulated/bag --truth simulated/truth.jsonl --params-file lamp_params.yaml --search space.yaml "
        "-o tuned",
        "artrec tune bag_a bag_b --truth a.jsonl --truth b.jsonl --params-file lamp_params.yaml --search space.yaml "
        "--objective right_rate --limit 'latency_ms_p95<=30' --block 30 -o tuned",
    ),
    "evaluate": (
        "artrec evaluate result --truth simulated/truth.jsonl",
        "artrec evaluate result --truth recorded_bag --truth-topic /mocap/red/poses --max-gap 0.005",
        "artrec evaluate before after --truth truth.jsonl --names red=3 -o comparison",
    ),
    "simulate": (
        "artrec simulate lamp.yaml --frames 60 --objects 1 2 --size 0.3 0.8 -o simulated",
        "artrec simulate --params-file lamp_params.yaml --motion --camera-info camera.yaml -o simulated",
    ),
    "play": (
        "artrec play recorded_bag --remap /camera/segmentation:=/image /camera/camera_info:=/camera_info",
        "artrec play recorded_bag --rate 0.5 --loop",
    ),
    "model": (
        "artrec model stickers.svg -o lamp.yaml",
        "artrec model foot.jpg arm.jpg --width 0.08 0.13 --name lamp -o lamp.yaml",
        "artrec model lamp.urdf --markers stickers.yaml -o lamp.yaml --sheet check.png",
        "artrec model lamp.yaml --sheet check.png --distance 1.5 --camera-info camera.yaml",
        "artrec model lamp.yaml --print lamp.pdf --paper A4",
    ),
    "trace": (
        "artrec trace film.mp4 --params-file lever_params.yaml --picture seen.png -o lever_seen.yaml",
        "artrec trace recorded_bag --params-file arm_params.yaml --object arm -o arm_seen.yaml",
    ),
    "studio": (
        "artrec studio pictures/ --params-file lamp_params.yaml",
        "artrec studio recorded_bag --params-file lamp_params.yaml --annotations photos/annotations.json -o marked",
        "artrec studio pictures/ --params-file lamp_params.yaml --results result --port 8090 --no-open",
    ),
    "prepare": (
        "artrec prepare",
        "artrec prepare --params-file lamp_params.yaml",
    ),
    "inspect": (
        "artrec inspect recorded_bag",
        "artrec inspect lamp_params.yaml recorded_bag camera.yaml photos/annotations.json",
    ),
}


class HelpFormatter(argparse.HelpFormatter):
    """Wraps text as argparse does, but leaves examples, lines that begin with two spaces, as they are."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs: list[str] = []
        for verbatim, lines in _blocks(text):
            joined = "\n".join(lines) if verbatim else " ".join(" ".join(lines).split())
            paragraphs.append(joined if verbatim else textwrap.fill(joined, width))
        return "\n".join(paragraphs)


def _blocks(text: str) -> list[tuple[bool, list[str]]]:
    blocks: list[tuple[bool, list[str]]] = []
    for line in text.splitlines():
        verbatim = line.startswith("  artrec ") or not line.strip()
        if not blocks or blocks[-1][0] != verbatim:
            blocks.append((verbatim, []))
        blocks[-1][1].append(line)
    return blocks


def epilog(command: str, before: str | None) -> str:
    """What stands below a command's options: the command's own text, then its examples."""
    examples = EXAMPLES.get(command, ())
    title = "example:" if len(examples) == 1 else "examples:"
    lines = [] if before is None else [before, ""]
    return "\n".join([*lines, title, *(f"  {e}" for e in examples)]) if examples else (before or "")
