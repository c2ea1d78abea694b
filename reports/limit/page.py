"""limit.html: a limit analysis on one page that needs nothing else: factor, check by a code, pictures, mechanism, certificate, scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.quantities import force
from reports.page.document import filled, header, pictures, plain_style, write_document
from reports.page.findings import section, table
from reports.page.title_block import rows_of
from reports.page.words import escaped, number

CAPTIONS = {
    "mechanism.png": "How the structure gives way: blocks that move, joints that are hinges, slide or open; thin lines: the structure as "
    "built. The size of the displacements is chosen for the eye; only their ratios are computed.",
    "thrust.png": "The forces at collapse: where the resultant crosses each joint, as wide as it is large. Forces in parts that do not "
    "move are one of many sets that balance the loads.",
    "capacity.png": "The load factor while the mechanism goes on, as far as it was followed; below, the structure at the marked points.",
}
NAMED = 40  # blocks at most that are listed
CERTIFICATE = {
    "static": (
        "Static value",
        "what the forces found bear: the associated factor is no less, where the residuals of forces are zero",
    ),
    "kinematic": ("Kinematic value", "the load that the mechanism found cannot resist: no factor is more"),
    "gap": ("Gap", "between the two: how far the associated factor is known"),
    "equilibrium": ("Equilibrium", "largest force that is left over on a block, over the mean weight of a block"),
    "friction": ("Strength", "largest force beyond what friction or a bond allows, over the mean weight of a block"),
    "flow": ("Flow rule", "by how much a joint closes that must not, over the largest velocity"),
}
VERDICTS = {"satisfied": "good", "not decided": "look", "NOT satisfied": "doubtful"}  # and how they are coloured
CHECKED = {
    "satisfied": "the check by a code is met",
    "not decided": "the check by a code decides nothing here",
    "NOT satisfied": "the check by a code is not met",
}
STATES = {"hinge": "hinges", "slide": "slide", "hinge_and_slide": "hinge and slide", "open": "open"}


@dataclass(frozen=True)
class LimitPage:
    """What the page shows."""

    summary: Mapping[str, Any]  # limit.json
    lines: Sequence[str]  # what was found; the first says of what
    scene: str  # its text
    options: Sequence[str]  # of the command, beside what the scene asks for
    report: Mapping[str, Any]  # the scene's table [report]


def write_limit_page(page: LimitPage, drawn: Sequence[Path], path: Path) -> None:
    """Write the page.

    Args:
        page: its contents.
        drawn: PNGs; those that are not there are left out.
        path: of the page.

    Raises:
        InputError: it cannot be written.
    """
    summary = page.summary
    block = rows_of(page.report, f"masonry_cd {summary['version']}", page.scene)
    values = {
        "header": header(summary["title"], page.lines, summary["notes"], _numbers(summary), block, on_the_check(summary["verdict"])),
        "check": _check(summary["check"], summary["verdict"]),
        "pictures": pictures({picture: CAPTIONS[picture.name] for picture in drawn if picture.exists()}),
        "mechanism": _mechanism(summary),
        "ties": _ties(summary),
        "certificate": _certificate(summary),
        "command": escaped(" ".join(["masonry-cd limit scene.toml -o out", *page.options])),
        "scene": escaped(page.scene),
    }
    body = filled((files("reports.limit") / "limit.html").read_text(encoding="utf-8"), values)
    write_document(path, summary["title"], body, plain_style())


def on_the_check(found: Mapping[str, Any] | None) -> Verdict | None:
    """The verdict of a check by a code as the head of a page has it; None where none was asked for."""
    return None if found is None else Verdict(found["state"], "", found["reason"], VERDICTS[found["state"]], CHECKED[found["state"]], "")


def _numbers(summary: Mapping[str, Any]) -> list[tuple[str, object]]:
    """The headline numbers."""
    out: list[tuple[str, object]] = [("stands under its dead loads", "yes" if summary["stands"] else "no")]
    if summary["bears_nothing"]:
        out.append(("load factor", "none"))
    elif summary["no_finite_factor"]:
        out.append(("load factor", "not finite"))
    elif summary.get("associated") is not None:
        out.append(("load factor, an upper value", number(float(f"{summary['associated']:.4g}"))))
    if summary.get("least") and not summary["bears_nothing"]:
        out.append(("least factor found without dilation", number(float(f"{summary['least']['factor']:.4g}"))))
    moving = summary["mechanism"]["moving_blocks"]
    out.append(("blocks that move", f"{len(moving)}<small> of {summary['blocks']}</small>"))
    if summary["verdict"]:
        out.append(("verdict of the check", escaped(summary["verdict"]["state"])))
    for one in (summary["check"] or {}).get("verdicts", []):
        out.append((f"{escaped(one['check'])} check, {one['state']}: borne over asked for", number(float(f"{one['ratio']:.3g}"))))
    return out


def _check(check: Mapping[str, Any] | None, verdict: Mapping[str, Any] | None) -> str:
    """The check by a code: its verdict, the checks made, the mechanisms looked at, and every value."""
    if verdict is None:
        return ""
    said = f'<p><span class="verdict {VERDICTS[verdict["state"]]}">{verdict["state"]}</span> {escaped(verdict["reason"])}.</p>'
    if check is None:
        return section("check", "Check by a code", said)
    state = f", limit state {check['limit_state']}" if check["limit_state"] else ""
    verdicts = "".join(
        f'<li><span class="verdict {VERDICTS[one["state"]]}">{one["state"]}</span> '
        f"{escaped(one['check'])} check: {escaped(one['words'].partition(': ')[2])}</li>"
        for one in check["verdicts"]
    )
    rows = [[escaped(step["symbol"]), _value(step), escaped(step["clause"]), escaped(step["meaning"])] for step in check["steps"]]
    left = [f"Left open by the clauses: {one}." for one in check["left_open"]]
    more = "".join(f'<p class="note">{escaped(note)}</p>' for note in [*check["notes"], *left])
    return section(
        "check",
        "Check by a code",
        f'{said}<p>{escaped(check["edition"])}{state}; {escaped(check["ground"])}.</p><ul class="said">{verdicts}</ul>{more}'
        + _looked(check["basis"])
        + table(("symbol", "value", "clause", "meaning"), rows, (1,)),
    )


def _looked(basis: Mapping[str, Any]) -> str:
    """The mechanisms looked at, the one that is checked first, and the search that found them."""
    if not basis["looked"]:
        return ""
    rows = [
        [
            escaped(one["found"]), f"{one['moving_blocks']:,}", number(float(f"{one['alpha0']:.4g}")),
            number(float(f"{one['fraction']:.3g}")), number(float(f"{one['acceleration']:.4g}"), "m/s²"),
            escaped(f"e* = 1 is taken: {one['doubt']}" if one["doubt"] else ""),
        ]
        for one in basis["looked"]
    ]  # fmt: skip
    said = (
        "Of the mechanisms that were found, the one that starts under the least acceleration a0* is checked: the first of this table. "
        "One that dilates or spreads is no oscillator with one degree of freedom: e* = 1 is then taken, the safe side, and there is no "
        "check by displacements."
    )
    head = ("found by", "blocks that move", "α0", "e*", "a0*", "")
    return f'<p>{said}</p>{table(head, rows, (1, 2, 3, 4))}<p class="note">{escaped(basis["search"])}.</p>'


def _value(step: Mapping[str, Any]) -> str:
    """Four digits and the unit; weights and masses in full."""
    value = step["value"]
    return f"{value:,.0f} {step['unit']}" if abs(value) >= 1e4 else number(value, escaped(step["unit"].replace("s2", "s²")))


def _mechanism(summary: Mapping[str, Any]) -> str:
    """What moves and how."""
    found = summary["mechanism"]
    if summary["no_finite_factor"]:
        return section("mechanism", "Mechanism", "<p>There is none on which the load does work.</p>")
    counts = ", ".join(f"{found[f'joints_{key}'] or 'none'} {words}" for key, words in STATES.items())
    names = found["moving_blocks"]
    some = ", ".join(names[:NAMED]) + (" …" if len(names) > NAMED else "")
    of = "the least factor found" if found["of"] == "least" else "the associated factor"
    fall = f"The mechanism of {of}." if summary["stands"] else "What gives way under the dead loads."
    tables = "Velocities of all blocks are in <code>blocks.csv</code>, rates and forces of all joints in <code>joints.csv</code>."
    body = f"<p>{fall} Of {summary['joints']} joints: {counts}. {tables}</p>"
    return section("mechanism", "Mechanism", f"{body}<p>{len(names)} blocks move: {escaped(some)}.</p>")


def _ties(summary: Mapping[str, Any]) -> str:
    """What the ties pull at collapse."""
    ties = summary["ties"]
    if not ties:
        return ""
    rows = [
        [
            escaped(tie["tie"]), escaped(f"{tie['block_a']} to {tie['block_b']}"), force(tie["tension_n"]),
            "never" if tie["yield_force_n"] is None else force(tie["yield_force_n"]), "yes" if tie["yields"] else "no",
        ]
        for tie in ties
    ]  # fmt: skip
    return section("ties", "Ties at collapse", table(("tie", "between", "pulls", "yields at", "it yields"), rows, (2, 3)))


def _certificate(summary: Mapping[str, Any]) -> str:
    """How good the answer is, in words."""
    made, solver = summary["certificate"], summary["solver"]
    if made is None:
        return ""
    rows = [[name, number(made[key]), escaped(words)] for key, (name, words) in CERTIFICATE.items()]
    how = f"{solver['method']}, {solver['iterations']} iterations; measured apart from the solver, without units."
    said = (
        "By the two theorems of limit analysis the associated factor, of sliding that opens joints, lies between the static and the "
        "kinematic value. For friction that does not dilate it is an upper value, and the static value no lower bound; the least factor "
        "is found by a search, without proof."
    )
    body = table(("", "value", "meaning"), rows, (1,)) + f'<p class="note">{escaped(how)} {said}</p>'
    return section("certificate", "How good the answer is", body)
