# SPDX-License-Identifier: GPL-3.0-or-later
"""The page: it needs nothing from outside, fits its limit, and a real browser shows, plays and links what the result holds."""

from __future__ import annotations

import json
import re
from pathlib import Path

import browser as browsers
import numpy as np
import pytest
from command_line import masonry_cd
from hostile import refused_at
from made_run import at_rest, box, shifted, turned, write_run

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.deformed import Pose, solids_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import Solver
from masonry_cd.mechanics.model.state import rotation_matrices
from reports.drawing.palette import OPENING, SLIDING
from reports.drawing.parts import Scale
from reports.page import motion, series, write_page
from reports.page.pack import packed, packed_length

HINGE, SLIP = 0.4, 0.007  # of the middle block about its edge [degrees], of the upper one [m]
ADDRESS = re.compile(r"//|\bsrc=|@import|\burl\(")


def pillar() -> list:
    """Three blocks on a base, and a fourth next to them that will fall."""
    return [
        box("base", (-1, 0, -0.5), (3, 1, 0), "base", fixed=True),
        box("lower", (0, 0, 0), (1, 1, 1), "pillar"),
        box("middle", (0, 0, 1), (1, 1, 2), "pillar"),
        box("upper", (0, 0, 2), (1, 1, 3), "pillar"),
        box("loose", (1.5, 0, 0), (2, 1, 0.5), "loose"),
    ]


def pillar_states(frames: int = 11) -> list:
    """The middle block hinges about its right edge and carries the upper one, which slips; the loose one falls off, the base shakes."""
    out, rest = [], at_rest(pillar())
    for part in np.linspace(0.0, 1.0, frames):
        state = turned(turned(rest, 2, (1, 0, 1), HINGE * part), 3, (1, 0, 1), HINGE * part)
        along = np.radians(HINGE * part)
        state = shifted(state, 3, SLIP * part * np.array([np.cos(along), 0, -np.sin(along)]))
        state = turned(state, 4, (1.75, 0, 0.25), 80.0 * part, (0.3, 1.0, 0.0))
        state = shifted(shifted(state, 4, (1.5 * part, 0, -2 * part**2)), slice(None), (0.05 * np.sin(6 * part), 0, 0))
        state.velocity[:, 0] = 0.3 * np.cos(6 * part)
        out.append(state)
    return out


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run's folder with the page of the pillar."""
    out = tmp_path_factory.mktemp("page")
    with Results.open(write_run(out / "result.h5", pillar(), pillar_states(), "A pillar")) as results:
        write_page(results, out / "report.html", Summary(steps=10, solver=Solver(tolerance=1e-8)))
    return out


@pytest.fixture(scope="module")
def window(folder: Path, tmp_path_factory: pytest.TempPathFactory):
    """A browser that has opened the page."""
    if browsers.missing():
        pytest.skip(browsers.missing())
    with browsers.browser(tmp_path_factory.mktemp("browser")) as found:
        found.open(folder / "report.html")
        yield found
        assert found.complaints() == []


@pytest.fixture
def page(window: browsers.Browser, folder: Path):
    """The page as it is when it opens; whatever a test does must leave the console silent."""
    window.open(folder / "report.html")
    yield window
    assert window.complaints() == []


def test_the_file_names_no_outside_address(folder):
    assert not ADDRESS.search((folder / "report.html").read_text(encoding="utf-8"))


def test_joints_are_coloured_by_the_peaks_of_all_steps_and_blocks_unlike_them(folder):
    """The peaks are sent next to the frames; the colours of watched blocks are none of the curves' blue and orange."""
    text = (folder / "report.html").read_text(encoding="utf-8")
    facts = json.loads(re.search(r'<script type="application/json" id="facts-data">(.*?)</script>', text, re.DOTALL).group(1))
    names = json.dumps(facts["contents"])
    assert "opening_peak" in names
    assert "sliding_peak" in names
    watched = re.search(r"const WATCHED = \[(.*?)\]", text).group(1)
    scales = {colour for scale in facts["scales"].values() for colour in scale["colours"]}
    assert not scales & set(re.findall(r"#\w{6}", watched))


