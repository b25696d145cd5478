// Draws a finger with WebGL. A subclass of Scene says where its vertices are and what color they have: `places`,
// `values(field)`, `linePlaces`, `marks` with `organPlaces` and `rates`, the `depth` of the object, and `words`.
"use strict";
const INK = "#1f2933", BONE = [0.937, 0.902, 0.839], STEEL = [0.56, 0.64, 0.71];
const PLATE = "rgba(255, 255, 255, 0.8)";  // behind words
const NARROW = 640;  // px of a scene below which words and color bar would cross
const PAPER = { willReadFrequently: true };  // drawn without the graphics card, whose emulation is slow at lines
const element = (id) => document.getElementById(id);

const VERTEX = `#version 300 es
in vec3 place; in vec3 normal; in float value; in vec3 tint;
uniform mat3 turn; uniform vec3 center; uniform vec4 frame; uniform vec2 range; uniform float size;
out float at; out float aside; out vec3 facing; out vec3 color;
void main() {
  vec3 p = turn * (place - center);
  at = (value - range.x) / (range.y - range.x);
  facing = turn * normal; color = tint; aside = place.y;
  gl_Position = vec4(p.x * frame.x + frame.z, p.y * frame.y + frame.w, -p.z * 0.02, 1.0);
  gl_PointSize = size;
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in float at; in float aside; in vec3 facing; in vec3 color; out vec4 result;
uniform sampler2D map; uniform vec4 plain; uniform int mode; uniform float cut;
void main() {
  if (aside < cut) discard;
  vec3 c = plain.rgb; float alpha = 1.0;
  if (mode == 0 || mode == 1 || mode == 4) c = texture(map, vec2(clamp(at, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
  if (mode == 1 || mode == 2) c *= 0.66 + 0.34 * abs(normalize(facing).z);
  if (mode == 3) alpha = plain.a;
  if (mode >= 4) {
    float r = length(gl_PointCoord - 0.5);
    if (r > 0.5) discard;
    if (mode == 5) c = color;
    if (r > 0.37) c = vec3(1.0);
  }
  result = vec4(c, alpha);
}`;
const FLAT = 0, LIT = 1, PLAIN = 2, GLASS = 3, RATE = 4, TYPE = 5;  // of FRAGMENT

function program(gl) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  gl.useProgram(made);
  return made;
}

// Vertices at one place share the normal of the first of them.
function normals(points, triangles, same) {
  const sums = new Float32Array(points.length);
  for (let k = 0; k < triangles.length; k += 3) {
    const a = 3 * triangles[k], b = 3 * triangles[k + 1], c = 3 * triangles[k + 2];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (let j = 0; j < 3; j++) {
      const to = 3 * same[triangles[k + j]];
      sums[to] += x;
      sums[to + 1] += y;
      sums[to + 2] += z;
    }
  }
  for (let k = 0; k < same.length; k++) {
    const to = 3 * k, from = 3 * same[k];
    sums[to] = sums[from];
    sums[to + 1] = sums[from + 1];
    sums[to + 2] = sums[from + 2];
  }
  return sums;
}

// An empty canvas, its unit a pixel of the page: returns its pen.
function sheet(canvas) {
  const ratio = devicePixelRatio || 1, pen = canvas.getContext("2d", PAPER);
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  pen.scale(ratio, ratio);
  return pen;
}

const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);

class Scene {
  static context = { preserveDrawingBuffer: true };

  constructor(box, record, buffer, data, state) {
    Object.assign(this, { record, data, state });
    this.read = ({ kind, at, count }) =>
      new { f4: Float32Array, u4: Uint32Array, u2: Uint16Array }[kind](buffer, at, count);
    box.className = "scene";
    box.replaceChildren(document.createElement("canvas"), document.createElement("canvas"));
    [this.canvas, this.paper] = box.children;
    this.gl = this.canvas.getContext("webgl2", { alpha: false, antialias: true, ...this.constructor.context });
    if (!this.gl) throw Error("This browser has no WebGL 2, which this page draws with.");
    this.program = program(this.gl);
    [this.buffers, this.indices, this.columns] = [{}, {}, {}];
    this.maps = Object.fromEntries(Object.entries(data.maps).map(([name, colors]) => [name, this.texture(colors)]));
    this.triangles = this.read(record.triangles);
    this.same = this.read(record.same);
    const first = this.read(record.rest ?? record.points).subarray(0, 3 * record.vertices);
    const low = [1e9, 1e9, 1e9], high = [-1e9, -1e9, -1e9];
    first.forEach((x, i) => { low[i % 3] = Math.min(low[i % 3], x); high[i % 3] = Math.max(high[i % 3], x); });
    this.center = [0, 1, 2].map((i) => (low[i] + high[i]) / 2);
    this.center[1] = 0;
    this.reach = Math.hypot(high[0] - low[0], high[2] - low[2]) / 2;
  }

