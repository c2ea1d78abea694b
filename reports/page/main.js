/* The page as a whole: what is shown now, and what each control does to it. */

const by = (id) => document.getElementById(id);

/* What the reader has chosen; everything on the page follows from it. */
const state = { time: 0, playing: false, speed: 1, factor: 1, jointsBy: "both", jointsWhen: "most", blocksBy: "stone", edges: true, rest: false, tension: true, chosen: [], component: "x", joint: -1 };
let facts, data, motion, camera, viewer, charts, table;
let dirty = true, shownFrame = -1, lastTick = 0;

const channels = (colour) => [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16));

/* Colours of all blocks: by state or group, those that are plotted in the colour of their curve. */
function paintBlocks(frame) {
  const { stone, support, fallen } = facts.colours;
  for (let b = 0; b < motion.blocks; b++) {
    let colour = data.fixed[b] ? support : motion.flag("fallen", b, frame) ? fallen : stone;
    if (state.blocksBy === "group") colour = facts.families[data.family[b]].colour;
    const pressed = state.blocksBy === "compression" ? data.pressed_most[b] : state.blocksBy === "compression-now" ? data.pressed[frame * motion.blocks + b] : 0;
    if (pressed) colour = facts.compression.colours[pressed - 1];
    const mottle = 1 + 0.025 * (2 * ((b * 0.6180339887498949) % 1) - 1);
    viewer.paint.set(channels(colour).map((c) => Math.min(255, c * mottle)), 4 * b);
  }
  for (const { block, colour } of state.chosen) viewer.paint.set(channels(colour).map((c) => 0.7 * c + 70), 4 * block);
}

/* Colours of all joints, as the crack map has them: open solid, slid dashed with white, both dashed in two colours. */
function paintJoints(frame) {
  const { scales } = facts, most = state.jointsWhen === "most", parts = state.jointsBy;
  const colours = Object.fromEntries(Object.entries(scales).map(([name, scale]) => [name, scale.colours.map(channels)]));
  const opening = motion.codes("opening", most), sliding = motion.codes("sliding", most), white = [255, 255, 255];
  for (let j = 0; j < motion.joints; j++) {
    const down = [data.joint_a[j], data.joint_b[j]].map((b) => motion.flag("fallen", b, frame)), parted = motion.flag("separated", j, frame);
    const live = parts !== "none" && !parted && !down[0] && !down[1];
    const o = live && parts !== "sliding" ? motion.rank("opening", opening[j * motion.frames + frame]) : -1;
    const s = live && parts !== "opening" ? motion.rank("sliding", sliding[j * motion.frames + frame]) : -1;
    const first = o >= 0 ? colours.opening[o] : s >= 0 ? colours.sliding[s] : white;
    const second = s < 0 ? first : o >= 0 ? colours.sliding[s] : white;
    const plates = parted && parts !== "none" ? (down[0] ? 0 : 1) + (down[1] ? 0 : 2) : 0;
    viewer.marks.set([...first, o >= 0 || s >= 0 ? 255 : 0, ...second, 85 * plates], 8 * j);
  }
}

