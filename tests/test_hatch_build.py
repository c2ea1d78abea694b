# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheel that brings compiled kernels: what goes into it, and what it is named for."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from places import ROOT


@pytest.fixture
def hook(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The hook, without the build system, which is there only while a wheel is made."""
    interface = ModuleType("hatchling.builders.hooks.plugin.interface")
    interface.BuildHookInterface = object  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, interface.__name__, interface)
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.KernelHook()


def asked(hook: Any, version: str = "standard") -> dict[str, Any]:
    data: dict[str, Any] = {"pure_python": True, "force_include": {}}
    hook.initialize(version, data)
    return data


def test_without_kernels_the_wheel_is_pure(hook, monkeypatch):
    monkeypatch.delenv("MASONRY_CD_KERNELS", raising=False)
    assert asked(hook) == {"pure_python": True, "force_include": {}}


def test_with_kernels_the_wheel_is_for_this_python_and_linux(hook, monkeypatch, tmp_path: Path):
    for name in ("a.nbc", "b.nbc", "b.nbc.17.part"):
        (tmp_path / name).touch()
    monkeypatch.setenv("MASONRY_CD_KERNELS", str(tmp_path))
    python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    data = asked(hook)
    assert data["tag"] == f"{python}-{python}-manylinux_2_28_x86_64" and not data["pure_python"]
    assert sorted(data["force_include"].values()) == ["masonry_cd/compiled/a.nbc", "masonry_cd/compiled/b.nbc"]
    assert asked(hook, "editable")["pure_python"]


def test_a_folder_without_kernels_is_refused(hook, monkeypatch, tmp_path: Path):
    monkeypatch.setenv("MASONRY_CD_KERNELS", str(tmp_path))
    with pytest.raises(FileNotFoundError, match="holds no compiled kernels"):
        asked(hook)
