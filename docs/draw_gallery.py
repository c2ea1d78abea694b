"""Write docs/gallery.md: every scene of examples/ with its picture and what it costs. Each is run as it stands.

python docs/draw_gallery.py --records FOLDER     (with the folder of the records that scenes name, which the program does not have)
python docs/draw_gallery.py --only arch
python docs/draw_gallery.py --page               (the text anew from docs/gallery/measured.json; nothing is run)
"""

from __future__ import annotations

import argparse
import json
import re
import resource
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"
PAGE, FOLDER = DOCS / "gallery.md", DOCS / "gallery"
MEASURED = FOLDER / "measured.json"
WIDTH, COLOURS = 1000, 96  # of a picture: pixels, and colours of its palette, which keep it below 150 kB
HEAD = """# Gallery

Every scene in `examples/`, as its crack map shows it. Written by `python docs/draw_gallery.py`, which runs each of them and measures its processor
time: checking, computing and drawing on one thread, with kernels compiled before. Other programs shared the machine.

"""


def examples() -> list[str]:
    """Names of all examples."""
    return sorted(path.stem for path in EXAMPLES.glob("*.toml"))


def page(measured: dict[str, Any]) -> str:
    """The text of the page: a table of all examples, then each with its picture. Where a record is missing, none was measured."""
    rows = [
        "| example | blocks | joints | steps | processor time |",
        "|---|---|---|---|---|",
        *(_row(name, measured) for name in examples()),
    ]
    return HEAD + "\n".join([*rows, "", *(_section(name, name in measured) for name in examples())])


def missing(name: str) -> list[str]:
    """Files that the loads of an example read and that are not beside it."""
    loads = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")).get("loads", [])
    return [load["path"] for load in loads if "path" in load and not (EXAMPLES / load["path"]).exists()]


def about(name: str) -> tuple[str, str, str]:
    """Title of an example, what the comment at its head says of it, and the command there."""
    text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
    comment = re.match(r"(?:#.*\n)+", text)
    lines = [line.removeprefix("#").strip() for line in comment.group(0).splitlines()] if comment else []
    command = next((line for line in lines if line.startswith("masonry-cd run ")), f"masonry-cd run examples/{name}.toml -o out/{name}")
    return tomllib.loads(text).get("title", name), "\n".join(line for line in lines if line != command), command


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
    """Run an example, keep its crack map as a small picture, and return what it took."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [sys.executable, "-m", "masonry_cd", "run", EXAMPLES / f"{name}.toml", "-o", out, "--force", "-q"]
        subprocess.run([*command, "--set", "report.crack_map=true", *_records(name, records)], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        _keep(out / "crack_map.png", FOLDER / f"{name}.png")
        summary = json.loads((out / "summary.json").read_text())
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"blocks": summary["blocks"], "joints": summary["joints"], "steps": summary["steps"], "seconds": round(seconds, 1)}


def _records(name: str, folder: Path | None) -> list[str]:
    """Options that look for the records of a scene in a folder."""
    loads = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")).get("loads", [])
    paths = [(i, load["path"]) for i, load in enumerate(loads) if "path" in load]
    if paths and folder is None:
        raise SystemExit(f"{name}.toml reads {paths[0][1]}: say where it is, --records FOLDER")
    return [word for i, path in paths for word in ("--set", f"loads[{i}].path={folder / Path(path).name if folder else path}")]


def _keep(picture: Path, place: Path) -> None:
    """Write a picture smaller, in few colours."""
    from PIL import Image

    with Image.open(picture) as image:
        height = round(image.height * WIDTH / image.width)
        image.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS).quantize(COLOURS).save(place, optimize=True)


def main() -> None:
    """Measure what was asked for, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these examples alone")
    parser.add_argument("--records", type=Path, metavar="FOLDER", help="where the records are")
    parser.add_argument("--page", action="store_true", help="run nothing")
    asked = parser.parse_args()
    measured = json.loads(MEASURED.read_text()) if MEASURED.exists() else {}
    names = examples()
    for name in () if asked.page else asked.only or names:
        measured[name] = measure(name, asked.records)
        print(name, measured[name], flush=True)
        MEASURED.write_text(json.dumps({key: measured[key] for key in sorted(measured) if key in names}, indent=1) + "\n")
    PAGE.write_text(page({key: measured[key] for key in measured if key in names}), encoding="utf-8")


if __name__ == "__main__":
    main()