/* Where a point of a block, given as it lies at rest, is drawn now. */
function drawnPlace(point, block) {
  const at = 4 * TEXELS * block, [w, ...q] = viewer.pose.subarray(at + 4, at + 8);
  const arm = point.map((v, k) => v - viewer.pose[at + 8 + k]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const turn = cross(q, cross(q, arm).map((v, k) => v + w * arm[k])).map((v) => 2 * v);
  return point.map((v, k) => v + state.factor * (turn[k] + viewer.pose[at + k]));
}

/* The place of a joint's middle as it is drawn now. */
function jointPlace(joint) {
  const middle = [0, 0, 0], first = data.polygon_start[joint], last = data.polygon_start[joint + 1];
  for (let i = first; i < last; i++) for (let k = 0; k < 3; k++) middle[k] += data.polygon[3 * i + k] / (last - first);
  return drawnPlace(middle, data.joint_a[joint]);
}

/* The middle of a tie as it is drawn now. */
function tiePlace(tie) {
  const ends = [0, 1].map((side) => drawnPlace([...data.tie_point.subarray(6 * tie + 3 * side, 6 * tie + 3 * side + 3)], data.tie_block[2 * tie + side]));
  return ends[0].map((v, k) => (v + ends[1][k]) / 2);
}

/* The tension of each tie next to it, at a frame, of those that pull; where there is no room for all, of those that pull most. */
function labelTies(frame) {
  const wide = by("stage").clientWidth, high = by("stage").clientHeight, shown = [], ties = data.tie_tension ? data.tie_tension.length / motion.frames : 0;
  const pull = (tie) => data.tie_tension[tie * motion.frames + frame];
  const order = state.tension ? [...Array(ties).keys()].filter((tie) => pull(tie) > 0).sort((a, b) => pull(b) - pull(a) || a - b) : [];
  for (const tie of order) {
    const [x, y] = camera.project(tiePlace(tie)), place = [(wide * (1 + x)) / 2, (high * (1 - y)) / 2];
    if (shown.every((other) => Math.abs(other.place[0] - place[0]) > 64 || Math.abs(other.place[1] - place[1]) > 18)) shown.push({ tie, place });
  }
  by("tensions").replaceChildren(...shown.map(({ tie, place }) => {
    const label = document.createElement("span");
    label.textContent = pull(tie) < 1e3 ? `${short(pull(tie), 3)} N` : `${short(pull(tie) / 1e3, 3)} kN`;
    label.style.left = `${(100 * place[0]) / wide}%`;
    label.style.top = `${(100 * place[1]) / high}%`;
    return label;
  }));
}

function draw(now) {
  requestAnimationFrame(draw);
  if (state.playing) {
    state.time += Math.min(0.1, (now - lastTick) / 1000) * state.speed;
    if (state.time >= motion.end) { state.time = motion.end; play(false); }
    dirty = true;
  }
  lastTick = now;
  if (dirty) { dirty = false; render(); }
}

function render() {
  const [frame] = motion.place(state.time);
  by("slider").value = frame;
  by("slider").setAttribute("aria-valuetext", `${short(state.time, 3)} s`);
  by("clock").textContent = `${state.time.toFixed(2)} s`;
  charts.at(state.time);
  if (!viewer) return;
  camera.resize(viewer.resize());
  motion.fill(viewer.pose, state.time);
  if (frame !== shownFrame) { paintBlocks(frame); paintJoints(frame); viewer.send("paint", "marks"); shownFrame = frame; }
  viewer.send("pose");
  viewer.draw(camera, { factor: state.factor, edges: state.edges, rest: state.rest, chosen: state.joint });
  overlay();
  labelTies(frame);
}

/* What lies over the model: the time, the factor, the axes, the scale bar and the pin of the chosen joint. */
function overlay() {
  const shape = state.factor === 1 ? "true shape" : `displacements × ${short(state.factor)}`;
  const few = facts.frames < facts.frames_written ? ` · ${facts.frames} of ${facts.frames_written} frames` : "";
  by("facts").textContent = `t = ${short(state.time, 4)} s · ${shape}, relative to the base${few}`;
  by("facts").textContent += state.jointsBy === "none" ? "" : state.jointsWhen === "most" ? " · joints: largest so far" : " · joints: now";
  const axes = Object.entries(facts.colours.axes).map(([name, hue], k) => {
    const [x, y] = [24 * camera.right[k], -24 * camera.up[k]];
    return Math.hypot(x, y) < 4 ? "" : `<line x2="${x}" y2="${y}" stroke="${hue}"></line><text x="${1.4 * x}" y="${1.4 * y + 4}" fill="${hue}">${name}</text>`;
  });
  by("axes").innerHTML = `<svg viewBox="-40 -40 80 80">${axes.join("")}</svg>`;
  const wide = by("stage").clientWidth, metre = by("stage").clientHeight / camera.height, power = 10 ** Math.floor(Math.log10((0.25 * wide) / metre));
  const length = power * [5, 2, 1].find((s) => s * power * metre <= 0.25 * wide);
  by("ruler").style.width = `${(100 * length * metre) / wide}%`; /* in print the picture keeps its shape, not its size */
  by("stage").style.setProperty("--aspect", camera.aspect.toFixed(4));
  by("ruler-text").textContent = length >= 1 ? `${short(length)} m` : `${short(1e3 * length)} mm`;
  const pin = by("pin");
  pin.hidden = state.joint < 0;
  if (pin.hidden) return;
  const [x, y] = camera.project(jointPlace(state.joint));
  pin.style.left = `${50 * (1 + x)}%`;
  pin.style.top = `${50 * (1 - y)}%`;
  pin.textContent = `joint ${state.joint}`;
}

function changed(colours = false) {
  if (colours) shownFrame = -1;
  dirty = true;
}

function play(on) {
  if (on && state.time >= motion.end) state.time = motion.time[0];
  state.playing = on;
  by("play").textContent = on ? "❚❚ Pause" : "▶ Play";
  by("play").setAttribute("aria-pressed", on);
  changed();
}

function seek(time) {
  state.time = Math.max(motion.time[0], Math.min(motion.end, time));
  changed();
}

/* Chooses a joint, or none: the model shows it, its plot and its row appear. */
function chooseJoint(joint, fromModel = false) {
  state.joint = joint === state.joint && !fromModel ? -1 : joint;
  charts.joint(state.joint);
  table.mark(state.joint, fromModel);
  if (viewer && state.joint >= 0 && !fromModel) {
    const place = jointPlace(state.joint);
    const away = Math.hypot(...place.map((v, k) => v - (camera.low[k] + camera.high[k]) / 2)) > 2 * camera.size; /* flung away: not followed */
    if (!away && camera.project(place).some((v) => Math.abs(v) > 0.95)) { camera.target = place; camera.fitted = false; }
    if (window.matchMedia("(max-width: 1099px)").matches) by("stage").scrollIntoView({ block: "nearest" });
  }
  changed();
}

/* Adds a block to the plot of displacements, or takes it out; four at most. */
function chooseBlock(block) {
  const at = state.chosen.findIndex((item) => item.block === block);
  if (at >= 0) state.chosen.splice(at, 1);
  else {
    if (state.chosen.length === 4) state.chosen.shift();
    const colour = WATCHED.find((hue) => !state.chosen.some((item) => item.colour === hue));
    state.chosen.push({ block, colour });
  }
  showChosen();
}

function showChosen() {
  by("chosen").replaceChildren(...state.chosen.map(({ block, colour }) => {
    const chip = document.createElement("button");
    chip.type = "button";
    chip.style.setProperty("--hue", colour);
    chip.textContent = `${facts.names[block]} ×`;
    chip.title = `${facts.names[block]}, group ${facts.groups[block]}: take it out of the plot`;
    chip.addEventListener("click", () => chooseBlock(block));
    return chip;
  }));
  charts.points(state.chosen, state.component);
  changed(true);
}

/* Dragging turns, with Shift or the right button it moves; two fingers zoom and move; a click chooses. */
function watchCanvas(canvas) {
  const fingers = new Map();
  let travelled = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (fingers.size === 1) travelled = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before[0], dy = event.clientY - before[1], high = canvas.clientHeight;
    travelled += Math.hypot(dx, dy);
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      camera.zoom(apart(before) / apart([event.clientX, event.clientY]));
      camera.pan(dx / (2 * high), -dy / (2 * high));
    } else if (event.shiftKey || event.buttons & 6) camera.pan(dx / high, -dy / high);
    else if (travelled > 4) camera.orbit(dx / 200, dy / 200);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    changed();
  });
  const lift = (event) => {
    if (event.type === "pointerup" && fingers.size === 1 && travelled <= 4 && event.button === 0) clicked(event);
    fingers.delete(event.pointerId);
  };
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return; /* else the page scrolls, as it should */
    event.preventDefault();
    const box = canvas.getBoundingClientRect();
    camera.zoom(Math.exp(event.deltaY * 0.0012), (event.clientX - box.left - box.width / 2) / box.height, -(event.clientY - box.top - box.height / 2) / box.height);
    changed();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (turn && event.shiftKey) camera.pan(turn[0] * 0.05, -turn[1] * 0.05);
    else if (turn) camera.orbit(turn[0] * 0.1, turn[1] * 0.1);
    else if (event.key === "+" || event.key === "=") camera.zoom(0.8);
    else if (event.key === "-") camera.zoom(1.25);
    else if (event.key === "Home") camera.fit();
    else if (event.key === " ") play(!state.playing);
    else if (event.key === "Escape") chooseJoint(-1, true);
    else return;
    event.preventDefault();
    changed();
  });
}

