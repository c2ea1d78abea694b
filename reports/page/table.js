/* The damage table: sorted, filtered, a page of rows at a time; a row and a joint of the model go together. */

const ROWS = 20;
const PRINTED = 40; /* rows in print */
const HEADS = [
  /* name, heading, unit, factor */
  ["joint", "joint"], ["a", "block a"], ["b", "block b"], ["state", "state"],
  ["max_opening", "largest opening", "mm", 1e3], ["residual_opening", "opening at end", "mm", 1e3],
  ["max_sliding", "largest sliding", "mm", 1e3], ["residual_sliding", "sliding at end", "mm", 1e3],
  ["max_rotation", "largest rotation", "°", 180 / Math.PI], ["contact_area_loss", "contact lost", "%", 100], ["first_opening_time", "first opened", "s", 1],
];

/* A number in the table; what is below a thousandth is as good as nothing. */
const cell = (value) => (Number.isNaN(value) ? "" : value > 0 && value < 1e-3 ? "&lt;0.001" : short(value, 3));

class Table {
  constructor(facts, data, choose) {
    Object.assign(this, { facts, data, choose, chosen: -1, first: 0, rows: ROWS });
    this.table = document.getElementById("damage");
    this.body = this.table.querySelector("tbody");
    this.joints = data.state.length;
    this.sorted = { name: "max_opening", down: true };
    this.words = new Intl.Collator("en", { numeric: true });
    this.heads();
    this.filters();
    this.refresh();
    window.addEventListener("beforeprint", () => this.page(PRINTED));
    window.addEventListener("afterprint", () => this.page(ROWS));
  }

  value(name, j) {
    const { facts, data } = this;
    if (name === "joint") return j;
    if (name === "a" || name === "b") return facts.names[data[`joint_${name}`][j]];
    if (name === "state") return data.state[j];
    return data[`damage/${name}`][j];
  }

  heads() {
    const row = this.table.querySelector("thead tr");
    for (const [name, heading, unit] of HEADS) {
      const cell = document.createElement("th");
      cell.scope = "col";
      cell.dataset.name = name;
      cell.innerHTML = `<button type="button">${safe(heading)}${unit ? ` <small>[${unit}]</small>` : ""}</button>`;
      cell.firstChild.addEventListener("click", () => this.sort(name));
      row.append(cell);
    }
  }

  filters() {
    const select = document.getElementById("state"), counts = this.facts.states.map((_, k) => this.data.state.reduce((n, s) => n + (s === k), 0));
    const damaged = this.joints - counts[0], options = [["damaged", `damaged (${damaged})`], ["all", `all (${this.joints})`], ...this.facts.states.map((s, k) => [String(k), `${s} (${counts[k]})`])];
    select.innerHTML = options.map(([value, text]) => `<option value="${value}">${safe(text)}</option>`).join("");
    select.value = damaged ? "damaged" : "all";
    select.addEventListener("change", () => this.refresh());
    const search = document.getElementById("search");
    search.addEventListener("input", () => this.refresh());
    document.getElementById("filter").addEventListener("submit", (event) => event.preventDefault());
    document.getElementById("previous").addEventListener("click", () => this.turn(-1));
    document.getElementById("next").addEventListener("click", () => this.turn(1));
    this.wanted = () => [select.value, search.value.trim().toLowerCase()];
    this.widen = () => { select.value = "all"; search.value = ""; };
  }

  sort(name) {
    const text = ["joint", "a", "b"].includes(name);
    this.sorted = { name, down: this.sorted.name === name ? !this.sorted.down : !text };
    this.refresh();
  }

  /* Filters and sorts again, from the first row. */
  refresh() {
    const [state, search] = this.wanted(), { name, down } = this.sorted;
    const kept = (j) => state === "all" || (state === "damaged" ? this.data.state[j] > 0 : this.data.state[j] === Number(state));
    const found = (j) => !search || ["a", "b"].some((side) => this.value(side, j).toLowerCase().includes(search));
    this.order = Array.from({ length: this.joints }, (_, j) => j).filter((j) => kept(j) && found(j));
    this.order.sort((p, q) => this.compare(this.value(name, p), this.value(name, q), down ? -1 : 1) || p - q);
    for (const cell of this.table.querySelectorAll("th")) cell.setAttribute("aria-sort", cell.dataset.name !== name ? "none" : down ? "descending" : "ascending");
    this.first = 0;
    this.fill();
  }

  /* Which of two values comes first; what never happened comes last either way. */
  compare(p, q, sign) {
    if (typeof p === "string") return sign * this.words.compare(p, q);
    if (Number.isNaN(p) || Number.isNaN(q)) return Number.isNaN(p) - Number.isNaN(q);
    return sign * (p - q);
  }

  turn(by) {
    this.first = Math.max(0, Math.min(this.first + by * this.rows, Math.floor(Math.max(0, this.order.length - 1) / this.rows) * this.rows));
    this.fill();
  }

  page(rows) {
    this.rows = rows;
    if (rows === PRINTED) this.first = 0;
    this.fill();
  }

  fill() {
    const { order, first, rows } = this, last = Math.min(order.length, first + rows);
    this.body.replaceChildren(...order.slice(first, last).map((j) => this.row(j)));
    document.getElementById("rows").textContent = order.length ? `${first + 1} to ${last} of ${order.length}` : "none";
    const more = document.getElementById("more");
    more.hidden = order.length <= rows;
    more.textContent = `Joints ${first + 1} to ${last} of ${order.length} in this order; all of them are in joints.csv.`;
    document.getElementById("previous").disabled = first === 0;
    document.getElementById("next").disabled = last === order.length;
  }

  row(j) {
    const row = document.createElement("tr");
    row.dataset.joint = j;
    row.classList.toggle("chosen", j === this.chosen);
    row.innerHTML = HEADS.map(([name, , unit, by]) => {
      const value = this.value(name, j);
      if (name === "joint") return `<th scope="row"><button type="button" aria-pressed="${j === this.chosen}" title="Show this joint in the model">${j}</button></th>`;
      if (name === "state") return `<td><span class="state s${value}">${this.facts.states[value]}</span></td>`;
      return unit ? `<td class="number">${cell(by * value)}</td>` : `<td>${safe(value)}</td>`;
    }).join("");
    row.addEventListener("click", () => this.choose(j));
    return row;
  }

  /* Marks the row of a joint; brings it into the table where asked. */
  mark(joint, bring) {
    this.chosen = joint;
    if (bring && joint >= 0) {
      if (!this.order.includes(joint)) { this.widen(); this.refresh(); }
      this.first = Math.floor(this.order.indexOf(joint) / this.rows) * this.rows;
    }
    const focused = document.activeElement && this.body.contains(document.activeElement);
    this.fill();
    const row = this.body.querySelector("tr.chosen");
    if (focused && row) row.querySelector("button").focus({ preventScroll: true });
    if (bring && row) row.scrollIntoView({ block: "nearest" });
  }
}
