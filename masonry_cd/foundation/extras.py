# SPDX-License-Identifier: GPL-3.0-or-later
"""Libraries that only some scenes and commands need, each in an extra of the package; a plain install runs and reports numbers."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from masonry_cd.foundation.errors import InputError


EXTRA_OF = {
    "pyvista": "pictures",
    "vtkmodules": "pictures",
    "matplotlib": "pictures",
    "PIL": "pictures",
    "trimesh": "cad",
    "meshio": "cad",
    "ezdxf": "cad",
    "clarabel": "limit",
    "skfem": "modal",
    "cvxopt": "modal",
    "distributed": "studies",
    "dask": "studies",
    "pyarrow": "studies",
    "sklearn": "studies",
    "pandas": "tables",
    "xarray": "tables",
    "obspy": "records",
    "ifcopenshell": "ifc",
    "pyoma2": "oma",
    "dask_jobqueue": "slurm",
}
SOLD_AS = {
    "PIL": "Pillow",
    "skfem": "scikit-fem",
    "sklearn": "scikit-learn",
    "vtkmodules": "VTK",
    "dask_jobqueue": "dask-jobqueue",
    "pyoma2": "pyOMA-2",
}  # packages of another name


def has(extra: str) -> bool:
    """Return True if all libraries of an extra are installed."""
    return all(find_spec(module) is not None for module, brings in EXTRA_OF.items() if brings == extra)


def require(what: str, *modules: str, without: str = "") -> None:
    """Check that libraries are installed before anything takes its time.

    Args:
        what: needs them, as the message begins.
        modules: by the name that is imported, of ``EXTRA_OF``, or one that a plug-in needs.
        without: how to go without them, at the end of the message.

    Raises:
        InputError: one is not, and how to install it.
    """
    for module in modules:
        if find_spec(module) is None:
            from masonry_cd.foundation.errors import InputError  # readers in a child process do without

            raise InputError("", _line(what, module) + without)


def missing(failure: ModuleNotFoundError) -> InputError | None:
    """Return the message on a module that is not installed; None of one that no extra brings: that is a fault."""
    from masonry_cd.foundation.errors import InputError

    module = (failure.name or "").partition(".")[0]
    return InputError("", _line("this", module)) if module in EXTRA_OF else None


def _line(what: str, module: str) -> str:
    package = f"masonry-cd[{EXTRA_OF[module]}]" if module in EXTRA_OF else module  # of a plug-in, a library of its own
    return f'{what} needs {SOLD_AS.get(module, module)}, which is not installed: pip install "{package}"'
