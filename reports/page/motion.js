/* Where blocks and joints are at a time, from the whole numbers of motion.py. */

const TEXELS = 3; /* of a block in the pose: displacement, quaternion, centre at rest */

class Motion {
  constructor(facts, data) {
    this.data = data;
    this.scales = facts.scales;
    this.time = data.time;
    this.frames = data.time.length;
    this.blocks = data.fixed.length;
    this.joints = data.state.length;
    this.most = {}; /* largest codes so far, made on first use */
  }

  get end() { return this.time[this.frames - 1]; }

  /* The frame at or before a time, and how far the time is on the way to the next one. */
  place(time) {
    let low = 0, high = this.frames - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time[middle] <= time) low = middle; else high = middle - 1;
    }
    if (low === this.frames - 1) return [low, 0];
    return [low, Math.max(0, Math.min(1, (time - this.time[low]) / (this.time[low + 1] - this.time[low])))];
  }

  /* Displacement (3) of a block at a frame [m]. */
  displacement(block, frame) {
    const { displacement: code, displacement_unit: unit } = this.data, stride = this.blocks * this.frames, i = block * this.frames + frame;
    return [code[i] * unit[block], code[i + stride] * unit[block], code[i + 2 * stride] * unit[block]];
  }

  /* The axis along which a block moves farthest. */
  mainAxis(block) {
    const most = [0, 0, 0];
    for (let frame = 0; frame < this.frames; frame++) this.displacement(block, frame).forEach((u, k) => { most[k] = Math.max(most[k], Math.abs(u)); });
    return "xyz"[most.indexOf(Math.max(...most))];
  }

  /* Quaternion (w, x, y, z) of a block at a frame. */
  quaternion(block, frame) {
    const { rotation: code, rotation_unit: unit } = this.data, stride = this.blocks * this.frames, i = block * this.frames + frame;
    const x = code[i] * unit[block], y = code[i + stride] * unit[block], z = code[i + 2 * stride] * unit[block];
    const angle = Math.hypot(x, y, z), share = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
    return [Math.cos(angle / 2), share * x, share * y, share * z];
  }

  /* Fills the poses of all blocks at a time, for the shaders; between two frames both are mixed. */
  fill(pose, time) {
    const [frame, part] = this.place(time), centre = this.data.centre;
    for (let b = 0; b < this.blocks; b++) {
      const at = 4 * TEXELS * b, u = this.displacement(b, frame), q = this.quaternion(b, frame);
      if (part > 0) {
        const v = this.displacement(b, frame + 1), r = this.quaternion(b, frame + 1);
        const sign = q[0] * r[0] + q[1] * r[1] + q[2] * r[2] + q[3] * r[3] < 0 ? -1 : 1;
        for (let k = 0; k < 3; k++) u[k] += part * (v[k] - u[k]);
        for (let k = 0; k < 4; k++) q[k] += part * (sign * r[k] - q[k]);
        const length = Math.hypot(...q) || 1;
        for (let k = 0; k < 4; k++) q[k] /= length;
      }
      for (let k = 0; k < 3; k++) { pose[at + k] = u[k]; pose[at + 8 + k] = centre[3 * b + k]; }
      for (let k = 0; k < 4; k++) pose[at + 4 + k] = q[k];
      pose[at + 3] = this.data.absent ? this.flag("absent", b, frame) : 0;
    }
  }

  /* The codes (J, F) of a measure, or the largest up to each frame; at the last one that of all time steps. */
  codes(name, most) {
    const codes = this.data[name];
    if (!most) return codes;
    if (!this.most[name]) {
      const out = codes.slice();
      for (let i = 1; i < out.length; i++) if (i % this.frames && out[i] < out[i - 1]) out[i] = out[i - 1];
      const peak = this.data[`${name}_peak`]; /* of all steps; between two frames more may have happened than they show */
      for (let j = 0, i = this.frames - 1; j < this.joints; j++, i += this.frames) if (out[i] < peak[j]) out[i] = peak[j];
      this.most[name] = out;
    }
    return this.most[name];
  }

  /* Class of a code in the colour scale of a measure, -1 below the threshold. */
  rank(name, code) {
    const bounds = this.scales[name].codes;
    let rank = -1;
    while (rank + 1 < bounds.length && code >= bounds[rank + 1]) rank++;
    return rank;
  }

  /* What a code stands for [m]. */
  length(name, code) {
    const scale = this.scales[name];
    return code === 0 ? 0 : scale.lowest * Math.exp((code - 0.5) / scale.per_e);
  }

  flag(name, index, frame) {
    const row = Math.ceil((name === "separated" ? this.joints : this.blocks) / 8);
    return (this.data[name][frame * row + (index >> 3)] >> (index & 7)) & 1;
  }
}
