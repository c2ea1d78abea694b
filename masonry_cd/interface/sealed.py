# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of the interface take no attributes that they do not know: ``sim.friction = 0.2`` would be kept, and change nothing."""

from __future__ import annotations

import inspect
from typing import Any

from masonry_cd.foundation.errors import suggest


class Sealed:
    """Refuses attributes that would change nothing.

    Settable are properties that have a setter, private names, and once, by its constructor, what a class declares by an annotation.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        """Set an attribute.

        Raises:
            AttributeError: it would change nothing.
        """
        kind = type(self)
        if not (name.startswith("_") or name in _settable(kind) or (name in _declared(kind) and name not in vars(self))):
            known, able = hasattr(kind, name) or name in _declared(kind), sorted(_settable(kind))
            why = "is only read" if known else f"is not an attribute{suggest(name, able)}"
            can = f"; what can be set: {', '.join(able)}" if able else ""
            raise AttributeError(
                f'{kind.__name__}: "{name}" {why}, setting it would change nothing{can}; '
                'keys of a scene are changed by mc.scene(source, "key=value") before it is computed',
                name=name,
                obj=self,
            )
        super().__setattr__(name, value)


def _settable(kind: type) -> frozenset[str]:
    """Properties with a setter."""
    return frozenset(name for name, found in inspect.getmembers_static(kind) if isinstance(found, property) and found.fset is not None)


def _declared(kind: type) -> frozenset[str]:
    """Names that a class and its bases annotate."""
    return frozenset(name for base in kind.__mro__ for name in vars(base).get("__annotations__", ()))
