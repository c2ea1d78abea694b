/* Which plots the page shows, from what the run recorded. */

class Charts {
  constructor(host, facts, data, motion, seek) {
    Object.assign(this, { facts, data, motion });
    const last = Math.max(motion.end, ...["error/time", "energy/kinetic/time"].map((name) => (data[name] ? data[name][data[name].length - 1] : 0)));
    const make = () => new Plot(host, [motion.time[0], last], seek);
    this.plots = Object.fromEntries(["points", "joint", "base", "speed", "energy", "error", "cost", "contacts"].map((name) => [name, make()]));
    for (const [name, plot] of Object.entries(this.plots)) plot.host.dataset.plot = name;
    this.plots.base.show(this.base("displacement", "Base: displacement", "m"));
    this.plots.speed.show(this.base("velocity", "Base: velocity", "m/s"));
    this.plots.energy.show(this.energy());
    this.plots.error.show(this.error());
    this.plots.cost.show({ title: "Cost of a step", unit: "ms", zero: true, curves: this.curves([["cost/seconds", "solver and detection", 1e3]]) });
    const work = [["cost/iterations", "iterations"], ["cost/contacts", "contacts"]];
    this.plots.contacts.show({ title: "Iterations and contacts per step", zero: true, curves: this.curves(work) });
    this.joint(-1);
  }

  /* Curves that the file holds, of [name, label, factor]. */
  curves(wanted) {
    return wanted
      .filter(([name]) => this.data[`${name}/time`])
      .map(([name, label, by = 1], k) => ({ name: label, colour: HUES[k % HUES.length], time: this.data[`${name}/time`], value: this.data[`${name}/value`].map((v) => by * v) }));
  }

  /* Each motion of the supports by its own; directions in which nothing happens are left out. */
  base(name, title, unit) {
    const { motions, motions_left_out: left, motions_at_rest: resting } = this.facts;
    const wanted = motions.flatMap((who, k) => ["x", "y", "z"].map((axis) => [`base/${k}/${name}/${axis}`, who ? `${who}, ${axis}` : axis]));
    const moving = this.curves(wanted).filter(({ value }) => value.some((v) => Math.abs(v) > 1e-9));
    const curves = moving.slice(0, HUES.length).map((curve, k) => (motions.length > 1 ? { ...curve, colour: HUES[k] } : curve));
    const more = left || moving.length > curves.length ? "Those that go less far are in the table of the motions of the supports." : "";
    const note = more || (resting ? "All other supports are at rest." : "");
    return { title, unit, curves, hidden: !curves.length, note };
  }

  energy() {
    return { title: "Energy", unit: "J", curves: this.curves(Object.entries(this.facts.energies).map(([key, label]) => [`energy/${key}`, label])) };
  }

  error() {
    const { tolerance, missed, steps } = this.facts;
    return {
      title: "Solver: natural map error of each step",
      log: true,
      curves: this.curves([["error", "error"]]).map((c) => ({ ...c, value: c.value.map((v) => Math.max(v, 1e-16)) })),
      lines: [{ value: tolerance, name: `tolerance ${short(tolerance)}` }],
      marks: this.data.missed,
      note: !steps ? "" : missed ? `${missed} of ${steps} steps missed the tolerance: strokes at the top.` : `All ${steps} steps reached the tolerance.`,
    };
  }

  /* Displacements of chosen blocks, relative to the base. */
  points(chosen, component) {
    const { motion, facts } = this, axis = "xyz".indexOf(component), what = axis < 0 ? "length" : `along ${component}`;
    const curves = chosen.map(({ block, colour }) => ({
      name: facts.names[block],
      colour,
      time: motion.time,
      value: Float32Array.from(motion.time, (_, frame) => {
        const u = motion.displacement(block, frame);
        return 1e3 * (axis < 0 ? Math.hypot(...u) : u[axis]);
      }),
    }));
    this.plots.points.show({ title: `Displacement relative to the base, ${what}`, unit: "mm", curves, empty: "No block is chosen: click one in the model." });
  }

  /* Opening and sliding of a joint. */
  joint(joint) {
    const { motion, facts, data } = this, spec = { title: "Joint", hidden: joint < 0, curves: [], unit: "mm" };
    if (joint >= 0) {
      spec.title = `Joint ${joint}, ${facts.names[data.joint_a[joint]]} on ${facts.names[data.joint_b[joint]]}`;
      spec.zero = true;
      spec.curves = ["opening", "sliding"].map((name, k) => ({
        name,
        colour: HUES[k],
        time: motion.time,
        value: Float32Array.from(motion.time, (_, frame) => 1e3 * motion.length(name, data[name][joint * motion.frames + frame])),
      }));
    }
    this.plots.joint.show(spec);
  }

  at(time) { for (const plot of Object.values(this.plots)) plot.at(time); }
}
