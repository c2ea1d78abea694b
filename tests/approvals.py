# SPDX-License-Identifier: GPL-3.0-or-later
"""The approved texts of tests/approved: all that a command prints, and all that a reader reads on a page, of small made inputs.

    python tests/approvals.py [NAME ...]

writes them again; what has changed is read in review. Numbers that differ from machine to machine, times and paths are masked.
"""

from __future__ import annotations

import argparse
import difflib
import re
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import made_assessment
import numpy as np
from block_files import write_plate_scene
from command_line import masonry_cd
from made_run import at_rest, box, shifted, write_run
from made_study import Made, write_study_folder
from places import EXAMPLES, ROOT
from scipy import sparse

from masonry_cd.analysis.assessment.assessment import Assessment
from masonry_cd.analysis.damage.part_damage import part_damage
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.io.problem_files import write_problem
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.friction.problem import LocalProblem
from masonry_cd.mechanics.model.blocks import Block
from reports.assess.outputs import text_table, write_assessment
from reports.page import write_page

APPROVED = ROOT / "tests" / "approved"
DRY = '[structure]\nkind = "file"\n[material]\ndensity = 2000.0\nfriction = 0.6\n[run]\ndt = 1e-3\nduration = 0.2\n'
SOUND: dict[str, Any] = {
    "steps": 200,
    "dt": 1e-3,
    "stopped": "",
    "solver": {"tolerance": 1e-6, "error_max": 9e-7, "error_mean": 1e-8},
    "closing": {"steps": 0, "jam": ""},
    "energy": {"at_rest": False, "balance_error": 1e-9, "balance_max": 1e-7, "lift_share": 0.0},
    "penetration_max": 2e-5,
    "penetration_where": "",
    "time_step_remarks": [],
    "planar": False,
}
VOLATILE = (  # what differs from machine to machine or from time to time, and what stands for it
    (r"\d{4}-\d\d-\d\d([ T]\d\d:\d\d(:\d\d)?)?", "DATE"),
    (r"\b[0-9a-f]{12,64}\b", "HASH"),
    (r"\b\d+\.\d+\.\d+[\w.]*\b", "VERSION"),
    (r"(?<=kernels for\n).*", "PROCESSOR"),
    (r"(?<=packages not loaded: ).*", "PACKAGES"),
    (r"(?m)^[\d.]+(e-\d\d)? s$", "TIME"),
    (r"[\d.]+e-\d\d\b", "SMALL"),
    (r"\b\d+ iterations( on average, \d+ at most)?", "N iterations"),
    (r"in \S+ m?s, \S+ [mu]?s per step; .*", "in TIME"),
)


def masked(text: str, folder: Path) -> str:
    """A text whose volatile parts are replaced."""
    text = text.replace(f"{folder}/", "").replace(str(folder), ".").replace(f"{ROOT}/", "")
    for pattern, word in VOLATILE:
        text = re.sub(pattern, word, text)
    return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"


# --- commands -------------------------------------------------------------------------------------------------------------------------


def typed(*lines: str, **keys: str) -> Callable[[Path], str]:
    """All that command lines print, one after the other, in the folder of the scene of a block on a plate."""

    def text(folder: Path) -> str:
        write_plate_scene(folder, **({"duration": "duration = 0.05"} | keys))
        write_problem(folder / "problem.npz", LocalProblem(sparse.identity(3, format="csr"), np.array([[-1.0, 0.2, 0.0]]), np.array([0.5])))
        values = np.sin(0.09 * np.arange(200)) * np.exp(-0.01 * np.arange(200))
        (folder / "shock.csv").write_text("time_s,a_m_s2\n" + "".join(f"{0.01 * k:.2f},{v:.6f}\n" for k, v in enumerate(values)))
        out = []
        for line in lines:
            result = masonry_cd(*(word.replace("{}", str(folder)).replace("{examples}", str(EXAMPLES)) for word in line.split()))
            said = [f"$ masonry-cd {line.replace('{}/', '').replace('{}', '.')}", result.stdout, f"exit code {result.exit_code}"]
            out += [*said, *(f"  to standard error: {one}" for one in result.stderr.splitlines()), ""]
        return "\n".join(out)

    return text


# --- pages ----------------------------------------------------------------------------------------------------------------------------


def stack() -> list[Block]:
    """Two blocks on a base."""
    return [
        box("base", (-1, 0, -0.5), (2, 1, 0), "base", fixed=True),
        box("lower", (0, 0, 0), (1, 1, 1), "wall"),
        box("upper", (0, 0, 1), (1, 1, 2), "wall"),
    ]


