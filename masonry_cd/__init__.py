"""Seismic analysis of block masonry by non-smooth contact dynamics (Moreau-Jean).

    import masonry_cd as mc

    run = mc.run("arch.toml")
    run.parts, run.joints, run.plot.crack_map()

What there is says docs/python.md. Nothing is imported before it is asked for: a name of ``NAMES`` comes from the room ``interface``, or
from where the program itself keeps it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"

NAMES = {
    "Block": "masonry_cd.model.blocks:Block",
    "Comparison": "masonry_cd.interface.comparison:Comparison",
    "InputError": "masonry_cd.errors:InputError",
    "Run": "masonry_cd.interface.results:Run",
    "RunWarning": "masonry_cd.interface.running:RunWarning",
    "Scene": "masonry_cd.interface.scenes:Scene",
    "Structure": "masonry_cd.interface.structure:Structure",
    "box": "structures.geometry.prism:box",
    "compare": "masonry_cd.interface.comparison:compare",
    "modal": "masonry_cd.interface.modal:modal",
    "open": "masonry_cd.interface.results:open_run",
    "resume": "masonry_cd.interface.running:resume",
    "run": "masonry_cd.interface.running:run",
    "scene": "masonry_cd.interface.scenes:scene",
}

if TYPE_CHECKING:
    from masonry_cd.errors import InputError as InputError
    from masonry_cd.interface.comparison import Comparison as Comparison
    from masonry_cd.interface.comparison import compare as compare
    from masonry_cd.interface.modal import modal as modal
    from masonry_cd.interface.results import Run as Run
    from masonry_cd.interface.results import open_run as open
    from masonry_cd.interface.running import RunWarning as RunWarning
    from masonry_cd.interface.running import resume as resume
    from masonry_cd.interface.running import run as run
    from masonry_cd.interface.scenes import Scene as Scene
    from masonry_cd.interface.scenes import scene as scene
    from masonry_cd.interface.structure import Structure as Structure
    from masonry_cd.model.blocks import Block as Block
    from structures.geometry.prism import box as box

    __all__ = [
        "Block", "Comparison", "InputError", "Run", "RunWarning", "Scene", "Structure", "box", "compare", "modal", "open", "resume", "run",
        "scene",
    ]  # fmt: skip
else:
    __all__ = [*NAMES]

    def __getattr__(name):
        """A name of the interface, imported now."""
        if name not in NAMES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        import_module("masonry_cd.rooms").require_own_rooms()
        module, _, attribute = NAMES[name].partition(":")
        globals()[name] = found = getattr(import_module(module), attribute)
        return found

    def __dir__():
        """What there is, for completion."""
        return sorted({*globals(), *NAMES})
