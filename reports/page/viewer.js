/* Draws the model with WebGL 2: faces, edges and joints, each one call whatever the number of blocks. */

const PIXELS = { band: 6, least: 2.5, picked: 10 }; /* widths of bands, as in the crack map */
const SHARE = 0.2; /* of a block's smallest extent that a band may take */

class Viewer {
  constructor(canvas, facts, data) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error("This browser offers no WebGL 2, so the model cannot be drawn; plots and table below work.");
    this.gl = gl;
    this.canvas = canvas;
    this.blocks = data.fixed.length;
    this.joints = data.state.length;
    this.smallest = facts.smallest;
    this.tieInk = [1, 3, 5].map((i) => parseInt(facts.colours.tie.slice(i, i + 2), 16) / 255).concat(1);
    this.faces = this.program(FACES);
    this.lines = this.program(EDGES);
    this.bands = this.program(BANDS);
    this.meshes = { faces: this.faceMesh(data), lines: this.lineMesh(data), bands: this.bandMesh(data), ties: this.tieMesh(data) };
    this.pose = new Float32Array(4 * ACROSS * Math.ceil((TEXELS * this.blocks) / ACROSS));
    this.paint = new Uint8Array(4 * ACROSS * Math.ceil(this.blocks / ACROSS));
    this.marks = new Uint8Array(4 * ACROSS * Math.max(1, Math.ceil((2 * this.joints) / ACROSS)));
    this.textures = [this.texture(), this.texture(), this.texture()];
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  }

  program({ vertex, fragment }) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`shader: ${gl.getShaderInfoLog(shader)}`);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`shader: ${gl.getProgramInfoLog(program)}`);
    const places = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const { name } = gl.getActiveUniform(program, i);
      places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  }

  texture() {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl.NEAREST);
    return texture;
  }

  /* A mesh from attributes {name: [array, size, bytes between, offset]}; per instance where asked. */
  mesh(program, attributes, perInstance = false) {
    const gl = this.gl, mesh = gl.createVertexArray();
    gl.bindVertexArray(mesh);
    for (const [name, [array, size]] of Object.entries(attributes)) {
      const place = gl.getAttribLocation(program.program, name);
      if (place < 0) continue;
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(place);
      if (array instanceof Uint32Array) gl.vertexAttribIPointer(place, size, gl.UNSIGNED_INT, 0, 0);
      else gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
      if (perInstance) gl.vertexAttribDivisor(place, 1);
    }
    gl.bindVertexArray(null);
    return mesh;
  }

  /* All faces as triangles with a normal of their own, fans of convex loops. */
  faceMesh({ vertices, vertex_block: owner, loops, loop_start: start }) {
    const count = 3 * (loops.length - 2 * (start.length - 1));
    const point = new Float32Array(3 * count), normal = new Float32Array(3 * count), block = new Uint32Array(count);
    let at = 0;
    for (let f = 0; f + 1 < start.length; f++) {
      const n = [0, 0, 0];
      for (let i = start[f]; i < start[f + 1]; i++) { /* Newell's sum */
        const p = 3 * loops[i], q = 3 * loops[i + 1 < start[f + 1] ? i + 1 : start[f]];
        for (let k = 0; k < 3; k++) n[k] += (vertices[p + ((k + 1) % 3)] - vertices[q + ((k + 1) % 3)]) * (vertices[p + ((k + 2) % 3)] + vertices[q + ((k + 2) % 3)]);
      }
      const length = Math.hypot(...n) || 1;
      for (let i = start[f] + 1; i + 1 < start[f + 1]; i++) {
        for (const v of [loops[start[f]], loops[i], loops[i + 1]]) {
          for (let k = 0; k < 3; k++) { point[3 * at + k] = vertices[3 * v + k]; normal[3 * at + k] = n[k] / length; }
          block[at++] = owner[v];
        }
      }
    }
    this.faceCount = count;
    return this.mesh(this.faces, { point: [point, 3], normal: [normal, 3], block: [block, 1] });
  }

  lineMesh({ vertices, vertex_block: owner, edges }) {
    const point = new Float32Array(3 * edges.length), block = new Uint32Array(edges.length);
    edges.forEach((v, i) => { point.set(vertices.subarray(3 * v, 3 * v + 3), 3 * i); block[i] = owner[v]; });
    this.lineCount = edges.length;
    return this.mesh(this.lines, { point: [point, 3], block: [block, 1] });
  }

  /* A line for each tie; its ends move with the blocks that hold them. */
  tieMesh({ tie_point: point = new Float32Array(0), tie_block: block = new Uint32Array(0) }) {
    this.tieEnds = block.length;
    return this.mesh(this.lines, { point: [point, 3], block: [block, 1] });
  }

  /* One instance per side of every interface polygon. */
  bandMesh({ polygon, polygon_start: start, joint_normal, joint_a, joint_b }) {
    const count = polygon.length / 3, parts = ["corner", "next", "arm", "nextArm", "normal"].map((name) => [name, new Float32Array(3 * count)]);
    const [corner, next, arm, nextArm, normal] = parts.map((part) => part[1]), owner = new Uint32Array(3 * count);
    for (let j = 0; j + 1 < start.length; j++) {
      const middle = [0, 0, 0];
      for (let i = start[j]; i < start[j + 1]; i++) for (let k = 0; k < 3; k++) middle[k] += polygon[3 * i + k] / (start[j + 1] - start[j]);
      for (let i = start[j]; i < start[j + 1]; i++) {
        const following = i + 1 < start[j + 1] ? i + 1 : start[j];
        for (let k = 0; k < 3; k++) {
          corner[3 * i + k] = polygon[3 * i + k];
          next[3 * i + k] = polygon[3 * following + k];
          arm[3 * i + k] = polygon[3 * i + k] - middle[k];
          nextArm[3 * i + k] = polygon[3 * following + k] - middle[k];
          normal[3 * i + k] = joint_normal[3 * j + k];
        }
        owner.set([joint_a[j], joint_b[j], j], 3 * i);
        for (const a of [arm, nextArm]) {
          const length = Math.hypot(a[3 * i], a[3 * i + 1], a[3 * i + 2]) || 1;
          for (let k = 0; k < 3; k++) a[3 * i + k] /= length;
        }
      }
    }
    this.sides = count;
    return this.mesh(this.bands, { ...Object.fromEntries(parts.map(([name, array]) => [name, [array, 3]])), owner: [owner, 3] }, true);
  }

  /* Sends what has been written into pose, paint or marks. */
  send(...names) {
    const gl = this.gl;
    for (const name of names) {
      const unit = ["pose", "paint", "marks"].indexOf(name), array = this[name], floats = name === "pose";
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, this.textures[unit]);
      gl.texImage2D(gl.TEXTURE_2D, 0, floats ? gl.RGBA32F : gl.RGBA8, ACROSS, array.length / (4 * ACROSS), 0, gl.RGBA, floats ? gl.FLOAT : gl.UNSIGNED_BYTE, array);
    }
  }

  /* Makes the drawing as fine as the screen; returns its width over its height. */
  resize() {
    const { canvas } = this, ratio = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    return width / height;
  }

  use({ program, places }, camera, factor, lift) {
    const gl = this.gl, size = 8 * camera.size;
    gl.useProgram(program);
    const vectors = { right: camera.right, up: camera.up, towards: camera.towards, target: camera.target };
    for (const [name, v] of Object.entries(vectors)) gl.uniform3fv(places[name], v);
    gl.uniform2f(places.extent, (camera.height * camera.aspect) / 2, camera.height / 2);
    gl.uniform1f(places.factor, factor);
    gl.uniform1f(places.deep, size);
    gl.uniform1f(places.lift, lift);
    for (const [name, unit] of [["poses", 0], ["paint", 1], ["marks", 2]]) if (places[name]) gl.uniform1i(places[name], unit);
    return places;
  }

  bandWidth(camera, widest, share) {
    const pixel = camera.height / Math.max(1, this.canvas.clientHeight);
    return Math.max(PIXELS.least * pixel, Math.min(widest * pixel, share * this.smallest));
  }

  drawBands(camera, factor, modes, width, chosen = -1) {
    const gl = this.gl, places = this.use(this.bands, camera, factor, 2e-5);
    gl.uniform1f(places.width, width);
    gl.uniform1i(places.chosen, chosen);
    gl.uniform1i(places.firstId, this.blocks + 1);
    gl.bindVertexArray(this.meshes.bands);
    for (const mode of modes) {
      gl.uniform1i(places.mode, mode);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.sides);
    }
  }

  drawFaces(camera, factor, picking) {
    const gl = this.gl, places = this.use(this.faces, camera, factor, 0);
    gl.uniform1i(places.picking, picking ? 1 : 0);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.bindVertexArray(this.meshes.faces);
    gl.drawArrays(gl.TRIANGLES, 0, this.faceCount);
    gl.disable(gl.POLYGON_OFFSET_FILL);
  }

  drawLines(camera, factor, ink) {
    const gl = this.gl, places = this.use(this.lines, camera, factor, 1e-5);
    gl.uniform4fv(places.ink, ink);
    gl.enable(gl.BLEND);
    gl.bindVertexArray(this.meshes.lines);
    gl.drawArrays(gl.LINES, 0, this.lineCount);
    gl.disable(gl.BLEND);
  }

  /* Ties show through the walls that hide them; lines of WebGL are a pixel wide, so they are drawn side by side. */
  drawTies(camera, factor) {
    const gl = this.gl, places = this.use(this.lines, camera, factor, 2e-5), { width, height } = this.canvas;
    gl.uniform4fv(places.ink, this.tieInk);
    gl.bindVertexArray(this.meshes.ties);
    gl.disable(gl.DEPTH_TEST);
    for (const [x, y] of [[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]]) {
      gl.viewport(x, y, width, height);
      gl.drawArrays(gl.LINES, 0, this.tieEnds);
    }
    gl.viewport(0, 0, width, height);
    gl.enable(gl.DEPTH_TEST);
  }

  draw(camera, { factor, edges, rest, chosen }) {
    const gl = this.gl;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawFaces(camera, factor, false);
    const width = this.bandWidth(camera, PIXELS.band, SHARE), pixel = camera.height / Math.max(1, this.canvas.clientHeight);
    if (edges) this.drawLines(camera, factor, [0.29, 0.275, 0.25, Math.max(0.12, Math.min(0.9, this.smallest / pixel / 12))]);
    if (this.sides) this.drawBands(camera, factor, [0, 1, 2], width);
    if (rest) this.drawLines(camera, 0, [0.35, 0.45, 0.62, 0.55]);
    if (this.tieEnds) this.drawTies(camera, factor);
    if (chosen >= 0) {
      gl.disable(gl.DEPTH_TEST); /* it shows through whatever hides it */
      this.drawBands(camera, factor, [3], Math.max(width, 3 * pixel), chosen);
      gl.enable(gl.DEPTH_TEST);
    }
  }

  /* What lies at a place of the canvas, in CSS pixels: {block}, {joint} or null. */
  pick(x, y, camera, factor) {
    const gl = this.gl, { width, height } = this.canvas;
    const target = gl.createFramebuffer(), colour = gl.createRenderbuffer(), depth = gl.createRenderbuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    for (const [buffer, format, place] of [[colour, gl.RGBA8, gl.COLOR_ATTACHMENT0], [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawFaces(camera, factor, true);
    if (this.sides) this.drawBands(camera, factor, [4], this.bandWidth(camera, PIXELS.picked, 1.5 * SHARE));
    const pixel = new Uint8Array(4), scale = width / this.canvas.clientWidth;
    gl.readPixels(Math.floor(x * scale), height - 1 - Math.floor(y * scale), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    for (const buffer of [colour, depth]) gl.deleteRenderbuffer(buffer);
    gl.deleteFramebuffer(target);
    const id = pixel[0] + (pixel[1] << 8) + (pixel[2] << 16) - 1;
    if (id < 0) return null;
    return id < this.blocks ? { block: id } : { joint: id - this.blocks };
  }
}