def states(along: tuple[float, float, float] = (0.02, 0.0, 0.0), slip: float = 0.0) -> list[Any]:
    """The base goes along a vector and back, and the upper block has slipped; at rest in the end."""
    rest, slipped = at_rest(stack()), shifted(at_rest(stack()), 2, (slip, 0, 0))
    return [rest, shifted(slipped, slice(None), along), slipped]


def page_of(folder: Path, scene: str = DRY, summary: Mapping[str, Any] | None = None, **more: Any) -> str:
    """The HTML of the page of such a run; ``along`` and ``slip`` are those of its states, others of :func:`made_run.write_run`."""
    moved = states(**{key: more.pop(key) for key in ("along", "slip") if key in more})
    with Results.open(write_run(folder / "result.h5", stack(), moved, "Two blocks", scene=scene, ended=True, **more)) as results:
        write_page(results, folder / "report.html", Summary(**(SOUND if summary is None else summary)), parts=part_damage(results))
    return (folder / "report.html").read_text(encoding="utf-8")


def words(html: str) -> str:
    """The text of a page, tags left out."""
    body = re.sub(r"<(script|style).*?</\1>", " ", html[html.index("<body") :], flags=re.DOTALL)
    return unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", body))).strip()


def in_lines(html: str) -> str:
    """The words of a page, a line for each of its headings, paragraphs, rows and items."""
    body = re.sub(r"<(script|style|svg).*?</\1>", " ", html[html.index("<body") :], flags=re.DOTALL)
    broken = re.sub(r"<(h\d|p|tr|li|dt|dd|option|button|label|summary|pre|div|section)\b", r"\n<\1", re.sub(r"\s+", " ", body))
    lines = (unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", line))).strip() for line in broken.splitlines())
    return "\n".join(line for line in lines if line)


def page(scene: str = DRY, summary: Mapping[str, Any] | None = None, **more: Any) -> Callable[[Path], str]:
    """The words of a page of two blocks."""
    return lambda folder: in_lines(page_of(folder, scene, summary, **more))


def study(made: Made) -> Callable[[Path], str]:
    """The words of the page of a made study."""

    def text(folder: Path) -> str:
        from reports.study.outputs import write_study

        write_study(write_study_folder(folder, made, joints=True))
        return in_lines((folder / "study.html").read_text(encoding="utf-8"))

    return text


def compared(folder: Path) -> str:
    """All that is said of two runs that differ by the slip of a block."""
    for name, slip in (("weak", 0.006), ("strong", 0.03)):
        (folder / name).mkdir()
        write_run(folder / name / "result.h5", stack(), states(slip=slip), "Two blocks", scene=DRY, ended=True)
    return typed("compare {}/weak {}/strong", "compare {}/weak")(folder)


def assessed(found: Assessment) -> Callable[[Path], str]:
    """The table of an assessment in the terminal, and the words of its page."""

    def text(folder: Path) -> str:
        write_assessment(made_assessment.written(folder, found))
        return f"{text_table(found)}\n\n{in_lines((folder / 'assess.html').read_text(encoding='utf-8'))}"

    return text


FAILED = RunRow("failed", "blocks <overlap>", 0.1)
TRIED = made_assessment.made({("friction", "0.4"): FAILED, ("joint stiffness", "E 3.3 GPa"): made_assessment.row(120.0, steps_missed=3)})
MORTAR = DRY.replace("friction = 0.6\n", "") + (
    "[material.friction]\ndefault = 0.6\nwall-base = 0.4\n"
    "[material.joints.wall-wall]\nnormal_stiffness = 2e10\ncohesion = 1.5e5\ntension = 1e5\n"
)
TITLED = DRY + '[report]\nproject = "Garden wall <3>"\nclient = "City//Works"\nauthor = "A. Engineer"\ndate = "May 2025"\n'
LOADED = DRY + (
    '[[loads]]\nkind = "settlement"\nsupports = ["base"]\ndirection = "-z"\ndisplacement = 0.03\nduration = 0.5\n'
    '[[loads]]\nkind = "point"\nblock = "upper"\nforce = [0.0, 0.0, -400e3]\n'
    '[[loads]]\nkind = "tie"\nblocks = ["upper", "base"]\ndiameter = 0.02\ntension = 5e3\n'
)
TILT = DRY + '[[loads]]\nkind = "tilt"\ndirection = "x"\nrate = 3.0\n'
FLOOR = DRY + '[[structure.floors]]\nheight = 3.0\nthickness = 0.2\nmass = 300.0\nwalls = ["*"]\n'
FACTOR = {"end": 0.3, "limit": 2e-3, "given_way": 0.25, "given_way_time": 1.5}
RIGID = FACTOR | {"rigid": True}
PEAKS = {"pga": 3.0, "pgv": 0.3, "pgd": 0.02}
SHOCK = {"name": "foreshock", "components": [{"direction": [0, 1, 0], "after": PEAKS}]}
SHAKEN = [{"kind": "sinusoidal", "direction": [1, 0, 0], "after": PEAKS}, {"kind": "sequence", "shocks": [SHOCK]}]
TIE = {"blocks": ["a", "b"], "tension_max": 1.05e6, "stress_max": 2.1e8, "tension_max_time": 1.234, "tension_end": 2e3}
DOUBTFUL: dict[str, Any] = SOUND | {
    "closing": {"steps": 3, "jam": "a wedge"},
    "energy": SOUND["energy"] | {"balance_error": 0.1, "lift_share": 0.1},
    "penetration_max": 5e-3,
    "time_step_remarks": ["run.dt 0.01 s is coarse for the shaking"],
    "shortening_where": "a and b at 1 s",
    "shortening_max": 1e-3,
    "doubts": ["block a falls"],
}


def bracket(least: float | None, associated: float | None) -> dict[str, Any]:
    """The summary of a push whose factor limit analysis brackets."""
    return SOUND | {"load_factor": RIGID | {"limit_analysis": {"least_found": least, "associated": associated}}}


TEXTS: dict[str, Callable[[Path], str]] = {
    "run": typed("run {}/scene.toml -o {}/out --explain", "run {}/scene.toml -o {}/out", friction="friction = 0.3"),
    "build": typed("build {}/scene.toml -o {}/out --no-picture", "build {examples}/arch.toml -o {}/arch --no-picture"),
    "record": typed("record {}/shock.csv", "record {}/shock.csv --measure CAV --measure Sa(0.5)", "record --formats"),
    "solve": typed("solve {}/problem.npz --solver nlgs -o {}/solution.npz"),
    "init": typed("init arch -o {}/new.toml", "init arch -o {}/new.toml", "init arch -o {}", "init aqeduct -o {}/other.toml"),
    "view": typed("view {}", "view {}/none"),
    "validate": typed("validate"),
    "version": typed("--version"),
    "page_dry": page(),
    "page_titled": page(TITLED, slip=0.006),
    "page_floors": page(FLOOR),
    "page_over_all_steps": page(every=2),
    "page_mortar": page(MORTAR, along=(0.01, 0, 0.01)),
    "page_doubtful": page(DRY, DOUBTFUL, slip=0.02),
    "page_without_summary": page(DRY, {}),
    "page_tilt": page(TILT, SOUND | {"load_factor": FACTOR}),
    "page_push_that_stood": page(DRY, SOUND | {"load_factor": FACTOR | {"given_way": None, "given_way_time": None}}),
    "page_factor_alone": page(DRY, SOUND | {"load_factor": RIGID}),
    "page_factor_bracketed": page(DRY, bracket(0.2231, 0.2712)),
    "page_factor_without_least": page(DRY, bracket(None, 0.2712)),
    "page_factor_of_one_value": page(DRY, bracket(0.2712, 0.2712)),
    "page_factor_wedged": page(DRY, bracket(0.1667, None)),
    "page_shaking_and_ties": page(DRY, SOUND | {"loads": {"tables": SHAKEN}, "ties": [TIE, TIE | {"name": "nave", "yield_time": 0.5123}]}),
    "modal": typed("modal {examples}/arch.toml -o {}/m --set structure.voussoirs=7 --modes 2 --pictures 0 --method joints --young 3e9"),
    "compare": compared,
    "assess": assessed(TRIED),
    "assess_without_base": assessed(replace(TRIED, members=(replace(TRIED.members[0], row=FAILED), *TRIED.members[1:]))),
    "page_loads": page(LOADED, SOUND | {"modelled": ["masses: 4 t free to move, wall 4 t"]}),
    "study_stripes": study(Made(records=6, levels=(1.5, 3.0, 5.0), by_friction=0.2)),
}


def text_of(name: str, folder: Path) -> str:
    """A text as it is now; of a page only the lines by which it differs from that of two dry blocks."""
    text = masked(TEXTS[name](folder), folder)
    if not name.startswith("page_") or name == "page_dry":
        return text
    dry = (APPROVED / "page_dry.txt").read_text(encoding="utf-8").splitlines()
    lines = list(difflib.unified_diff(dry, text.splitlines(), n=0, lineterm=""))[2:]
    return "\n".join(line for line in lines if not line.startswith("@@")) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("names", nargs="*", choices=[[], *TEXTS], metavar="NAME")
    APPROVED.mkdir(exist_ok=True)
    for name in parser.parse_args().names or TEXTS:
        with tempfile.TemporaryDirectory() as scratch:
            (APPROVED / f"{name}.txt").write_text(text_of(name, Path(scratch)), encoding="utf-8")
