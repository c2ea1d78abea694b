# SPDX-License-Identifier: GPL-3.0-or-later
"""The site is built without a warning, asks no other server for anything, and its generated pages are those of the program."""

from __future__ import annotations

import json
import logging
import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import pytest
from test_docs import DOCS, loaded

CONFIG = DOCS / "site" / "mkdocs.yml"
LOADS = {"script": "src", "link": "href", "img": "src", "iframe": "src", "source": "src", "video": "src", "object": "data"}
LARGEST = 150_000  # of a picture of the gallery [bytes]


class Warnings(logging.Handler):
    """Warnings of the build."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())


class Resources(HTMLParser):
    """Addresses that a browser fetches by itself when it opens a page, and the tags of formulas."""

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if address := dict(attrs).get(LOADS.get(tag, "")):
            self.fetched.append(address)


def read(page: Path) -> Resources:
    parser = Resources()
    parser.feed(page.read_text(encoding="utf-8"))
    return parser


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, list[str]]]:
    """The site, and what the build warned of."""
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    folder, warnings = tmp_path_factory.mktemp("site"), Warnings()
    logger, before = logging.getLogger("mkdocs"), list(sys.path)
    logger.addHandler(warnings)
    config = load_config(str(CONFIG), site_dir=str(folder))
    config.plugins.on_startup(command="build", dirty=False)
    try:
        build(config)
    finally:
        config.plugins.on_shutdown()
        logger.removeHandler(warnings)
        sys.path[:] = before
    yield folder, warnings.lines


@pytest.mark.slow(reason="builds the whole site")
def test_the_site_is_built_without_a_warning(built: tuple[Path, list[str]]) -> None:
    folder, warnings = built
    assert warnings == []
    for page in DOCS.rglob("*.md"):
        assert (folder / page.relative_to(DOCS).with_suffix(".html")).is_file(), page
    assert {"contributing.html", "changelog.html", "benchmarks.html"} <= {path.name for path in folder.glob("*.html")}


@pytest.mark.slow(reason="builds the whole site")
def test_no_page_asks_another_server_for_anything(built: tuple[Path, list[str]]) -> None:
    folder, _ = built
    for page in folder.rglob("*.html"):
        fetched = read(page).fetched
        assert [address for address in fetched if re.match(r"(\w+:)?//", address)] == [], page
        if page.name != "404.html":  # its addresses begin at the root of a server
            here = [address.split("?")[0].split("#")[0] for address in fetched if not address.startswith("data:")]
            assert [address for address in here if not (page.parent / address).exists()] == [], page
    styles = "".join(path.read_text(encoding="utf-8") for path in folder.rglob("*.css"))
    assert re.findall(r"(?:url\(|@import )[\"']?(?:https?:)?//[^)\"']*", styles) == []


@pytest.mark.slow(reason="builds the whole site")
def test_formulas_are_mathml(built: tuple[Path, list[str]]) -> None:
    page = built[0] / "theory.html"
    text = page.read_text(encoding="utf-8")
    inline = len(
        re.findall(r"(?<!\$)\$[^$\n]+\$", re.sub(r"^```.*?^```$", "", (DOCS / "theory.md").read_text(), flags=re.DOTALL | re.MULTILINE))
    )
    assert read(page).tags.count("math") >= inline > 100
    assert 'class="arithmatex"' not in text
    assert "\\frac" not in text


def test_a_formula_that_cannot_be_drawn_is_refused() -> None:
    hooks = loaded(DOCS / "site" / "hooks.py", "site_hooks")
    assert "<mfrac>" in hooks.mathml(r"\frac{a}{b}", "inline")
    with pytest.raises(ValueError, match=r"\\nosuchcommand"):
        hooks.mathml(r"a \nosuchcommand b", "inline")


def test_links_lead_to_where_the_site_has_its_files() -> None:
    hooks = loaded(DOCS / "site" / "hooks.py", "site_hooks")

    def moved(link: str, place: str) -> str:
        return hooks.LINK.sub(lambda found: hooks.link_on_site(found, place.removeprefix("docs/"), place), link)

    assert moved("[a](../CONTRIBUTING.md#tests)", "docs/validation.md") == "[a](contributing.md#tests)"
    assert moved("[a](../../README.md)", "docs/howto/buildings.md") == "[a](../index.md)"
    assert moved("[a](accuracy.toml), [b](../tests)", "docs/accuracy.md") == "a, b"
    assert moved("[a](nowhere.md) [b](https://elsewhere)", "docs/index.md") == "[a](nowhere.md) [b](https://elsewhere)"


def test_the_reference_of_commands_is_what_is_generated() -> None:
    reference = loaded(DOCS / "write_command_reference.py", "write_command_reference")
    assert reference.PAGE.read_text(encoding="utf-8") == reference.page(), "python docs/write_command_reference.py"


def test_the_reference_of_python_is_what_is_generated() -> None:
    made = loaded(DOCS / "write_python_reference.py", "write_python_reference")
    assert made.PAGE.read_text(encoding="utf-8") == made.reference(), "python docs/write_python_reference.py"
    assert [name for name in made.mc.NAMES if f"mc.{name}" not in made.reference()] == []


def test_the_gallery_shows_every_example() -> None:
    gallery = loaded(DOCS / "draw_gallery.py", "draw_gallery")
    measured = json.loads(gallery.MEASURED.read_text())
    assert gallery.PAGE.read_text(encoding="utf-8") == gallery.page(measured), "python docs/draw_gallery.py --page"
    names = set(gallery.examples())
    assert set(measured) <= names
    assert [name for name in sorted(names - set(measured)) if not gallery.missing(name)] == [], "python docs/draw_gallery.py --only NAME"
    pictures = {path.stem: path.stat().st_size for path in gallery.FOLDER.glob("*.png")}
    assert set(pictures) == set(measured)
    assert {name: size for name, size in pictures.items() if size > LARGEST} == {}