def test_what_a_title_holds_stays_text(tmp_path):
    title = "</script><script>alert(1)</script> http://example.org <!--"
    with Results.open(write_run(tmp_path / "result.h5", pillar(), pillar_states(2), title)) as results:
        write_page(results, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert not ADDRESS.search(text)
    assert text.count("</script>") == 3 and "<script>alert" not in text


def test_frames_are_left_out_to_keep_the_limit(tmp_path):
    rng, rest, states = np.random.default_rng(1), at_rest(pillar()), []
    for _ in range(200):
        states.append(shifted(rest, slice(1, None), rng.normal(0, 1e-3, (4, 3))))
    with Results.open(write_run(tmp_path / "result.h5", pillar(), states)) as results:
        write_page(results, tmp_path / "all.html")
        write_page(results, tmp_path / "few.html", limit=8000)
    texts = [(tmp_path / name).read_text(encoding="utf-8") for name in ("all.html", "few.html")]
    frames = [int(re.search(r'"frames":(\d+),"frames_written":200', text).group(1)) for text in texts]
    assert frames[0] == 200 and 20 < frames[1] < 180
    sizes = [len(re.search(r'id="packed-data">([^<]*)<', text).group(1)) for text in texts]
    assert sizes[0] > 8000 > 0.95 * sizes[1]


def test_frames_shown_keep_the_first_and_the_last():
    assert motion.frames_shown(7, 100).tolist() == list(range(7))
    some = motion.frames_shown(1000, 30)
    assert len(some) == 30 and some[0] == 0 and some[-1] == 999 and np.ptp(np.diff(some)) <= 1


def test_the_length_is_judged_before_packing():
    rng = np.random.default_rng(2)
    histories = {"u": rng.integers(-900, 900, (3, 400, 300)).astype(np.int16), "o": np.zeros((900, 300), np.uint16)}
    arrays = {"x": rng.normal(size=(5000, 3)).astype(np.float32)}
    assert packed_length(arrays, histories) == pytest.approx(len(packed(arrays, histories)[1]), rel=0.03)


def test_logarithms_keep_the_threshold_exact_and_values_to_a_thousandth():
    lengths = np.concatenate([[0.0, 1e-4, 1e-4 * (1 - 1e-6)], np.geomspace(2e-6, 3.0, 500)])
    codes, lowest, per_e = motion.logarithms(lengths[None], 1e-4)
    back = np.where(codes[:, 0] > 0, lowest * np.exp((codes[:, 0] - 0.5) / per_e), 0.0)
    assert codes[1, 0] == codes[2, 0] + 1 and codes[0, 0] == 0
    np.testing.assert_allclose(back[3:], lengths[3:], rtol=1e-3)


def test_thinned_curves_keep_their_peaks():
    time = np.linspace(0, 10, 50000)
    value = np.sin(time)
    value[31234], value[777], value[40000:40100] = 9.0, -4.0, np.nan
    curve = series.thinned(time, value, 200)
    assert len(curve.time) <= 202 and (np.diff(curve.time) > 0).all()
    assert np.nanmax(curve.value) == 9.0 and np.nanmin(curve.value) == -4.0
    assert curve.time[np.nanargmax(curve.value)] == pytest.approx(time[31234])


def test_a_killed_run_has_a_page_too(tmp_path):
    with Results.open(write_run(tmp_path / "result.h5", pillar(), pillar_states(3), peaks=False)) as results:
        write_page(results, tmp_path / "report.html")
    assert "The run has no summary" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_bad_settings_are_reported(tmp_path):
    with Results.open(write_run(tmp_path / "result.h5", pillar(), pillar_states(2))) as results:
        with refused_at("scale"):
            write_page(results, tmp_path / "report.html", scale=-1.0)
        with pytest.raises(InputError, match="cannot be written"):
            write_page(results, tmp_path / "nowhere" / "report.html")


def test_the_command_line_writes_the_page(block_on_plate, tmp_path):
    scene = block_on_plate(duration="duration = 0.05", report="[report]\nhtml = true")
    assert masonry_cd("run", scene, "-o", tmp_path / "out", "-q").exit_code == 0
    page = tmp_path / "out" / "report.html"
    text = page.read_text(encoding="utf-8")
    assert "html = true" in text and "per step" in text and not ADDRESS.search(text)
    page.unlink()
    assert "report.html" in masonry_cd("report", tmp_path / "out", "--html", "--no-crack-map").stdout
    assert page.exists()


def test_the_browser_moves_the_blocks_as_the_result_has_them(page, folder):
    with Results.open(folder / "result.h5") as results:
        solids = solids_of(results.blocks)
        for frame in (0, 4, 10):
            pose = page.run(
                "const { motion, viewer } = masonry.all; motion.fill(viewer.pose, motion.time[arguments[0]]);"
                "return Array.from(viewer.pose.subarray(0, 12 * motion.blocks));",
                frame,
            )
            texels, true = np.reshape(pose, (-1, 3, 4)), Pose.of(results, solids, frame)
            np.testing.assert_allclose(texels[:, 0, :3], true.displacement(solids), atol=2e-4)  # the loose block goes two metres
            np.testing.assert_allclose(texels[1:4, 0, :3], true.displacement(solids)[1:4], atol=1e-6)
            np.testing.assert_allclose(rotation_matrices(texels[:, 1]), true.rotation, atol=2e-4)


def test_joints_have_the_classes_of_the_crack_map(page, folder):
    with Results.open(folder / "result.h5") as results:
        moment = DamageSnapshot.at(results, results.frames - 1, Thresholds())
        assert moment.down.tolist() == [False, False, False, False, True]
    scales = Scale(1e-4, 0.05, OPENING), Scale(1e-4, 0.05, SLIDING)
    shown = np.reshape(page.run("const v = masonry.all.viewer; return Array.from(v.marks.subarray(0, 8 * v.joints));"), (-1, 8))
    assert (shown[:, 3] == 255).tolist() == (moment.open | moment.slid).tolist()
    hinge, slip = int(np.flatnonzero(moment.open)[0]), int(np.flatnonzero(moment.slid)[-1])
    assert shown[hinge, :3].tolist() == scales[0](moment.opening)[hinge].tolist()
    assert shown[slip, 4:7].tolist() in ([255, 255, 255], scales[1](moment.sliding)[slip].tolist())
    assert (shown[:, 7] > 0).tolist() == moment.separated.tolist()


JOINT = "const { facts, data, motion, camera, viewer } = masonry.all, between = (a, b) => Array.from(data.joint_a).findIndex((v, j) =>"
JOINT += " [facts.names[v], facts.names[data.joint_b[j]]].sort().join() === [a, b].sort().join());"


def test_an_open_joint_is_seen_in_its_colour(page):
    """The canvas itself: at the hinge stands the colour of its class, above it the stone."""
    colour, at_joint, above = page.run(
        JOINT
        + """
        camera.look("front"); masonry.state.factor = 1; masonry.chooseJoint(-1, true);
        const joint = between("lower", "middle"), gl = viewer.gl, pixel = new Uint8Array(4);
        const read = (x, y) => {
          gl.readPixels(Math.round(x), Math.round(y), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
          return Array.from(pixel.slice(0, 3));
        };
        return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {
          const [x, y] = camera.project(masonry.jointPlace(joint));
          const at = [(gl.drawingBufferWidth * (x + 1)) / 2, (gl.drawingBufferHeight * (y + 1)) / 2];
          done([Array.from(viewer.marks.slice(8 * joint, 8 * joint + 3)), read(at[0], at[1]), read(at[0], at[1] + 25)]);
        })));
        """
    )
    np.testing.assert_allclose(at_joint, colour, atol=3)
    assert max(colour) - min(colour) > 50 and min(above) > 180  # a blue and a pale stone


def test_playing_goes_on_and_stops_at_the_end(page):
    page.run("masonry.state.speed = 1e-3; masonry.seek(0)")
    page.click("#play")
    page.wait_for("masonry.state.time > 0.0")
    assert page.run("return masonry.state.playing")
    page.run("masonry.state.speed = 20")
    page.wait_for("!masonry.state.playing")
    assert page.run("return [masonry.state.time, masonry.state.playing]") == [pytest.approx(1.0), False]
    assert page.run("return document.getElementById('clock').textContent") == "1.00 s"


def test_a_row_shows_its_joint_and_a_click_in_the_model_its_row(page):
    page.click("#damage tbody tr:nth-child(1) button")
    joint = page.run("return masonry.state.joint")
    assert joint >= 0
    page.drawn()
    assert page.run("return document.getElementById('pin').hidden") is False
    assert page.run("return document.querySelector('tr.chosen').dataset.joint") == str(joint)
    page.run("masonry.all.camera.look('front'); masonry.chooseJoint(-1, true); masonry.seek(0)")
    page.run("document.getElementById('stage').scrollIntoView()")
    page.drawn()
    wanted = page.run(f"{JOINT} return between('middle', 'upper')")
    page.click_at(*screen(page, f"masonry.jointPlace({wanted})"))
    assert page.run("return [masonry.state.joint, document.querySelector('tr.chosen').dataset.joint]") == [wanted, str(wanted)]
    page.drawn()
    assert f"Joint {wanted}" in page.run("return document.getElementById('plots').textContent")


def screen(page: browsers.Browser, place: str) -> tuple[float, float]:
    """Where a point of the model is in the window [CSS pixels]."""
    x, y = page.run(
        f"const [x, y] = masonry.all.camera.project({place}), b = document.getElementById('model').getBoundingClientRect();"
        "return [b.left + b.width * (1 + x) / 2, b.top + b.height * (1 - y) / 2];"
    )
    return x, y


def test_a_click_on_a_block_plots_its_displacement(page):
    page.run("masonry.all.camera.look('front'); masonry.seek(0); document.getElementById('stage').scrollIntoView()")
    page.drawn()
    assert page.run("return masonry.state.chosen.map((c) => masonry.all.facts.names[c.block])") == ["upper"]  # the top one
    page.click_at(*screen(page, "Array.from(masonry.all.data.centre.slice(6, 9))"))
    assert page.run("return masonry.state.chosen.map((c) => masonry.all.facts.names[c.block])") == ["upper", "middle"]
    drawn = page.run("const c = masonry.all.charts.plots.points.curves; return c.map((k) => k.value[k.value.length - 1])")
    half = np.radians(HINGE)
    assert drawn[1] == pytest.approx(1e3 * (-0.5 * np.cos(half) + 0.5 * np.sin(half) + 0.5), abs=1e-3)  # its centre turns about the edge


def test_dragging_turns_the_model(page):
    page.run("masonry.all.camera.look('front'); document.getElementById('stage').scrollIntoView()")
    page.drawn()
    x, y = screen(page, "masonry.all.camera.target")
    page.drag(x, y, 100, 40)
    assert page.run("return [masonry.all.camera.turn, masonry.all.camera.tilt]") == pytest.approx([-0.5, 0.2], abs=0.05)
    assert page.run("return masonry.state.chosen.length") == 1  # a drag is not a click


def test_the_table_is_sorted_and_filtered(page):
    page.run("document.getElementById('state').value = 'all'; document.getElementById('state').dispatchEvent(new Event('change'))")
    column = "return [...document.querySelectorAll('#damage tbody tr')].map((r) => Number(r.dataset.joint))"
    sliding = page.run("return Array.from(masonry.all.data['damage/max_sliding'])")
    page.click("#damage th[data-name=max_sliding] button")
    assert page.run(column) == sorted(range(len(sliding)), key=lambda j: (-sliding[j], j))
    page.click("#damage th[data-name=max_sliding] button")
    assert page.run(column) == sorted(range(len(sliding)), key=lambda j: (sliding[j], j))
    assert page.run("return document.querySelector('th[data-name=max_sliding]').getAttribute('aria-sort')") == "ascending"
    page.run("const s = document.getElementById('search'); s.value = 'UPPER'; s.dispatchEvent(new Event('input'))")
    assert len(page.run(column)) == 1


def test_no_tile_stands_alone_on_a_wide_page(page):
    rows = "const tops = [...document.querySelectorAll('.tiles div')].map((t) => Math.round(t.getBoundingClientRect().top)); "
    page.size(1400, 1000)
    tops = page.run(rows + "return tops")
    counts = [tops.count(top) for top in sorted(set(tops))]
    assert len(counts) <= 2
    assert min(counts) >= max(counts) - 1
    page.size(1500, 1000)


AUDIT = """const out = [], all = (what) => [...document.querySelectorAll(what)];
    all("h1, h2, h3").reduce((last, h) => { if (+h.tagName[1] > last + 1) out.push(h.textContent); return +h.tagName[1]; }, 0);
    for (const e of all("img")) if (!e.alt) out.push("a picture without words");
    for (const e of all("input, select")) if (!e.labels.length && !e.ariaLabel) out.push(`no label: ${e.id}`);
    for (const e of all("button, a")) if (!e.textContent.trim() && !e.ariaLabel) out.push("a button without a name");
    for (const e of all("table")) if (!e.querySelector("th[scope]")) out.push("a table without headings");
    for (const e of all(".scroll, canvas, pre#scene")) if (e.tabIndex < 0) out.push(`out of reach of the keyboard: ${e.className || e.id}`);
    return out"""


def test_headings_labels_and_the_keyboard_lead_through_the_page(page):
    assert page.run(AUDIT) == []


def test_every_axis_has_two_ticks_or_more_and_none_crowds(page):
    """Whatever a plot spans; one that goes from -48 to 48 had its zero alone."""
    plots = """return [...document.querySelectorAll(".plot:not([hidden]) svg")].map((plot) =>
        [plot.querySelectorAll("text[text-anchor=end]:not(.level)").length, plot.querySelectorAll("text[text-anchor=middle]").length])"""
    counts = page.run(plots)
    assert len(counts) >= 2
    assert all(2 <= count <= 11 for both in counts for count in both), counts


def test_all_columns_of_the_joints_are_seen_at_1400_pixels(page):
    """With names and numbers as long as those of the demo."""
    page.size(1400, 1000)
    page.run("document.querySelectorAll('#damage tbody td:nth-child(-n+3)').forEach((d) => { d.textContent = 'spandrel4.14' })")
    page.run("document.querySelectorAll('#damage tbody td.number').forEach((d) => { d.textContent = '0.0804' })")
    table, place = page.run("const t = document.getElementById('damage'); return [t.scrollWidth, t.parentElement.clientWidth]")
    page.size(1500, 1000)
    assert table <= place


def test_it_prints(page):
    assert page.pdf().startswith(b"%PDF")


@pytest.mark.skipif(bool(browsers.missing()), reason=browsers.missing())
def test_the_command_line_prints_the_page(folder):
    asked = masonry_cd("report", folder, "--pdf", "--no-crack-map")
    assert "report.pdf" in asked.stdout, asked.stderr
    assert (folder / "report.pdf").read_bytes().startswith(b"%PDF")


def test_printing_without_a_browser_is_reported(folder, monkeypatch):
    monkeypatch.setenv("PATH", "")
    asked = masonry_cd("report", folder, "--pdf", "--no-crack-map")
    assert asked.exit_code == 2 and "--pdf: Chromium, which prints the page, is missing" in asked.stderr
