"""The command line ``masonry-cd``. Its own imports are light; each command imports what it needs.

Exit codes: 0 done, 1 the run could not go on, 2 bad input (one line says what and where), 128 + N stopped by the signal N: 130 by Ctrl-C,
143 by SIGTERM.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from masonry_cd import __version__
from masonry_cd.app.progress import Interrupted
from masonry_cd.cli import numerics
from masonry_cd.cli.shared import Changes, Folder, Force, Output, Quiet, SceneFile, free_folder, told

if TYPE_CHECKING:
    from masonry_cd.app.case import Case
    from structures.geometry.checks import Unsound

app = typer.Typer(
    name="masonry-cd",
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"masonry-cd {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.", callback=_print_version, is_eager=True)] = False,
) -> None:
    """Seismic analysis of block masonry by non-smooth contact dynamics: which joints open, what falls, at which shaking.

    \b
    A first run:
      masonry-cd run examples/arch.toml -o out/arch
      masonry-cd report out/arch
    """


@app.command()
def run(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    force: Force = False,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with a run that was stopped, from its last checkpoint.")] = False,
    dump_problem: Annotated[
        list[str] | None, typer.Option("--dump-problem", metavar="STEP", help="Write the friction problem of this step; 1 or 1,2,9.")
    ] = None,
    explain: Annotated[bool, typer.Option("--explain", help="Say what was left out for this scene, and why.")] = False,
    quiet: Quiet = False,
) -> None:
    """Compute a scene and write its results.

    DIR gets result.h5, joints.csv, summary.json, and the pictures that the scene asks for. The whole scene is checked first; bad input
    is told in one line, with exit code 2, and nothing is written. Ctrl-C, SIGTERM, SIGHUP and SIGQUIT end a run after its current step:
    the results stay readable up to there, and --resume goes on to the same numbers as an unbroken run, as it does after a kill. Problems
    are written to problem_STEP.npz, or where impacts are solved apart to problem_STEP_forces.npz and problem_STEP_impacts.npz, for
    masonry-cd solve and accuracy.

    \b
    Examples:
      masonry-cd run aqueduct.toml -o out/aqueduct
      masonry-cd run aqueduct.toml -o out/aqueduct --resume
      masonry-cd run aqueduct.toml -o out/strong --set loads[0].amplitude=0.4 --set run.duration=5
      masonry-cd run aqueduct.toml -o out/aqueduct --force --set run.solver=nlgs --set run.tolerance=1e-6
    """
    with told():
        free_folder(output, ("result.h5", "summary.json"), force or resume)
        from masonry_cd.app.scene import read_scene
        from masonry_cd.io import checkpoint

        if resume:
            checkpoint.require(output / checkpoint.NAME)

        asked = read_scene(scene, set_ or ())
        from masonry_cd.app import case  # numba and the kernels come with it, after the cheap checks
        from masonry_cd.app.dump import parse_steps

        steps = parse_steps(dump_problem or ())

        prepared = case.prepare(asked)
        if not quiet:
            _announce(prepared)
        go_on = f"masonry-cd: go on with: {_resuming(scene, output, set_ or ())}"
        try:
            summary = case.run_case(prepared, output, quiet, resume, steps)
        except Interrupted:
            typer.echo(go_on, err=True)
            raise
        with suppress(OSError) if summary["signal"] else nullcontext():  # the terminal may be what ended the run
            _tell_end(summary, output, quiet, explain)
            if summary["signal"]:
                typer.echo(go_on, err=True)
    if summary["stopped"]:
        raise typer.Exit(128 + summary["signal"] if summary["signal"] else 1)


def _tell_end(summary: dict[str, Any], output: Path, quiet: bool, explain: bool) -> None:
    """What a run has come to."""
    from masonry_cd.app import case

    if not quiet:
        typer.echo("\n".join(case.closing_lines(summary)))
        if explain:
            typer.echo("\n".join(["left out, and why:", *(f"- {line}" for line in summary["explanation"])]))
        written = (name for name in (*case.OUTPUTS, *summary["dumped"]) if (output / name).exists())
        typer.echo(f"results: {', '.join(str(output / name) for name in written)}")
    for line in summary["warnings"]:
        typer.echo(f"masonry-cd: warning: {line}", err=True)


def _resuming(scene: Path, output: Path, changes: Sequence[str]) -> str:
    """The command that goes on with a run."""
    return shlex.join(["masonry-cd", "run", str(scene), "-o", str(output), "--resume", *(word for c in changes for word in ("--set", c))])


@app.command()
def build(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    picture: Annotated[bool, typer.Option(help="Draw structure.png, or problem.png of blocks that are refused.")] = True,
    format_: Annotated[
        list[str] | None,
        typer.Option("--format", metavar="NAME", help="json, obj, stl, vtu, vtm or vtkhdf; as often as needed.", show_default="json"),
    ] = None,
    repair: Annotated[
        list[str] | None, typer.Option(metavar="WHAT", help="Of a file: shells, or gaps=0.002 [m] to close gaps up to that width.")
    ] = None,
    force: Force = False,
) -> None:
    """Build the structure of a scene alone.

    DIR gets blocks.json, which kind = "file" reads back, or the blocks in other formats, and structure.png. Where blocks are refused,
    problem.png shows which.

    \b
    Examples:
      masonry-cd build aqueduct.toml -o out/aqueduct
      masonry-cd build aqueduct.toml -o out/five --set structure.spans=5 --no-picture
      masonry-cd build scan.toml -o out/scan --repair shells --repair gaps=0.002
      masonry-cd build aqueduct.toml -o out/meshes --format obj --format vtkhdf
    """
    with told():
        formats = _formats(format_)
        free_folder(output, tuple(f"blocks.{name}" for name in formats), force)
        from masonry_cd.app.scene import read_scene

        asked = read_scene(scene, [*(set_ or ()), *_repairs(repair)])
        import structures
        from masonry_cd.app import case
        from structures import summary
        from structures.files import blockfile, meshfile
        from structures.geometry.checks import Unsound

        try:
            blocks, notes = case.build_structure(asked)
        except Unsound as fault:
            if picture:
                _draw_problem(fault, output)
            raise
        typer.echo("\n".join([*summary.lines(structures.report(blocks)), *notes]))
        output.mkdir(parents=True, exist_ok=True)
        written = [output / f"blocks.{name}" for name in formats]
        for path in written:
            (blockfile if path.suffix == ".json" else meshfile).write(path, blocks)
        if picture:
            from reports.drawing.structure_picture import structure_picture

            written.append(output / "structure.png")
            structure_picture(blocks, written[-1], asked.title)
        typer.echo(f"written: {', '.join(map(str, written))}")


def _formats(asked: list[str] | None) -> tuple[str, ...]:
    """The formats of blocks to write, each once."""
    from masonry_cd.errors import InputError

    known = ("json", "obj", "stl", "vtu", "vtm", "vtkhdf")
    for name in asked or ():
        if name not in known:
            raise InputError(f'--format: "{name}" is none; formats: {", ".join(known)}')
    return tuple(dict.fromkeys(asked or ("json",)))


def _repairs(asked: list[str] | None) -> list[str]:
    """What --repair changes in the scene."""
    from masonry_cd.errors import InputError

    changes = []
    for repair in asked or ():
        what, _, width = repair.partition("=")
        if what not in ("shells", "gaps") or (what == "gaps") != bool(width):
            raise InputError(f'--repair: "{repair}" is none; shells, or gaps=WIDTH with the widest gap to close [m]')
        changes.append("structure.repair=true" if what == "shells" else f"structure.gaps={width}")
    return changes


def _draw_problem(fault: Unsound, folder: Path) -> None:
    """Draw problem.png where the libraries for it are installed; the error itself is told in any case."""
    from masonry_cd.errors import InputError

    try:
        from reports.drawing.refused_blocks import problem_picture

        folder.mkdir(parents=True, exist_ok=True)
        problem_picture(fault.blocks, fault.faulty, str(fault), folder / "problem.png")
    except (ImportError, InputError) as failure:
        typer.echo(f"masonry-cd: warning: problem.png is not drawn: {failure}", err=True)
        return
    typer.echo(f"written: {folder / 'problem.png'}")


@app.command()
def report(
    folder: Folder,
    crack_map: Annotated[bool, typer.Option(help="Draw crack_map.png.")] = True,
    time: Annotated[float | None, typer.Option(metavar="SECONDS", help="Draw the frame next to this time; the last by default.")] = None,
    times: Annotated[str | None, typer.Option(metavar="T1,T2,...", help="Draw a map at each of these times, alike in scale.")] = None,
    view: Annotated[str | None, typer.Option(help="front, back, side, top or isometric; the scene's by default.")] = None,
    scale: Annotated[float | None, typer.Option(help="Amplification of displacements; the scene's by default.")] = None,
    cut: Annotated[str | None, typer.Option(metavar="PLANE", help="Cut by a plane, y=1.5 [m], or y for the middle.")] = None,
    thrust: Annotated[bool | None, typer.Option("--thrust/--no-thrust", help="Draw the line of thrust.", show_default=False)] = None,
    animation: Annotated[bool, typer.Option("--animation", help="Draw crack_map.gif, the whole run.")] = False,
    energy: Annotated[bool, typer.Option("--energy", help="Draw energy.png: what was put in, where it went, the balance.")] = False,
    html: Annotated[bool, typer.Option("--html", help="Write report.html, a page that shows the run and needs no network.")] = False,
    pdf: Annotated[bool, typer.Option("--pdf", help="Print that page to report.pdf, by Chromium where it is installed.")] = False,
) -> None:
    """Redo the reports of a run.

    Writes joints.csv, the damage by part (damage.csv, damage_history.csv, hinges.csv, drift.csv, damage.json) and crack_map.png anew from
    result.h5, also for a run that was stopped or killed. Thresholds and grades are those of the scene's [report].

    \b
    Examples:
      masonry-cd report out/aqueduct
      masonry-cd report out/aqueduct --time 3.5 --view isometric --scale 20
      masonry-cd report out/aqueduct --times 1,2,3 --cut y --thrust
      masonry-cd report out/aqueduct --html --no-crack-map
    """
    with told():
        from masonry_cd.io.results import Results
        from reports.settings import report_of

        with Results.open(folder / "result.h5") as results:
            from masonry_cd.app import case
            from reports import outputs
            from reports.damage import part_files

            settings = report_of(results.scene, view=view, scale=scale, cut=cut, thrust=thrust)
            outputs.check(settings, results)
            frame = outputs.frame_at(results, time)
            moments = outputs.parse_times(results, times) if times is not None else []
            summary = outputs.read_summary(folder) | case.write_damage(results, folder, settings)
            typer.echo(case.damage_line(summary))
            damage = outputs.damage_of(results, settings)
            typer.echo("\n".join(part_files.part_lines(damage.parts)))
            written = [folder / "joints.csv", *part_files.write_part_damage(damage, folder)]
            if crack_map:
                written.append(folder / "crack_map.png")
                outputs.draw_crack_map(results, written[-1], settings, frame)
            if moments:
                written += outputs.draw_times(results, folder, settings, moments)
            if animation:
                written.append(folder / outputs.ANIMATION)
                outputs.draw_animation(results, written[-1], settings)
            if energy:
                written.append(folder / outputs.ENERGY)
                outputs.draw_energy(results, written[-1])
            if html or pdf:
                written.append(folder / outputs.PAGE)
                outputs.write_page(results, written[-1], settings, summary, damage)
            if pdf:
                written.append(folder / outputs.PRINT)
                outputs.write_pdf(folder / outputs.PAGE, written[-1])
        typer.echo(f"written: {', '.join(map(str, written))}")


@app.command()
def export(
    folder: Folder,
    format_: Annotated[str, typer.Option("--format", metavar="NAME", help="vtkhdf, or pvd for older readers.")] = "vtkhdf",
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="OUT", help="Folder for the files.", show_default="DIR/paraview")
    ] = None,
) -> None:
    """Write a run for ParaView: blocks and joints over time.

    OUT gets blocks and joints as VTKHDF, or as PVD collections of VTP files, with openings, slidings, forces, states and displacements,
    and names.csv, which tells the names of blocks and groups by their numbers.

    \b
    Examples:
      masonry-cd export out/aqueduct
      masonry-cd export out/aqueduct --format pvd -o out/view
    """
    with told():
        from masonry_cd.io.results import Results
        from reports.settings import report_of

        with Results.open(folder / "result.h5") as results:
            from reports import outputs, paraview

            thresholds = outputs.thresholds_of(report_of(results.scene))
            written = paraview.export(results, output or folder / "paraview", format_, thresholds)
        typer.echo(f"written: {', '.join(map(str, written))}")


@app.command()
def compare(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR1 DIR2 ...", help="Folders of runs.", show_default=False)],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="OUT", help="Write comparison.csv, .md and .png there.", show_default=False)
    ] = None,
) -> None:
    """Lay runs side by side: what differs in their scenes, their damage and their response.

    Prints a table; with -o it is written as CSV and Markdown, with a picture. Damage is judged by the thresholds of the first run.

    \b
    Examples:
      masonry-cd compare out/weak out/strong
      masonry-cd compare out/mu0.5 out/mu0.6 out/mu0.7 -o out/friction
    """
    with told():
        from reports.compare import comparison as comparing

        found = comparing.compare(folders)
        typer.echo(comparing.markdown(found), nl=False)
        if output is not None:
            typer.echo(f"written: {', '.join(map(str, comparing.write_comparison(found, output)))}")


@app.command()
def record(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Record of accelerations.", show_default=False)],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="PNG", help="Picture to draw.", show_default=False)],
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help='A key of [[loads]] kind = "record": units=g, window=[5,17].')
    ] = None,
) -> None:
    """Draw a record: acceleration, velocity, displacement and response spectrum, before and after its correction.

    \b
    Examples:
      masonry-cd record elcentro.AT2 -o elcentro.png
      masonry-cd record aqv.csv -o aqv.png --set column=ns_m_s2 --set window=[5.0,17.0]
    """
    with told():
        from loads.picture import file_picture
        from masonry_cd.app.scene_text import parse_change
        from masonry_cd.errors import InputError

        if not file.exists():
            raise InputError(f"{file}: no such record")
        file_picture(file, output, **dict(parse_change(change) for change in set_ or ()))
        typer.echo(f"written: {output}")


app.command()(numerics.modal)
app.command()(numerics.solve)
app.command()(numerics.accuracy)


def _announce(prepared: Case) -> None:
    """What is about to be computed."""
    settings = prepared.scene.run
    joints = f"{prepared.assembly.count} blocks, {prepared.joints.count} joints"
    typer.echo(f"{prepared.scene.title}: {joints}, {settings.steps} steps of {settings.dt:g} s, solver {settings.solver}")
    for line in (*prepared.notes, *prepared.loading.lines, *(f"warning: {line}" for line in prepared.warnings)):
        typer.echo(line)
