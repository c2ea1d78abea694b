# SPDX-License-Identifier: GPL-3.0-or-later
"""Seismic analysis of block masonry by non-smooth contact dynamics (Moreau-Jean).

    import masonry_cd as mc

    run = mc.run("arch.toml")
    run.parts, run.joints, run.plot.crack_map()

What there is says docs/python.md. Nothing is imported before its first use: a name of ``NAMES`` comes from the package ``interface``, or
from where the program itself keeps it. Type checkers and editors read ``__init__.pyi``. There is no import statement for the names here:
every module imports this one, so that all kernels would be stamped by the sources of the interface (:mod:`masonry_cd.foundation.jit`).
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "1.0.0rc1"

NAMES = {
    "Assessment": "masonry_cd.interface.assessing:Assessment",
    "Block": "masonry_cd.mechanics.model.blocks:Block",
    "Calibration": "masonry_cd.interface.calibrating:Calibration",
    "Comparison": "masonry_cd.interface.comparison:Comparison",
    "Force": "masonry_cd.interface.own_forces:Force",
    "Hazard": "masonry_cd.interface.hazard:Hazard",
    "InputError": "masonry_cd.foundation.errors:InputError",
    "JointLaw": "masonry_cd.interface.joint_law:JointLaw",
    "LimitAnalysis": "masonry_cd.interface.limit:LimitAnalysis",
    "Motion": "masonry_cd.interface.own_motions:Motion",
    "Run": "masonry_cd.interface.results:Run",
    "RunWarning": "masonry_cd.interface.returned:RunWarning",
    "Scene": "masonry_cd.interface.scenes:Scene",
    "Simulation": "masonry_cd.interface.simulation:Simulation",
    "Spectrum": "masonry_cd.interface.site_spectrum:Spectrum",
    "Structure": "masonry_cd.interface.structure:Structure",
    "Strengthening": "masonry_cd.interface.strengthening:Strengthening",
    "Study": "masonry_cd.interface.studies:Study",
    "assess": "masonry_cd.interface.assessing:assess",
    "box": "structures.geometry.prism:box",
    "calibrate": "masonry_cd.interface.calibrating:calibrate",
    "compare": "masonry_cd.interface.comparison:compare",
    "from_compas": "masonry_cd.interface.compas:from_compas",
    "from_compas_dem": "masonry_cd.interface.compas_dem:from_compas_dem",
    "from_traces": "masonry_cd.interface.traces:from_traces",
    "limit_analysis": "masonry_cd.interface.limit:limit_analysis",
    "macro_elements": "masonry_cd.interface.limit:macro_elements",
    "modal": "masonry_cd.interface.modal:modal",
    "open": "masonry_cd.interface.results:open_run",
    "open_study": "masonry_cd.interface.studies:open_study",
    "plugins": "masonry_cd.foundation.plugins:plugins",
    "resume": "masonry_cd.interface.running:resume",
    "risk_sheet": "masonry_cd.interface.risk:risk_sheet",
    "run": "masonry_cd.interface.running:run",
    "scene": "masonry_cd.interface.scenes:scene",
    "select_records": "masonry_cd.interface.selecting:select_records",
    "strengthen": "masonry_cd.interface.strengthening:strengthen",
    "study": "masonry_cd.interface.studies:study",
    "to_compas_dem": "masonry_cd.interface.compas_dem:to_compas_dem",
    "trust": "masonry_cd.foundation.trust:trust",
}

__all__ = [*NAMES]


def __getattr__(name: str) -> Any:
    """A name of the interface, imported now."""
    if name not in NAMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import_module("masonry_cd.foundation.own_packages").require_own_packages()
    module, _, attribute = NAMES[name].partition(":")
    globals()[name] = found = getattr(import_module(module), attribute)
    return found


def __dir__() -> list[str]:
    """Return the names of the package, for completion."""
    return sorted({*globals(), *NAMES})