  texture(colors) {
    const gl = this.gl, made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(colors));
    for (const name of ["MIN_FILTER", "MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl["TEXTURE_" + name], gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    return made;
  }

  // Fills a buffer; all of a frame are filled before anything is drawn, as graphics cards like it.
  fill(buffer, array) {
    const gl = this.gl;
    this.buffers[buffer] ??= gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[buffer]);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.DYNAMIC_DRAW);
  }

  // Reads an attribute of the shader from a buffer, or leaves it out.
  attribute(name, buffer, size) {
    const gl = this.gl, at = gl.getAttribLocation(this.program, name);
    if (at < 0) return;
    if (!buffer) return gl.disableVertexAttribArray(at);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[buffer]);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
  }

  // Draws shapes between vertices; the indices of a name stay what they are first.
  elements(shape, name, indices) {
    const gl = this.gl, known = this.indices[name];
    this.indices[name] ??= gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices[name]);
    if (!known) gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    gl.drawElements(shape, indices.length, gl.UNSIGNED_INT, 0);
  }

  set(mode, { span, map, plain = [1, 1, 1, 1], cut = -1e9 } = {}) {
    const gl = this.gl, at = (name) => gl.getUniformLocation(this.program, name);
    gl.uniform1i(at("mode"), mode);
    gl.uniform1f(at("cut"), cut);
    gl.uniform4f(at("plain"), ...plain);
    if (span) gl.uniform2f(at("range"), ...span);
    if (map) gl.bindTexture(gl.TEXTURE_2D, this.maps[map]);
  }

  look() {
    const gl = this.gl, at = (name) => gl.getUniformLocation(this.program, name), { view } = this.state;
    const { canvas, fineness } = this;
    [this.wide, this.tall] = [canvas.clientWidth, canvas.clientHeight];
    const width = Math.round(this.wide * fineness), height = Math.round(this.tall * fineness);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    gl.viewport(0, 0, width, height);
    const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
    // Rows: right, up and toward the eye, which is at -y when nothing is turned.
    this.turn = [[cy, sy, 0], [-sp * sy, sp * cy, cp], [cp * sy, -cp * cy, sp]];
    const scale = (view.zoom * 1.02 * Math.min(height, 0.72 * width)) / this.reach / 2;
    this.frameOf = [(2 * scale) / width, (2 * scale) / height, 2 * view.x - 0.16, 2 * view.y + 0.08];
    gl.uniformMatrix3fv(at("turn"), true, this.turn.flat());
    gl.uniform3f(at("center"), ...this.center);
    gl.uniform4f(at("frame"), ...this.frameOf);
    this.size = Math.max(12 * fineness, 0.38 * scale);
    gl.clearColor(1, 1, 1, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  // Place of a point in pixels of the page, and how close to the eye it is.
  project(points, k) {
    const d = [0, 1, 2].map((i) => points[3 * k + i] - this.center[i]);
    const [x, y, z] = this.turn.map((row) => row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
    const [sx, sy, ox, oy] = this.frameOf;
    return [((x * sx + ox + 1) / 2) * this.wide, ((1 - y * sy - oy) / 2) * this.tall, z];
  }

  get fineness() { return devicePixelRatio || 1; }  // pixels of the picture along one of the page

  get normals() { return normals(this.points, this.triangles, this.same); }

  visible(piece) { return this.state.shown[piece.name === "pad" ? "skin" : piece.name]; }

  draw() {
    this.paint();
    this.write();
  }

  paint() {
    const { gl, record, data } = this, { shown, field } = this.state;
    this.look();
    this.points = this.places;
    this.drawn = field;
    this.nodal = this.values(field);
    const span = data.fields[field], press = data.pressure;
    this.fillAll();
    this.attribute("place", "places", 3);
    this.attribute("normal", "normals", 3);
    if (this.closed) gl.enable(gl.CULL_FACE);
    for (const piece of record.pieces.filter((each) => this.visible(each))) {
      const pressed = piece.name === "pad" && shown.pressure && field !== "pressure";
      const scale = pressed ? press : span;
      this.attribute("value", pressed ? "pressure" : "nodal", 1);
      if (piece.name === "bone") this.set(PLAIN, { plain: [...BONE, 1] });
      else this.set(piece.flat || pressed ? FLAT : LIT, { span: [scale.low, scale.high], map: scale.colors });
      this.elements(gl.TRIANGLES, piece.from, this.triangles.subarray(3 * piece.from, 3 * piece.to));
    }
    gl.disable(gl.CULL_FACE);
    this.attribute("value", null);
    this.attribute("normal", null);
    if (!shown["other half"]) this.drawLines();
    this.drawOrgans();
    if (shown.indenter) this.drawIndenter();
  }

  fillAll() {
    const { shown } = this.state, { points, axis } = this.record.indenter, organs = this.marks;
    this.fill("places", this.points);
    this.fill("normals", this.normals);
    this.fill("nodal", this.nodal);
    this.fill("pressure", this.values("pressure"));
    const toward = this.turn[2].map((x) => 0.03 * x);
    this.fill("outlines", Float32Array.from(this.linePlaces, (x, i) => x + toward[i % 3]));
    const travel = this.depth - 0.05;  // a little away, so that nothing flickers
    this.fill("object", Float32Array.from(this.read(points), (x, i) => x + travel * axis[i % 3]));
    if (!organs) return;
    this.organs = this.organPlaces;
    const closer = this.turn[2].map((x) => (shown["other half"] ? 0.3 * x : 0)), rates = shown.rates && this.rates;
    this.fill("organs", this.organs.map((x, i) => x + closer[i % 3]));
    if (rates) this.fill("rates", rates);
    else this.fill("tints", new Float32Array(organs.colors.flatMap(rgb)));
  }

  drawLines() {
    this.attribute("place", "outlines", 3);
    this.set(GLASS, { plain: [1, 1, 1, 1] });
    this.elements(this.gl.LINES, "outlines", this.read(this.record.lines));
  }

  drawOrgans() {
    const organs = this.marks, { data } = this, { shown } = this.state;
    if (!organs) return;
    const gl = this.gl, count = organs.labels.length, rates = shown.rates && this.rates;
    this.attribute("place", "organs", 3);
    gl.uniform1f(gl.getUniformLocation(this.program, "size"), this.size * (count > data.few ? 0.6 : 1));
    if (rates) this.attribute("value", "rates", 1);
    else this.attribute("tint", "tints", 3);
    this.set(rates ? RATE : TYPE, rates ? { span: [0, data.rate], map: data.rates } : {});
    if (!shown["other half"]) gl.disable(gl.DEPTH_TEST);  // seen through the tissue before them
    gl.drawArrays(gl.POINTS, 0, count);
    gl.enable(gl.DEPTH_TEST);
    this.attribute("value", null);
    this.attribute("tint", null);
  }

  drawIndenter() {
    const gl = this.gl, { triangles, rim } = this.record.indenter, { shown, field } = this.state;
    this.attribute("place", "object", 3);
    const cut = shown["other half"] ? -1e9 : 0, edge = this.read(rim);
    if (field !== "pressure" || !edge.length) {  // glass changes the colors behind it
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      this.set(GLASS, { plain: [...STEEL, 0.2], cut });
      this.elements(gl.TRIANGLES, "indenter", this.read(triangles));
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    }
    this.set(GLASS, { plain: [0.32, 0.38, 0.43, 1], cut });
    this.elements(gl.LINES, "rim", edge);
  }

  write() {
    const pen = sheet(this.paper), { data } = this, { shown, field } = this.state;
    pen.fillStyle = INK;
    const wide = this.paper.clientWidth - 28;
    this.words.forEach((words, row) => {
      pen.font = row ? "14px system-ui, sans-serif" : "600 15px system-ui, sans-serif";
      pen.fillText(words, 14, 24 + 20 * row, wide);
    });
    const right = this.paper.clientWidth - 84, tall = this.paper.clientHeight;
    const organs = this.marks, rated = organs && shown.rates && this.rates;
    const top = this.paper.clientWidth < NARROW ? 112 : 84;  // below the words, where the bar would cross them
    const pressed = shown.pressure && shown.skin && field !== "pressure";
    const upper = pressed || rated ? Math.min(0.32 * tall, (tall - top) / 2 - 34) : 0.32 * tall;
    this.bar(pen, right, top, upper, field, data.fields[field]);
    const lower = Math.max(0.64 * tall, top + upper + 44), height = Math.min(0.26 * tall, tall - lower - 12);
    if (pressed) this.bar(pen, right, lower, height, "pressure", data.pressure);
    if (rated) this.bar(pen, right - (pressed ? 130 : 0), lower, height, "rate", { low: 0, high: data.rate, colors: data.rates, unit: "Hz", extend: "neither" });
    const few = organs && this.organs && organs.labels.length <= data.few;  // those of a picture already drawn
    if (few) this.label(pen, organs.labels, right - 12, top + 20);
  }

  bar(pen, x, y, height, name, { low, high, colors, unit, extend }) {
    pen.drawImage(this.shades(colors), x, y, 18, height);
    pen.fillStyle = pen.strokeStyle = INK;
    pen.lineWidth = 0.5;
    pen.strokeRect(x, y, 18, height);
    pen.font = "13px system-ui, sans-serif";
    for (let k = 0; k <= 4; k++) {
      const sign = { 0: ["min", "both"].includes(extend) ? "≤ " : "", 4: ["max", "both"].includes(extend) ? "≥ " : "" }[k] || "";
      pen.fillText(sign + +(low + ((high - low) * k) / 4).toPrecision(3), x + 24, y + height * (1 - k / 4) + 5);
    }
    const title = `${name} / ${unit}`, wide = pen.measureText(title).width;
    pen.fillStyle = PLATE;  // what is drawn may lie behind it
    pen.fillRect(x + 71 - wide, y - 26, wide + 6, 19);
    pen.fillStyle = INK;
    pen.fillText(title, x + 74 - wide, y - 12);
  }

  // A column of pixels with the colors of a map, the highest on top.
  shades(colors) {
    if (this.columns[colors]) return this.columns[colors];
    const canvas = document.createElement("canvas"), map = this.data.maps[colors], count = map.length / 3;
    [canvas.width, canvas.height] = [1, count];
    const pen = canvas.getContext("2d"), pixels = pen.createImageData(1, count);
    for (let k = 0; k < count; k++) pixels.data.set([...map.slice(3 * k, 3 * k + 3), 255], 4 * (count - 1 - k));
    pen.putImageData(pixels, 0, 0);
    return (this.columns[colors] = canvas);
  }

  // Labels stand in a column on the right of all organs, or on their left where there is no room.
  label(pen, labels, right, top) {
    const places = labels.map((words, k) => [words, ...this.project(this.organs, k)])
      .filter((place) => place[0]).sort((a, b) => a[2] - b[2]);
    pen.font = "13px system-ui, sans-serif";
    pen.strokeStyle = INK;
    pen.lineWidth = 0.8;
    const across = places.map((place) => place[1]), aside = 60;
    const width = Math.max(...places.map(([words]) => pen.measureText(words).width)) + 10;
    const beyond = Math.max(...across) + aside, fits = beyond + width <= right;
    const end = fits ? beyond : Math.max(Math.min(...across) - aside, width);
    this.uncross(places, end, top);
    places.forEach(([words, x, y], row) => {
      const level = top + 22 * row, wide = pen.measureText(words).width + 10, left = fits ? end : end - wide;
      pen.beginPath();
      pen.moveTo(x + (fits ? 6 : -6), y);
      pen.lineTo(end, level);
      pen.stroke();
      pen.fillStyle = PLATE;
      pen.fillRect(left, level - 10, wide, 20);
      pen.fillStyle = INK;
      pen.fillText(words, left + 5, level + 4);
    });
  }

  // Swaps places (words, x, y) whose lines to the column of labels cross, until none do.
  uncross(places, across, top) {
    const side = (p, q, r) => (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    const end = (row) => [across, top + 22 * row], start = (row) => places[row].slice(1, 3);
    for (let swapped = true; swapped;) {
      swapped = false;
      for (let i = 0; i < places.length; i++) for (let j = 0; j < i; j++) {
        const [a, b, c, d] = [start(i), end(i), start(j), end(j)];
        if (side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0) {
          [places[i], places[j]] = [places[j], places[i]];
          swapped = true;
        }
      }
    }
  }

  // Returns the vertex next to the pointer that is seen there, and its place on the screen.
  under(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    let best = null, close = 14 ** 2;
    for (const piece of this.record.pieces.filter((each) => each.name !== "bone" && this.visible(each))) {
      for (const k of new Set(this.triangles.subarray(3 * piece.from, 3 * piece.to))) {
        const [px, py, depth] = this.project(this.points, k), away = (px - x) ** 2 + (py - y) ** 2;
        if (away < close && (!best || depth > best.depth - 0.5)) [best, close] = [{ k, depth }, away];
      }
    }
    return best;
  }
}
