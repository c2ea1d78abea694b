# SPDX-License-Identifier: GPL-3.0-or-later
"""Text of the user is drawn as it stands, wherever it comes into a figure."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from places import ROOT

from masonry_cd.foundation.figures import blank

NAMES = ["$R_{$", "$a$", r"\frac{$^_$", "a_b^c", "100 $ and 200 $", r"$\nonsense$"]


@pytest.mark.parametrize("name", NAMES)
def test_text_of_the_user_is_no_formula(name: str) -> None:
    figure = blank((4.0, 3.0), layout="constrained")
    axes = figure.subplots()
    axes.plot([1.0, 2.0], [1.0, 2.0], label=name)
    axes.set(title=name, xlabel=name, ylabel=name)
    axes.set_yticks([1.0, 2.0], [name, name])
    axes.annotate(name, (1.0, 1.0))
    drawn = [axes.title, axes.xaxis.label, axes.yaxis.label, *axes.legend().get_texts(), *axes.texts]
    figure.suptitle(name)
    figure.savefig(io.BytesIO(), format="png")
    for text in [*drawn, *axes.get_yticklabels()]:
        assert (text.get_text(), text.get_parse_math()) == (name, False)


def test_powers_of_ten_of_an_axis_stay_formulas() -> None:
    figure = blank((4.0, 3.0))
    axes = figure.subplots()
    axes.loglog([1e-3, 1e3], [1e-3, 1e3])
    figure.savefig(io.BytesIO(), format="png")
    labels = [text for text in axes.get_xticklabels() if text.get_text()]
    assert labels and all(text.get_parse_math() for text in labels)


def test_every_figure_begins_there() -> None:
    """A figure made past it would take two dollar signs in a name for a formula, after the whole run."""
    makers = ("Figure(figsize", "FigureCanvasAgg(")
    files = [file for package in ("masonry_cd", "reports", "loads", "structures") for file in sorted((ROOT / package).rglob("*.py"))]
    named = [str(Path(file).relative_to(ROOT)) for file in files if any(maker in file.read_text(encoding="utf-8") for maker in makers)]
    assert named == ["masonry_cd/foundation/figures.py"]
