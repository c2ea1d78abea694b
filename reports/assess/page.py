"""assess.html: an assessment on one page that needs nothing else: the verdict, the tornado, the table of runs."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from masonry_cd.analysis.assessment.assessment import FELT, GRADE, Assessment
from masonry_cd.analysis.assessment.verdict import between, lines_of, on_the_whole, place_of, shown, warnings_of
from reports.assess.tables import heads, rows_of
from reports.page.document import filled, header, pictures, plain_style, write_document
from reports.page.words import escaped

PAGE = "assess.html"
CAPTION = (
    "Each bar runs from the least to the largest value of an answer when one assumption is changed and all else stays; dots are levels. "
    "The grey band and the marks in the first row are runs of the same scene that differ by a billionth of the amplitude: their spread is "
    "chance. A full bar is longer than chance makes it in 19 of 20 cases, and than a twentieth of the base case; a hollow one is not. A "
    "white diamond is the case that the levels of an assumption are compared with where that is not the base case."
)
READ = (
    "The base case is the scene as it is. Chance is judged by the studentised range of as many runs as a "
    f"bar has (Tukey's test), and a difference under {100 * FELT:.0f} % of the base case counts as none. Assumptions are ranked by the "
    "share of the range of each answer that their bars take."
)


def write_page(found: Assessment, drawn: Sequence[Path], path: Path) -> None:
    """Write assess.html.

    Raises:
        InputError: it cannot be written.
    """
    here = files("reports.study")
    values = {
        "header": header(found.title, _lead(lines_of(found)), warnings_of(found), _tiles(found), verdict=on_the_whole(found)),
        "pictures": pictures(dict.fromkeys(drawn, CAPTION)),
        "runs": _runs(found),
        "assumed": _assumed(found),
    }
    template = (files("reports.assess") / "assess.html").read_text(encoding="utf-8")
    style = plain_style() + (here / "study.css").read_text(encoding="utf-8")
    script = (here / "study.js").read_text(encoding="utf-8")
    write_document(path, f"{found.title}: what the answer rests on", filled(template, values), style, script)


def _lead(lines: list[str]) -> list[str]:
    """The lines for the page, whose title says of what scene they are."""
    first = lines[0].partition(": ")
    return [f"The verdict lies {first[2]}" if first[2].startswith("between") else first[2], *lines[1:]]


def _tiles(found: Assessment) -> list[tuple[str, object]]:
    """The numbers at the head."""
    out: list[tuple[str, object]] = [("runs", len({one.row["run"] for one in found.members if one.done}))]
    for answer in found.answers:
        low, high = found.range(answer)
        name = f"{answer.name}, base case"
        out.append((escaped(name), escaped(f"{shown(answer, found.base.of(answer)) or 'none'} {answer.unit}".strip())))
        if answer == GRADE or answer.key == "displacement_max":
            out.append((escaped(f"{answer.name}, all runs"), escaped(between(answer, low, high))))
    return out


def _runs(found: Assessment) -> str:
    """The table of runs."""
    names = ("assumption", "level", *heads(found), "remark")
    head = "".join(f'<th scope="col">{escaped(name)}</th>' for name in names)
    rows = []
    for row in rows_of(found):
        numbers = "".join(f'<td class="number">{escaped(cell)}</td>' for cell in row[2:-1])
        rows.append(f'<tr><th scope="row">{escaped(row[0])}</th><td>{escaped(row[1])}</td>{numbers}<td>{escaped(row[-1])}</td></tr>')
    body = f"<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody>"
    return (
        f'<section aria-labelledby="runs-title"><h2 id="runs-title">Runs</h2><div class="scroll"><table id="fits">{body}</table></div>'
        f'<p class="hint">* some steps missed the tolerance. All digits and SI units are in assess.csv.</p></section>'
    )


def _assumed(found: Assessment) -> str:
    """What was varied, and what was not."""
    rows = [("scene", found.scene)]
    rows += [(one.name, f"{one.base}; varied: {', '.join(one.levels)}") for one in found.ranked]
    rows += [(name, f"not varied: {why}") for name, why in found.left_out]
    rows += [("how it is judged", READ)]
    failed = [place_of(one) for one in found.members if one.row and not one.done]
    rows += [("no data", ", ".join(failed))] if failed else []
    return "".join(f"<dt>{escaped(name)}</dt><dd>{escaped(value)}</dd>" for name, value in rows)
