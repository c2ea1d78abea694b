/* A camera in parallel projection: lengths in the plane of the picture hold everywhere in it. z is up. */

const VIEWS = { front: [0, 0], back: [180, 0], side: [90, 0], top: [0, 90], isometric: [32, 24] }; /* turn and tilt, degrees */

class Camera {
  constructor(low, high) {
    this.low = low;
    this.high = high;
    this.size = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) || 1;
    this.turn = this.tilt = 0;
    this.aspect = 1.5;
    this.fitted = true;
    this.fit();
  }

  get right() { return [Math.cos(this.turn), Math.sin(this.turn), 0]; }

  get towards() {
    return [Math.sin(this.turn) * Math.cos(this.tilt), -Math.cos(this.turn) * Math.cos(this.tilt), Math.sin(this.tilt)];
  }

  get up() {
    return [-Math.sin(this.turn) * Math.sin(this.tilt), Math.cos(this.turn) * Math.sin(this.tilt), Math.cos(this.tilt)];
  }

  look(name) {
    const [turn, tilt] = VIEWS[name];
    this.turn = (turn * Math.PI) / 180;
    this.tilt = (tilt * Math.PI) / 180;
    this.fit();
  }

  /* Everything that stands free in view, with a margin. */
  fit() {
    this.target = this.low.map((v, k) => (v + this.high[k]) / 2);
    const half = this.low.map((v, k) => (this.high[k] - v) / 2);
    const reach = (axis) => half.reduce((sum, h, k) => sum + h * Math.abs(axis[k]), 0);
    this.height = Math.max(2.5 * reach(this.up), (2.2 * reach(this.right)) / this.aspect, 1e-6 * this.size);
    this.fitted = true;
  }

  /* A new shape of the picture; what was fitted stays so. */
  resize(aspect) {
    this.aspect = aspect;
    if (this.fitted) this.fit();
  }

  orbit(dx, dy) {
    this.turn -= dx;
    this.tilt = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.tilt + dy));
  }

  /* Moves the picture by shares of its height. */
  pan(dx, dy) {
    const { right, up } = this;
    this.target = this.target.map((v, k) => v - this.height * (dx * right[k] + dy * up[k]));
    this.fitted = false;
  }

  /* Zooms about a place in the picture, in heights from its middle; at most to a thousandth or ten times the structure. */
  zoom(by, x = 0, y = 0) {
    const height = Math.max(1e-3 * this.size, Math.min(10 * this.size, this.height * by)), moved = 1 - height / this.height;
    const { right, up } = this;
    this.target = this.target.map((v, k) => v + this.height * moved * (x * right[k] + y * up[k]));
    this.height = height;
    this.fitted = false;
  }

  /* A point in the picture: x and y from -1 to 1. */
  project(point) {
    const d = point.map((v, k) => v - this.target[k]);
    const along = (axis) => d.reduce((sum, v, k) => sum + v * axis[k], 0);
    return [(2 * along(this.right)) / (this.height * this.aspect), (2 * along(this.up)) / this.height];
  }
}
