"""What came of the structure, the gravest first: damage of its parts, what it was loaded by and what it bore, its ties."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from masonry_cd.analysis.damage.verdict import NOT_GRADED
from masonry_cd.foundation.quantities import force
from reports.drawing.figure import in_metres
from reports.page.words import PageContext, escaped, number, sensible

G = 9.80665  # [m/s2]
COLUMNS = (
    "part", "grade", "by", "mechanism", "opened", "slid", "opened and slid", "separated", "lost", "opening left [mm]", "sliding left [mm]",
    "drift left [%]", "largest drift [%]",
)  # fmt: skip


def section(name: str, title: str, body: str) -> str:
    """A part of the page with a heading; nothing where it has no body."""
    return f'<section aria-labelledby="{name}-title"><h2 id="{name}-title">{title}</h2>{body}</section>' if body else ""


def table(columns: Sequence[str], rows: Sequence[Sequence[str]], numbers: Sequence[int] = ()) -> str:
    """A table of cells that are HTML already; the first of a row names it, those of ``numbers`` stand to the right."""
    head = "".join(f'<th scope="col"{" class=number" if k in numbers else ""}>{name}</th>' for k, name in enumerate(columns))
    body = []
    for first, *rest in rows:
        named = zip(columns[1:], rest, strict=True)
        cells = [f'<td{" class=number" if k in numbers else ""} data-name="{name}">{cell}</td>' for k, (name, cell) in enumerate(named, 1)]
        body.append(f'<tr><th scope="row">{first}</th>{"".join(cells)}</tr>')
    return f'<div class="scroll"><table class="plain"><thead><tr>{head}</tr></thead><tbody>{"".join(body)}</tbody></table></div>'


def parts(context: PageContext) -> str:
    """The damage of the named parts, the structure first, then the gravest; empty where there is none."""
    if context.parts is None:
        return ""
    whole = context.parts.parts[-1]
    rows = [whole, *sorted(context.parts.parts[:-1], key=lambda row: str(row["grade"]), reverse=True)]
    body = "".join(_part(row, row is whole, context) for row in rows)
    head = "".join(f'<th scope="col">{name}</th>' for name in COLUMNS)
    thresholds = escaped(context.parts.settings.thresholds.in_words())
    state = f" <b>Grades and what is left are {escaped(context.provisional)}.</b>" if context.provisional else ""
    return section(
        "parts",
        "Damage by part",
        f'<div class="scroll short"><table class="parts"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'
        '<p class="note">A part (macro-element) is a group of blocks. Grades go by what is left at the end, see '
        f'<a href="#grades-title">Grades of damage</a>. {thresholds} '
        f"{_looked_at(context)}{state}</p>",
    )


def _looked_at(context: PageContext) -> str:
    """At which times largest values are looked at."""
    assert context.parts is not None
    if context.parts.of_steps:
        return "Largest openings, slidings and drifts are over all time steps; mechanisms are those at the end."
    return (
        "Largest openings and slidings are over all time steps; largest drifts, of which this result file has no others, are over "
        f"{_frames(context)}."
    )


def _frames(context: PageContext) -> str:
    """The frames that the history of the parts is made of, with the time between them."""
    assert context.parts is not None
    times = sorted({row["time"] for row in context.parts.history})
    apart = f", {number(float(f'{1e3 * (times[-1] - times[0]) / (len(times) - 1):.3g}'), 'ms')} apart" if len(times) > 1 else ""
    return f"the {len(times)} frames of the history{apart}"


def _part(row: Mapping[str, Any], whole: bool, context: PageContext) -> str:
    """A row of the table of parts; the verdict stands for the grades of a run that cannot be relied on, once, in the row of the whole."""
    grade, reason = row["grade"], row["grade_reason"]
    if not context.checks.reliable:
        grade, reason = NOT_GRADED, context.verdict.words if whole else ""
    cells = [f'<td><span class="grade {grade.replace(" ", "-")}">{grade}</span></td>', f"<td>{escaped(reason)}</td>"]
    cells.append(f"<td>{escaped(row['mechanism'])}</td>")
    counts = [row[key] for key in ("only_opened", "only_slid", "opened_and_slid", "separated", "lost_blocks")]
    lengths = [1e3 * row["residual_opening"], 1e3 * row["residual_sliding"]]
    drifts = [1e2 * row["residual_drift"], 1e2 * row["max_drift"]]
    cells += [f'<td class="number">{text}</td>' for text in (*map(str, counts), *map(sensible, [*lengths, *drifts]))]
    return f'<tr{" class=whole" if whole else ""}><th scope="row">{escaped(row["part"])}</th>{"".join(cells)}</tr>'


def capacity(context: PageContext) -> str:
    """What the structure was loaded by, and the load factor that it bore where a push or a tilt sought it."""
    return section("capacity", "Loads and capacity", _load_factor(context) + _shaking(context))


def _load_factor(context: PageContext) -> str:
    """The load factor at which the structure gave way, in words."""
    found = context.summary.get("load_factor")
    if not found:
        return ""
    tilted = any(load.get("kind") == "tilt" for load in context.tables.get("loads", []))
    moved = f"a block had moved by more than {in_metres(found['limit'])}"
    if found["given_way"] is None:
        return (
            f"<p>The structure still stood at the load factor <b>{_factor(found['end'], tilted)}</b>, with which the run ended, "
            "and had not given way. Its capacity is this or more.</p>" + _not_the_least(found)
        )
    if "given_way_displacement" in found:
        place = f"a block {in_metres(found['given_way_displacement'])} from its place"
        return (
            f"<p>The structure gave way. The largest load factor that it carried was <b>{_factor(found['given_way'], tilted)}</b>, at "
            f"{number(found['given_way_time'], 's')}, {place}; the load at the end was {number(found['end'])}. "
            "The load factor is the horizontal body force as a share of the weight. Carried is what the load does not spend on motion.</p>"
            + _not_the_least(found)
        )
    return (
        f"<p>The structure gave way at the load factor <b>{_factor(found['given_way'], tilted)}</b>, at "
        f"{number(found['given_way_time'], 's')}, when {moved}; at the end it was {number(found['end'])}. The load factor is the "
        "horizontal body force as a share of the weight. The load grew while the structure began to move, so the capacity found lies a "
        "little above that of a load which waits; a slower one comes closer.</p>" + _not_the_least(found)
    )


def _not_the_least(found: Mapping[str, Any]) -> str:
    """That rigid joints are not the conservative end, and the bracket of limit analysis where there is one."""
    if not found.get("rigid"):
        return ""
    bracket, where = found.get("limit_analysis"), "the command <code>masonry-cd limit</code> gives the bracket"
    if bracket:
        upper, lowest = number(float(f"{bracket['associated']:.3g}")), bracket["least_found"]
        least = (
            f"{number(float(f'{lowest:.3g}'))}, the least found without dilation, to" if lowest is not None else "no least factor, at most"
        )
        where = f"limit analysis has {least} {upper}, the associated value"
    return f"<p>Rigid joints that slide allow several load factors. This run found one, not the least: {where}.</p>"


def _factor(value: float, tilted: bool) -> str:
    """A load factor, with the angle of a tilt."""
    return f"λ = {number(float(f'{value:.3g}'))}" + (f" ({math.degrees(math.atan(value)):.3g}°)" if tilted else "")


def _shaking(context: PageContext) -> str:
    """The peaks of each base motion."""
    rows = []
    for name, direction, peaks in _motions(context.summary.get("loads", {}).get("tables", [])):
        pga = peaks.get("pga", math.nan)
        values = [f"{number(float(f'{pga:.3g}'))} ({pga / G:.2g} g)", *(in_metres(peaks.get(key, 0.0)) for key in ("pgv", "pgd"))]
        rows.append([escaped(name), escaped(direction), values[0], f"{values[1]}&#47;s", values[2]])
    if not rows:
        return ""
    columns = ("base motion", "direction", "PGA [m&#47;s²]", "PGV", "PGD")
    return table(columns, rows) + (
        '<p class="note">Peaks of the base acceleration, velocity and displacement as they were applied. What a structure withstands under '
        "one motion is no capacity: other motions of equal peaks may do more, or less.</p>"
    )


def _motions(tables: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """Name, direction and peaks of each motion of the base, those of shocks in a row one by one."""
    for k, load in enumerate(tables, start=1):
        name = f"load {k}, {load.get('kind', '')}" + (f" {load['path']}" if "path" in load else "")
        if isinstance(load.get("after"), Mapping):
            yield name, _direction(load.get("direction", ())), load["after"]
        for shock in load.get("shocks", ()):
            for component in shock.get("components", ()):
                if isinstance(component.get("after"), Mapping):
                    yield shock["name"], _direction(component.get("direction", ())), component["after"]


def _direction(vector: Sequence[float]) -> str:
    """``x`` for (1, 0, 0), ``−x`` for (-1, 0, 0), else the numbers."""
    along = [f"{'−' if value < 0 else ''}{axis}" for axis, value in zip("xyz", vector, strict=False) if abs(value) > 1e-9]
    if len(along) == 1:
        return along[0]
    return f"({', '.join(f'{value:.3g}' for value in vector)})"


def ties(context: PageContext) -> str:
    """What each tie had to bear."""
    rows = []
    for tie in context.summary.get("ties", ()):
        rows.append(
            [
                escaped(tie.get("name") or " to ".join(tie["blocks"])),
                force(tie["tension_max"]),
                number(float(f"{tie['stress_max'] / 1e6:.3g}")),
                number(float(f"{tie['tension_max_time']:.3g}")),
                force(tie["tension_end"]),
                "–" if tie.get("yield_time") is None else number(float(f"{tie['yield_time']:.3g}")),
            ]
        )
    if not rows:
        return ""
    columns = ("tie", "largest tension", "stress then [MPa]", "at [s]", "tension at the end", "yielded from [s]")
    return section("ties", "Ties", table(columns, rows, range(1, 6)) + _TIES)


_TIES = (
    '<p class="note">Ties are elastic up to their yield force, and pull only. Compare the stress with the strength of the bar, and the '
    "tension with what its anchors and the masonry about them bear: neither is checked here.</p>"
)
