/* Curves over time as SVG, with a cursor that follows the model's time. */

const BOX = { width: 600, height: 190, left: 68, right: 22, top: 12, bottom: 24 };
const HUES = ["#0072b2", "#d55e00", "#009e73", "#b3589a", "#8a6d00", "#56b4e9", "#555555"]; /* apart for colour-blind readers too */

const WATCHED = ["#7b3294", "#8a6d00", "#d0409a", "#555555"]; /* of blocks in the model: unlike the colours of opening and sliding */

const safe = (text) => String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);

/* Four digits at most. */
function short(value, digits = 4) {
  if (value === null || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size === 0 || (size >= 1e-3 && size < 1e5)) return String(Number(value.toPrecision(digits))).replace("-", "−");
  const [mantissa, power] = value.toExponential(Math.min(2, digits - 1)).split("e");
  return `${Number(mantissa)}·10${[...power.replace("+", "")].map((c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]).join("")}`.replace("-", "−");
}

/* Round numbers between two bounds, two or more, about as many as requested. */
function ticks(low, high, about) {
  const raw = (high - low) / about, power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((s) => s * power >= 0.6 * raw), out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) out.push(Number((k * step).toPrecision(12)));
  return out;
}

class Plot {
  /* spec: {title, unit, log, curves: [{name, colour, time, value}], lines: [{value, name}], marks: times, note} */
  constructor(host, span, seek) {
    this.host = document.createElement("figure");
    this.host.className = "plot";
    host.append(this.host);
    this.span = span;
    this.seek = seek;
  }

  show(spec) {
    this.spec = spec;
    const all = spec.curves.flatMap((c) => [c]).filter((c) => c.time.length);
    this.host.hidden = Boolean(spec.hidden) || (!all.length && !spec.empty); /* no empty plots, but those that wait for a choice */
    if (!all.length) {
      this.host.innerHTML = `<figcaption><b>${safe(spec.title)}</b></figcaption><p class="hint">${safe(spec.empty)}</p>`;
      this.cursor = null;
      return;
    }
    this.range(all);
    const body = [...this.axes(), ...(spec.lines || []).map((l) => this.level(l)), this.marked(), ...all.map((c) => this.curve(c))];
    const label = `${spec.title}${spec.unit ? ` in ${spec.unit}` : ""}, from ${short(this.low)} to ${short(this.high)}, over ${short(this.span[1])} s`;
    this.host.innerHTML =
      `<figcaption><b>${safe(spec.title)}</b>${spec.unit ? ` [${safe(spec.unit)}]` : ""} ${all.map((c) => `<span class="key" style="--hue:${c.colour}">${safe(c.name)} <output></output></span>`).join(" ")}</figcaption>` +
      `<svg viewBox="0 0 ${BOX.width} ${BOX.height}" role="img" aria-label="${safe(label)}">${body.join("")}<line class="cursor" y1="${BOX.top}" y2="${BOX.height - BOX.bottom}"></line></svg>` +
      (spec.note ? `<p class="hint">${safe(spec.note)}</p>` : "");
    this.curves = all;
    this.cursor = this.host.querySelector(".cursor");
    this.outputs = this.host.querySelectorAll("figcaption output");
    this.host.querySelector("svg").addEventListener("click", (event) => this.clicked(event));
  }