function clicked(event) {
  const box = viewer.canvas.getBoundingClientRect();
  const found = viewer.pick(event.clientX - box.left, event.clientY - box.top, camera, state.factor);
  if (!found) chooseJoint(-1, true);
  else if ("joint" in found) chooseJoint(found.joint, true);
  else chooseBlock(found.block);
}

/* Gives the reader a file that the page carries. */
function save(content, type, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

function watchControls() {
  by("play").addEventListener("click", () => play(!state.playing));
  by("slider").max = motion.frames - 1;
  by("slider").addEventListener("input", (event) => { play(false); seek(motion.time[Number(event.target.value)]); });
  by("speed").addEventListener("change", (event) => { state.speed = Number(event.target.value); });
  for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => { camera.look(button.dataset.view); changed(); });
  for (const [id, act] of [["closer", () => camera.zoom(0.8)], ["farther", () => camera.zoom(1.25)], ["fit", () => camera.fit()]]) by(id).addEventListener("click", () => { act(); changed(); });
  by("factor").value = state.factor;
  by("factor").addEventListener("input", (event) => {
    const value = Number(event.target.value);
    if (event.target.value !== "" && value >= 0) { state.factor = value; changed(); }
  });
  for (const [id, key] of [["joints-by", "jointsBy"], ["joints-when", "jointsWhen"], ["blocks-by", "blocksBy"]]) {
    by(id).value = state[key];
    by(id).addEventListener("change", (event) => { state[key] = event.target.value; legend(); changed(true); });
  }
  if (!data.pressed) for (const option of document.querySelectorAll("#blocks-by [value^=compression]")) option.remove();
  by("with-ties").hidden = !data.tie_tension;
  for (const id of ["edges", "rest", "tension"]) { by(id).checked = state[id]; by(id).addEventListener("change", (event) => { state[id] = event.target.checked; changed(); }); }
  by("component").addEventListener("change", (event) => { state.component = event.target.value; showChosen(); });
  by("find-block").addEventListener("submit", (event) => {
    event.preventDefault();
    const name = by("block-name").value.trim(), block = facts.names.indexOf(name);
    by("no-block").textContent = block < 0 ? `There is no block “${name}”.` : "";
    if (block >= 0 && !state.chosen.some((item) => item.block === block)) chooseBlock(block);
  });
  by("block-names").innerHTML = facts.names.slice(0, 2000).map((name) => `<option value="${safe(name)}">`).join("");
  by("save").addEventListener("click", () => save(facts.scene, "application\u002ftoml", "scene.toml"));
  for (const button of document.querySelectorAll("[data-file]")) {
    const name = button.dataset.file;
    button.addEventListener("click", () => save(data[`file\u002f${name}`], "text\u002fcsv", name));
  }
  by("copy").addEventListener("click", () => {
    const done = (text) => { by("copied").textContent = text; };
    const select = () => { getSelection().selectAllChildren(by("scene")); done("The scene is selected: copy it with Ctrl+C."); };
    if (navigator.clipboard) navigator.clipboard.writeText(facts.scene).then(() => done("Copied."), select); else select();
  });
}

