# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/gallery.md: every scene of examples/ with its picture and what it costs. Each is run as it stands.

python docs/draw_gallery.py --records FOLDER     (with the folder of the records that scenes name, which the program does not have)
python docs/draw_gallery.py --only arch
python docs/draw_gallery.py --draw               (the pictures again, of the runs that are left in out/gallery)
python docs/draw_gallery.py --page               (the text again from docs/gallery/measured.json; nothing is run)
"""

from __future__ import annotations

import argparse
import json
import re
import resource
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.io.results import Results

if TYPE_CHECKING:
    from PIL import Image

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
PAGE, FOLDER = DOCS / "gallery.md", DOCS / "gallery"
MEASURED = FOLDER / "measured.json"
RUNS = DOCS.parent / "out" / "gallery"
WIDTH = 1000  # of a picture [pixels]
VISIBLE = 1e-4  # what a crack map shows of a joint [m]
HEAD = """# Gallery

Every scene in `examples/` with its crack map: at the end of the run, or where nothing is left by then, at its widest cracks. Written by
`python docs/draw_gallery.py`, which runs each of them and measures its processor time: checking, computing and drawing, on all threads
that it takes, with kernels compiled before. Other programs shared the machine.

"""


def examples() -> list[str]:
    """Names of all examples that are scenes, not studies."""
    return sorted(path.stem for path in EXAMPLES.glob("*.toml") if "design" not in tomllib.loads(path.read_text()))


def page(measured: dict[str, Any]) -> str:
    """The text of the page: a table of all examples, then each with its picture. Where a record is missing, none was measured."""
    rows = [
        "| example | blocks | joints | steps | processor time |",
        "|---|---|---|---|---|",
        *(_row(name, measured) for name in examples()),
    ]
    return HEAD + "\n".join([*rows, "", *(_section(name, name in measured) for name in examples())])


def missing(name: str) -> list[str]:
    """Files that the loads of an example read and that are not next to it."""
    loads = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")).get("loads", [])
    return [load["path"] for load in loads if "path" in load and not (EXAMPLES / load["path"]).exists()]


def about(name: str) -> tuple[str, str, str]:
    """Title of an example, what the comment at its head says of it, and the commands there."""
    text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
    comment = re.match(r"(?:#.*\n)+", text)
    lines = [line.removeprefix("#").strip() for line in comment.group(0).splitlines()] if comment else []
    commands = [line for line in lines if line.startswith("masonry-cd ")] or [f"masonry-cd run examples/{name}.toml -o out/{name}"]
    return tomllib.loads(text).get("title", name), "\n".join(line for line in lines if line not in commands), "\n".join(commands)


def _row(name: str, measured: dict[str, Any]) -> str:
    if name not in measured:
        return f"| [`{name}.toml`](#{name}) | | | | reads {missing(name)[0]}, which the program does not bring |"
    its = measured[name]
    return f"| [`{name}.toml`](#{name}) | {its['blocks']} | {its['joints']} | {its['steps']} | {_said(its['seconds'])} |"


def _section(name: str, drawn: bool) -> str:
    title, words, command = about(name)
    picture = f"![Crack map of {name}.toml](gallery/{name}.png)\n" if drawn else ""
    return f"## {name}\n\n**{title}.** {words}\n\n```sh\n{command}\n```\n\n{picture}"


def _said(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.1f} min"


def measure(name: str, records: Path | None) -> dict[str, Any]:
    """Run an example, draw its picture, and return what it took."""
    out = RUNS / name
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "masonry_cd", "run", EXAMPLES / f"{name}.toml", "-o", out, "--force", "-q"]
    subprocess.run([*command, "--set", "report.crack_map=true", *_records(name, records)], check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    draw(name)
    summary = json.loads((out / "summary.json").read_text())
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"blocks": summary["blocks"], "joints": summary["joints"], "steps": summary["steps"], "seconds": round(seconds, 1)}


def draw(name: str) -> None:
    """A small picture of a run: of its end, or where nothing is left by then, of the moment at which its joints were open widest."""
    from PIL import Image

    out = RUNS / name
    with Results.open(out / "result.h5") as results:
        widest = results.joint_history("opening").max(axis=1, initial=0.0)
        left = max(widest[-1], results.joint_history("sliding")[-1].max(initial=0.0))
        when, joints = float(results.time[int(widest.argmax())]), results.joints.count
    if joints and left < VISIBLE:
        subprocess.run([sys.executable, "-m", "masonry_cd", "report", out, "--time", str(when)], check=True, stdout=subprocess.DEVNULL)
    with Image.open(out / "crack_map.png") as image:
        small = image.convert("RGB").resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.LANCZOS)
    in_few_colours(small).save(FOLDER / f"{name}.png", optimize=True)


def in_few_colours(image: Image.Image) -> Image.Image:
    """A picture with a palette, half of it for the colours of the joints, which are few of its pixels."""
    from PIL import Image

    pixels = np.asarray(image).reshape(1, -1, 3)
    strong = np.ptp(pixels, axis=2) > 60
    palette = Image.new("P", (1, 1))
    halves = [Image.fromarray(pixels[:, mask[0]]).quantize(128).getpalette() or [] for mask in (strong, ~strong)]
    palette.putpalette([value for half in halves for value in half[: 3 * 128]])
    return image.quantize(palette=palette, dither=Image.Dither.NONE)


def _records(name: str, folder: Path | None) -> list[str]:
    """Options that look for the records of a scene in a folder."""
    loads = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")).get("loads", [])
    paths = [(i, load["path"]) for i, load in enumerate(loads) if "path" in load]
    if paths and folder is None:
        raise SystemExit(f"{name}.toml reads {paths[0][1]}: say where it is, --records FOLDER")
    return [word for i, path in paths for word in ("--set", f"loads[{i}].path={folder / Path(path).name if folder else path}")]


def main() -> None:
    """Measure what was requested, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these examples alone")
    parser.add_argument("--records", type=Path, metavar="FOLDER", help="where the records are")
    parser.add_argument("--draw", action="store_true", help="draw runs of out/gallery again")
    parser.add_argument("--page", action="store_true", help="run nothing")
    asked = parser.parse_args()
    measured = json.loads(MEASURED.read_text()) if MEASURED.exists() else {}
    names = examples()
    if asked.draw:
        for name in asked.only or sorted(path.parent.name for path in RUNS.glob("*/summary.json")):
            draw(name)
    for name in () if asked.page or asked.draw else asked.only or names:
        measured[name] = measure(name, asked.records)
        print(name, measured[name], flush=True)
        MEASURED.write_text(json.dumps({key: measured[key] for key in sorted(measured) if key in names}, indent=1) + "\n")
    PAGE.write_text(page({key: measured[key] for key in measured if key in names}), encoding="utf-8")


if __name__ == "__main__":
    main()
