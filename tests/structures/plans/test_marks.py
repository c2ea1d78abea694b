# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of surveys, English and Italian, mean what docs/howto/plans.md says."""

from __future__ import annotations

import pytest

from structures.plans import marks


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("h=2.10 s=0.90", {"height": 2.1, "sill": 0.9}),
        ("H 2,10", {"height": 2.1}),
        ("h. 210 dav. 90", {"height": 2.1, "sill": 0.9}),
        ("altezza 8,50 m", {"height": 8.5}),
        ("h=2100 mm", {"height": 2.1}),
        ("H2100", {"height": 2.1}),
        ("h 15", {"height": 15.0}),
        ("q. +8.50", {"level": 8.5}),
        ("+7,20", {"level": 7.2}),
        ("imp. 4.50 f=1,20 sp. 25", {"springing": 4.5, "rise": 1.2, "thickness": 0.25}),
        ("profondità 30 ghiera 25", {"depth": 0.3, "ring": 0.25}),
        ("rosone l=1.60 s=5.60", {"width": 1.6, "sill": 5.6}),
        ("base 0.5 h=3", {"base": 0.5, "height": 3.0}),
    ],
)
def test_numbers_of_a_text(text: str, numbers: dict[str, float]):
    assert marks.read(text).numbers == numbers


def test_a_pair_a_profile_and_words():
    assert marks.read("210/90").pair == (2.1, 0.9)
    gable = marks.read("FACCIATA OVEST h=7.5/9.8/7.5")
    assert (gable.profile, gable.name) == ((7.5, 9.8, 7.5), "facciata_ovest")
    arch = marks.read("portale tutto sesto h=3.60")
    assert (arch.shape, arch.name, arch.is_of_opening) == ("round", "portale", True)
    assert [marks.read(text).vault for text in ("volta a crociera", "botte", "padiglione", "cupola")] == [
        "cross",
        "barrel",
        "domical",
        "dome",
    ]
    assert [marks.read(text).kind for text in ("FINESTRA_2", "Door 90", "sala")] == ["window", "door", ""]


@pytest.mark.parametrize("text", ["", "SALA 1", "see note 4", "1:100", "A-A'"])
def test_other_texts_mean_nothing(text: str):
    assert marks.read(text).means_nothing