/* The fixed classes of the crack map and the signs. */
function legend() {
  const bars = ["opening", "sliding"].filter((name) => state.jointsBy === "both" || state.jointsBy === name).map((name) => {
    const { bounds, colours } = facts.scales[name], boxes = bounds.map((bound, k) => `<li class="${name}" style="--hue:${colours[k]}">${short(1e3 * bound, 3)}</li>`);
    return `<div><b>${name} of the joint [mm], from</b><ol>${boxes.join("")}</ol></div>`;
  });
  if (state.blocksBy.startsWith("compression")) {
    const { bounds, colours, unit } = facts.compression, boxes = bounds.map((bound, k) => `<li style="--hue:${colours[k]}">${short(bound, 3)}</li>`);
    bars.push(`<div><b>mean compression of the block [${unit}], from</b><ol>${boxes.join("")}</ol></div>`);
  }
  const { stone, support, fallen, parted } = facts.colours, mid = (name) => facts.scales[name].colours[facts.scales[name].colours.length >> 1];
  const signs = [[`background:${mid("opening")}`, "open: solid"], [`background:repeating-linear-gradient(90deg,${mid("sliding")} 0 6px,#fff 6px 11px)`, "slid: dashed"], [`background:repeating-linear-gradient(90deg,${mid("opening")} 0 6px,${mid("sliding")} 6px 11px)`, "open and slid"], [`background:${parted}`, "separated"]];
  const blocks = state.blocksBy.startsWith("compression") ? [[support, "support"]] : state.blocksBy === "group" ? facts.families.slice(0, 24).map((f) => [f.colour, f.text]) : [[stone, "block"], [fallen, "fallen block"], [support, "support"]];
  const boxes = blocks.map(([colour, text]) => `<span><i class="box" style="background:${colour}"></i>${safe(text)}</span>`);
  by("legend").innerHTML = `${bars.join("")}<p>${(state.jointsBy === "none" ? [] : signs).map(([style, text]) => `<span><i style="${style}"></i>${text}</span>`).join("")}${boxes.join("")}</p>`;
}

