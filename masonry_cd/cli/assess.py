# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd assess``: what the answer of a scene rests on."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.app.progress import Interrupted
from masonry_cd.cli.shared import Changes, Force, Output, Quiet, SceneFile, Trust, errors_reported, same_command, warn


def assess(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    all_pairs: Annotated[bool, typer.Option("--all-pairs", help="Two levels of every two assumptions together as well.")] = False,
    workers: Annotated[int | None, typer.Option(metavar="N", min=1, help="Processes of this machine.", show_default="all cores")] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Make runs again that failed or ran out of time.")] = False,
    plan: Annotated[bool, typer.Option("--plan", help="Say how many runs there are, and make none.")] = False,
    report: Annotated[bool, typer.Option("--report", help="Write again what follows from the runs in DIR; make none.")] = False,
    force: Force = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Vary each assumption of a scene by itself: which of them decides the answer, and which do not.

    Varied are the stiffness of the joints, friction, the size of the blocks, their bond, damping, the points of elastic joints, the time
    step and the tolerance; the scene as it is runs again as a small ensemble, which shows what chance does. A scene with a table [limit]
    has its load factor among the answers. Ranges of its own stand in the table [assess].

    DIR gets assess.png, a tornado chart, the page assess.html, assess.csv and assess.json. The same command again continues where the
    last one ended.

    \b
    Examples:
      masonry-cd assess examples/arch.toml -o out/arch_assess
      masonry-cd assess church.toml -o out/church_assess --workers 2
      masonry-cd assess church.toml -o out/church_assess --all-pairs
    """
    with errors_reported():
        from masonry_cd.app.scene import read_scene
        from masonry_cd.studies.assess.assess_case import assess_case, cost_in_words
        from masonry_cd.studies.assess.plan import AssessPlan
        from masonry_cd.studies.study.clusters import Where
        from masonry_cd.studies.study.study_case import Options

        if report:
            write_and_tell(output, quiet)
            return
        made = AssessPlan(read_scene(scene, set_ or ()), all_pairs)
        if plan:
            typer.echo(cost_in_words(made))
            return
        run = made.maker.study.tables.run
        options = Options(Where(None, None, workers, None, run.timeout + run.grace), retry, force, quiet=quiet, warn=warn)
        go_on = same_command()
        try:
            found = assess_case(made, output, options, lambda line: None if quiet else typer.echo(line, err=True))
        except Interrupted:
            typer.echo(go_on, err=True)
            raise
        if not found["stopped"]:
            write_and_tell(output, quiet)
    if found["stopped"]:
        typer.echo(f"masonry-cd: error: {found['stopped']}; finished runs are kept\n{go_on}", err=True)
        raise typer.Exit(1)


def write_and_tell(output: Path, quiet: bool) -> None:
    """Write what follows from the runs, and print the table and the verdict.

    Raises:
        InputError: the base case is no data.
    """
    from masonry_cd.analysis.assessment.verdict import lines_of, warnings_of
    from masonry_cd.foundation.errors import InputError
    from reports.assess.outputs import FILES, write_assessment
    from reports.assess.tables import text_table

    found = write_assessment(output)
    if not found.base.done:
        raise InputError("", lines_of(found)[0])
    if not quiet:
        typer.echo(f"{text_table(found)}\n\n" + "\n".join(lines_of(found)))
        typer.echo(f"results: {', '.join(str(output / name) for name in FILES)}")
    warn(warnings_of(found))
