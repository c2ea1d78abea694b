# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd modal``: the modal companions, and the frequencies of a run on elastic joints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result
from masonry_cd.cli.shared import Changes, Force, Output, SceneFile, Trust
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import finite_number


def modal(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    young: Annotated[
        list[str] | None,
        typer.Option(metavar="E", help='Modulus [Pa], 3e9 or "3 GPa", or by group of blocks: pier=4e9, default=2e9.'),
    ] = None,
    poisson: Annotated[float, typer.Option(metavar="NU", help="Poisson's ratio.")] = 0.2,
    method: Annotated[str, typer.Option(metavar="NAME", help="continuum, joints or both.")] = "both",
    modes: Annotated[int, typer.Option(metavar="N", help="Modes to compute.")] = 6,
    mesh_size: Annotated[float | None, typer.Option(metavar="H", help="Size of the tetrahedra [m].", show_default="thickness")] = None,
    restraint: Annotated[
        list[str] | None, typer.Option(metavar="GROUP=DIRECTIONS", help="Directions in which supports hold: pier1=z.")
    ] = None,
    reference: Annotated[Path | None, typer.Option(metavar="CSV", help="Measured modes to compare with.")] = None,
    ambient: Annotated[
        Path | None,
        typer.Option(metavar="CSV", help="Accelerations under ambient vibration, from which the measured modes are identified."),
    ] = None,
    sensors: Annotated[Path | None, typer.Option(metavar="CSV", help="Positions of the sensors of --ambient.")] = None,
    lowest: Annotated[
        float | None, typer.Option(metavar="F", help="Lowest frequency of --ambient [Hz].", show_default="1/50 of the highest")
    ] = None,
    highest: Annotated[
        float | None, typer.Option(metavar="F", help="Highest frequency of --ambient [Hz].", show_default="0.4 of the rate")
    ] = None,
    fit: Annotated[bool, typer.Option("--fit", help="Fit E to the first measured frequency.")] = False,
    pictures: Annotated[int, typer.Option(metavar="N", help="Modes to draw.")] = 6,
    nscd: Annotated[bool, typer.Option("--nscd", help="Measure the frequencies of a run on the scene's elastic joints instead.")] = False,
    sweep: Annotated[
        str | None, typer.Option(metavar="x|y|z", help="With --nscd: amplitude over frequency, with the base driven along this axis.")
    ] = None,
    velocity: Annotated[
        float | None, typer.Option(metavar="C", help="Velocity amplitude of the sweep [m/s].", show_default="1/1000 g")
    ] = None,
    force: Force = False,
    trust: Trust = False,
) -> Result[Any]:
    """Compute modal frequencies of the blocks of a scene: as a bonded elastic continuum, and as rigid blocks on elastic joints.

    Rigid blocks with unilateral contacts have no elastic frequency; these two models represent the structure before it cracks. A run on
    elastic joints has its own frequencies: --nscd measures them in free vibration, or in a sweep with v(t) = C sin(2 pi f t), and compares
    them with its linear modes.

    \b
    Examples:
      masonry-cd modal aqueduct.toml -o out/modal --young 3e9
      masonry-cd modal church.toml -o out/modal --reference measured.csv --fit
      masonry-cd modal tower.toml -o out/modal --ambient night.csv --sensors sensors.csv --lowest 0.5 --highest 12 --fit
      masonry-cd modal mortar.toml -o out/modal --nscd --sweep x
    """
    from masonry_cd.app.scene import read_scene

    asked = read_scene(scene, set_ or ())
    given = {
        "young": by_group(young, "young") if young else None, "mesh_size": mesh_size, "reference": reference, "ambient": ambient,
        "sensors": sensors, "lowest": lowest, "highest": highest, "fit": fit or None,
        "restraint": by_group(restraint, "restraint") if restraint else None,
    }  # fmt: skip
    given = {key: value for key, value in given.items() if value is not None}
    if nscd or sweep:
        from masonry_cd.studies.vibration import vibration

        return vibration(asked, {"modes": modes, "sweep": sweep, "velocity": velocity, **given}, output, force)
    from masonry_cd.app.commands.modal import modal as command

    given |= {} if velocity is None else {"velocity": velocity}  # refused: only a sweep has one
    return command(asked, {"poisson": poisson, "method": method, "modes": modes, "pictures": pictures, **given}, output, force)


def by_group(texts: Sequence[str], key: str) -> float | str | dict[str, float | str]:
    """Parse what the command line gives for one value, ``3e9`` or "3 GPa", or for several groups, ``pier=4e9 default=2e9``.

    Raises:
        InputError: several values of which one names no group.
    """
    pairs = [text.partition("=") for text in texts]
    if len(pairs) == 1 and not pairs[0][1]:
        return _number_or_text(pairs[0][0])
    wrong = next((text for text, (group, equals, value) in zip(texts, pairs, strict=True) if not (group and equals and value)), None)
    if wrong is not None:
        raise InputError(f"modal.{key}", f"write one value, or GROUP=VALUE for each group, got {wrong!r}")
    return {group: _number_or_text(value) for group, _, value in pairs}


def _number_or_text(text: str) -> float | str:
    """A number, or what may be one with a unit."""
    number = finite_number(text)
    return text if number is None else number
