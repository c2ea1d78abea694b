# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of matplotlib, all of them begun here: text of the user, whatever signs it has, is drawn as it stands."""

from __future__ import annotations

from functools import cache
from typing import Any

from masonry_cd.foundation.extras import require

POWERS = r"$\mathdefault{"  # with which matplotlib itself begins the labels of logarithmic axes


def blank(size: tuple[float, float], dpi: int = 100, **look: Any) -> Any:
    """An empty figure, white, of a size [inches]; a ``$`` in its texts begins no formula.

    Raises:
        InputError: matplotlib is not installed.
    """
    require("a plot", "matplotlib")
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = _plain_figure()(figsize=size, dpi=dpi, facecolor="white", **look)
    FigureCanvasAgg(figure)
    return figure


@cache
def _plain_figure() -> Any:
    """The class of these figures, which is made once matplotlib is needed."""
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    class PlainFigure(Figure):
        """A figure that draws text as it stands, titles, legends and labels of ticks included."""

        def draw(self, renderer: Any) -> None:
            for axes in self.axes:
                for axis in (axes.xaxis, axes.yaxis):
                    axis.get_ticklabels(which="both")  # which makes them, before they are looked at
            for text in self.findobj(Text):
                text.set_parse_math(text.get_text().startswith(POWERS))  # type: ignore[attr-defined, unused-ignore]
            super().draw(renderer)

    return PlainFigure
