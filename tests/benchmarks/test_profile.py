"""The profile of a scene: what it counts adds up, and nothing stays watched."""

from __future__ import annotations

from places import EXAMPLES

from benchmarks.profile import PHASES, profile, tables
from masonry_cd.dynamics import moreau_jean
from masonry_cd.solvers import admm, interior, newton, nlgs


def test_steps_phases_and_methods_are_counted() -> None:
    """Each step once; the phases are no longer than the steps, and the methods no longer than the phase that solves."""
    places = [(moreau_jean, name) for name in PHASES]
    places += [(admm, "run_by_team"), (newton, "linearised_bodies"), (interior, "linearised_bodies"), (nlgs, "nlgs_bodies")]
    before = [getattr(owner, name) for owner, name in places]
    found = profile(EXAMPLES / "arch.toml", ["run.duration=0.05"])
    assert [getattr(owner, name) for owner, name in places] == before
    assert len(found.seconds) == len(found.errors) == len(found.contacts) > 0
    assert set(found.phases) == set(PHASES)
    assert sum(each.iterations for each in found.methods.values()) > 0
    assert sum(each.seconds for each in found.methods.values()) <= found.phases["solve"] <= sum(found.seconds)
    assert all(each.moved > 0.0 for each in found.methods.values() if each.iterations)
    assert sum(line.startswith(("| predict", "| solve")) for line in tables(found)) == 2