async function start() {
  facts = JSON.parse(by("facts-data").textContent);
  data = await unpack(facts.contents, by("packed-data").textContent);
  motion = new Motion(facts, data);
  state.factor = facts.factor;
  state.time = motion.end;
  camera = new Camera(facts.low, facts.high);
  camera.look(facts.view);
  charts = new Charts(by("plots"), facts, data, motion, seek);
  table = new Table(facts, data, chooseJoint);
  by("states").textContent = `${facts.meaning} Where a joint opened and slid, the one that went further beyond its threshold names it. A row shows its joint in the model.`;
  try {
    viewer = new Viewer(by("model"), facts, data);
    watchCanvas(by("model"));
    new ResizeObserver(() => changed()).observe(by("stage"));
  } catch (problem) { tell(problem); }
  watchControls();
  legend();
  state.component = motion.mainAxis(facts.top);
  by("component").value = state.component;
  chooseBlock(facts.top);
  by("loading").remove();
  const dated = () => { by("printed").textContent = `Printed on ${new Date().toISOString().slice(0, 10)}`; };
  dated();
  window.addEventListener("beforeprint", () => { dated(); render(); });
  requestAnimationFrame(draw);
}

function tell(problem) {
  by("trouble").hidden = false;
  by("trouble").textContent = problem.message;
}

window.masonry = { state, seek, play, chooseJoint, chooseBlock, jointPlace, get all() { return { facts, data, motion, camera, viewer, charts, table }; } };
window.ready = start().then(() => true, (problem) => {
  tell(typeof DecompressionStream === "undefined" ? new Error("This browser is too old for the page: it needs one of 2023 or later.") : problem);
  by("loading").remove();
  return false;
});