  /* What the values span; a little room around them, and never nothing. */
  range(curves) {
    let low = Infinity, high = -Infinity;
    for (const { value } of curves) for (const v of value) if (Number.isFinite(v) && (!this.spec.log || v > 0)) { if (v < low) low = v; if (v > high) high = v; }
    for (const { value } of this.spec.lines || []) { low = Math.min(low, value); high = Math.max(high, value); }
    if (!(low <= high)) [low, high] = this.spec.log ? [1e-16, 1] : [0, 1];
    if (this.spec.log) {
      [this.low, this.high] = [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high) + 1e-9)];
      if (this.low === this.high) this.high *= 10;
      return;
    }
    if (this.spec.zero) [low, high] = [Math.min(0, low), Math.max(0, high)];
    const room = high > low ? 0.06 * (high - low) : Math.abs(high) || 1;
    [this.low, this.high] = [low - (low === 0 ? 0 : room), high + (high === 0 && low < 0 ? 0 : room)];
  }

  x(time) { return BOX.left + ((time - this.span[0]) / (this.span[1] - this.span[0] || 1)) * (BOX.width - BOX.left - BOX.right); }

  y(value) {
    const part = this.spec.log
      ? Math.log10(Math.max(value, this.low) / this.low) / Math.log10(this.high / this.low)
      : (value - this.low) / (this.high - this.low);
    return BOX.height - BOX.bottom - part * (BOX.height - BOX.top - BOX.bottom);
  }

  axes() {
    const out = [], foot = BOX.height - BOX.bottom;
    let levels = ticks(this.low, this.high, 4);
    if (this.spec.log) {
      const first = Math.round(Math.log10(this.low)), last = Math.round(Math.log10(this.high)), step = Math.ceil((last - first) / 5);
      levels = Array.from({ length: Math.floor((last - first) / step) + 1 }, (_, k) => 10 ** (first + k * step));
    }
    const apart = levels.length > 1 ? levels[1] - levels[0] : 0, largest = Math.max(...levels.map(Math.abs));
    const digits = apart > 0 ? Math.min(12, Math.max(4, 1 + Math.ceil(Math.log10(largest / apart)))) : 4; /* no two labels alike */
    for (const v of levels) {
      const y = this.y(v), exponent = Math.round(Math.log10(v));
      const text = this.spec.log ? `10<tspan dy="-5" font-size="9">${exponent}</tspan>` : safe(short(v, digits));
      out.push(`<line class="grid" x1="${BOX.left}" x2="${BOX.width - BOX.right}" y1="${y}" y2="${y}"></line><text x="${BOX.left - 6}" y="${y + 4}" text-anchor="end">${text}</text>`);
    }
    const times = ticks(this.span[0], this.span[1], 6);
    for (const t of times) {
      const x = this.x(t), unit = t === times[times.length - 1] ? " s" : "";
      out.push(`<line class="grid" x1="${x}" x2="${x}" y1="${foot}" y2="${foot + 4}"></line><text x="${x}" y="${foot + 17}" text-anchor="middle">${short(t)}${unit}</text>`);
    }
    out.push(`<line class="axis" x1="${BOX.left}" x2="${BOX.width - BOX.right}" y1="${foot}" y2="${foot}"></line>`);
    return out;
  }

  level({ value, name }) {
    const y = this.y(value);
    return `<line class="level" x1="${BOX.left}" x2="${BOX.width - BOX.right}" y1="${y}" y2="${y}"></line><text class="level" x="${BOX.width - BOX.right - 2}" y="${y - 4}" text-anchor="end">${safe(name)}</text>`;
  }

  /* Short strokes at the top, where something is to be noticed. */
  marked() {
    const marks = this.spec.marks || [];
    if (!marks.length) return "";
    return `<path class="marks" d="${Array.from(marks, (t) => `M${this.x(t).toFixed(1)} ${BOX.top}v7`).join("")}"></path>`;
  }

  curve({ time, value, colour }) {
    let path = "", pen = "M";
    for (let i = 0; i < time.length; i++) {
      if (!Number.isFinite(value[i])) { pen = "M"; continue; }
      path += `${pen}${this.x(time[i]).toFixed(1)} ${this.y(value[i]).toFixed(1)}`;
      pen = "L";
    }
    return `<path class="curve" d="${path}" stroke="${colour}"></path>`;
  }

  clicked(event) {
    const box = event.currentTarget.getBoundingClientRect(), x = ((event.clientX - box.left) / box.width) * BOX.width;
    const part = (x - BOX.left) / (BOX.width - BOX.left - BOX.right);
    this.seek(this.span[0] + Math.max(0, Math.min(1, part)) * (this.span[1] - this.span[0]));
  }

  /* Moves the cursor and shows the values there. */
  at(time) {
    if (!this.cursor || this.host.hidden) return;
    const x = this.x(time).toFixed(1);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    this.curves.forEach((curve, k) => {
      const value = nearest(curve, time), nothing = !this.spec.log && Math.abs(value) < 1e-6 * (this.high - this.low); /* rounding is no news */
      this.outputs[k].textContent = short(nothing ? 0 : value, 3);
    });
  }
}

/* The value of a curve at the last of its times that is not after a time. */
function nearest({ time, value }, at) {
  let low = 0, high = time.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (time[middle] <= at + 1e-9) low = middle; else high = middle - 1;
  }
  return value[low];
}
