// Draws the fingers of the page: orbit, time, fields and parts are shared by all scenes.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const INK = "#1f2933", BONE = [0.937, 0.902, 0.839], STEEL = [0.56, 0.64, 0.71];
const NARROW = 640;  // px of a scene below which words and color bar would cross
const PARTS = ["skin", "subcutaneous tissue", "bone", "other half", "pressure", "end organs", "rates", "indenter"];
const HOME = { yaw: 0.45, pitch: -0.2, zoom: 1, x: 0, y: 0 };
const view = { ...HOME };
const shown = Object.fromEntries(PARTS.map((part) => [part, part !== "other half"]));
const element = (id) => document.getElementById(id);
const times = [...new Set(data.scenes.flatMap((scene) => scene.times))].sort((a, b) => a - b);
let field = data.field, now = data.time;

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

async function unpack() {
  const packed = Uint8Array.from(atob(element("blob").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

// Vertices at one place share the normal of the first of them.
function normals(points, triangles, same) {
  const sums = new Float32Array(points.length);
  for (let k = 0; k < triangles.length; k += 3) {
    const [a, b, c] = [3 * triangles[k], 3 * triangles[k + 1], 3 * triangles[k + 2]];
    const u = [0, 1, 2].map((i) => points[b + i] - points[a + i]);
    const v = [0, 1, 2].map((i) => points[c + i] - points[a + i]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (let j = 0; j < 3; j++) for (let i = 0; i < 3; i++) sums[3 * same[triangles[k + j]] + i] += n[i];
  }
  for (let k = 0; k < same.length; k++) for (let i = 0; i < 3; i++) sums[3 * k + i] = sums[3 * same[k] + i];
  return sums;
}

const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);

class Scene {
  constructor(record, buffer) {
    this.record = record;
    this.read = ({ kind, at, count }) =>
      new { f4: Float32Array, u4: Uint32Array, u2: Uint16Array }[kind](buffer, at, count);
    const box = document.createElement("div");
    box.className = "scene";
    box.append(document.createElement("canvas"), document.createElement("canvas"));
    element("scenes").append(box);
    [this.canvas, this.paper] = box.children;
    this.gl = this.canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) throw Error("This browser has no WebGL 2, which this page draws with.");
    this.program = program(this.gl);
    this.buffers = {};
    this.maps = Object.fromEntries(Object.entries(data.maps).map(([name, colors]) => [name, this.texture(colors)]));
    this.triangles = this.read(record.triangles);
    this.same = this.read(record.same);
    const first = this.read(record.points).subarray(0, 3 * record.vertices);
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

  // End organs in the cut, or units on the skin of the whole finger.
  get marks() { return shown["end organs"] && this.record[shown["other half"] ? "units" : "organs"]; }

  get frame() {
    const away = this.record.times.map((t) => Math.abs(t - now));
    return away.indexOf(Math.min(...away));
  }

  part(place, size, frame = this.frame) { return this.read(place).subarray(frame * size, (frame + 1) * size); }

  values(name) {
    const { low, step, ...place } = this.record.values[name];
    return Float32Array.from(this.part(place, this.record.vertices), (v) => low + step * v);
  }

  attribute(name, array, size) {
    const gl = this.gl, at = gl.getAttribLocation(this.program, name);
    if (at < 0) return;
    if (!array) return gl.disableVertexAttribArray(at);
    this.buffers[name] ??= gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, gl.FLOAT, false, 0, 0);
  }

  elements(shape, indices) {
    const gl = this.gl;
    this.buffers.elements ??= gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers.elements);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.DYNAMIC_DRAW);
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
    const gl = this.gl, at = (name) => gl.getUniformLocation(this.program, name);
    const ratio = devicePixelRatio || 1;
    for (const canvas of [this.canvas, this.paper]) {
      canvas.width = Math.round(canvas.clientWidth * ratio);
      canvas.height = Math.round(canvas.clientHeight * ratio);
    }
    const { width, height } = this.canvas;
    gl.viewport(0, 0, width, height);
    const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
    // Rows: right, up and toward the eye, which is at -y when nothing is turned.
    this.turn = [[cy, sy, 0], [-sp * sy, sp * cy, cp], [cp * sy, -cp * cy, sp]];
    const scale = (view.zoom * 1.02 * Math.min(height, 0.72 * width)) / this.reach / 2;
    this.frameOf = [(2 * scale) / width, (2 * scale) / height, 2 * view.x - 0.16, 2 * view.y + 0.08];
    gl.uniformMatrix3fv(at("turn"), true, this.turn.flat());
    gl.uniform3f(at("center"), ...this.center);
    gl.uniform4f(at("frame"), ...this.frameOf);
    this.size = Math.max(12 * ratio, 0.38 * scale);
    gl.clearColor(1, 1, 1, 1);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  project(points, k) {
    const d = [0, 1, 2].map((i) => points[3 * k + i] - this.center[i]);
    const [x, y, z] = this.turn.map((row) => row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
    const [sx, sy, ox, oy] = this.frameOf;
    return [((x * sx + ox + 1) / 2) * this.canvas.width, ((1 - y * sy - oy) / 2) * this.canvas.height, z];
  }

  visible(piece) { return shown[piece.name === "pad" ? "skin" : piece.name]; }

  draw() {
    const gl = this.gl, record = this.record, frame = this.frame;
    this.look();
    this.points = this.part(record.points, 3 * record.vertices);
    this.drawn = field;
    this.nodal = this.values(field);
    const pressure = this.values("pressure"), span = data.fields[field], press = data.pressure;
    this.attribute("place", this.points, 3);
    this.attribute("normal", normals(this.points, this.triangles, this.same), 3);
    for (const piece of record.pieces.filter((each) => this.visible(each))) {
      const pressed = piece.name === "pad" && shown.pressure && field !== "pressure";
      const scale = pressed ? press : span;
      this.attribute("value", pressed ? pressure : this.nodal, 1);
      if (piece.name === "bone") this.set(PLAIN, { plain: [...BONE, 1] });
      else this.set(piece.flat || pressed ? FLAT : LIT, { span: [scale.low, scale.high], map: scale.colors });
      this.elements(gl.TRIANGLES, this.triangles.subarray(3 * piece.from, 3 * piece.to));
    }
    this.attribute("value", null);
    this.attribute("normal", null);
    if (!shown["other half"]) this.drawLines(frame);
    this.drawOrgans(frame);
    if (shown.indenter) this.drawIndenter(frame);
    this.write(frame);
  }

  drawLines(frame) {
    const { linePoints, lines } = this.record, toward = this.turn[2].map((x) => 0.03 * x);
    const points = this.part(linePoints, linePoints.count / this.record.times.length, frame);
    this.attribute("place", Float32Array.from(points, (x, i) => x + toward[i % 3]), 3);
    this.set(GLASS, { plain: [1, 1, 1, 1] });
    this.elements(this.gl.LINES, this.read(lines));
  }

  drawOrgans(frame) {
    const organs = this.marks;
    if (!organs) return;
    const gl = this.gl, count = organs.labels.length, rated = organs.rates && shown.rates;
    this.organs = this.part(organs.points, 3 * count, frame);
    const closer = this.turn[2].map((x) => (shown["other half"] ? 0.3 * x : 0));
    this.attribute("place", this.organs.map((x, i) => x + closer[i % 3]), 3);
    gl.uniform1f(gl.getUniformLocation(this.program, "size"), this.size * (count > data.few ? 0.6 : 1));
    if (rated) this.attribute("value", this.part(organs.rates, count, frame), 1);
    else this.attribute("tint", new Float32Array(organs.colors.flatMap(rgb)), 3);
    this.set(rated ? RATE : TYPE, { span: [0, data.rate], map: data.rates });
    if (!shown["other half"]) gl.disable(gl.DEPTH_TEST);  // seen through the tissue before them
    gl.drawArrays(gl.POINTS, 0, count);
    gl.enable(gl.DEPTH_TEST);
    this.attribute("value", null);
    this.attribute("tint", null);
  }

  drawIndenter(frame) {
    const gl = this.gl, { points, triangles, rim, axis } = this.record.indenter;
    const travel = this.record.depth[frame] - 0.05;  // a little away, so that nothing flickers
    this.attribute("place", Float32Array.from(this.read(points), (x, i) => x + travel * axis[i % 3]), 3);
    const cut = shown["other half"] ? -1e9 : 0, edge = this.read(rim);
    if (field !== "pressure" || !edge.length) {  // glass changes the colors behind it
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      this.set(GLASS, { plain: [...STEEL, 0.2], cut });
      this.elements(gl.TRIANGLES, this.read(triangles));
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    }
    this.set(GLASS, { plain: [0.32, 0.38, 0.43, 1], cut });
    this.elements(gl.LINES, edge);
  }

  write(frame) {
    const ratio = devicePixelRatio || 1, pen = this.paper.getContext("2d"), { record } = this;
    pen.scale(ratio, ratio);
    pen.fillStyle = INK;
    pen.font = "600 15px system-ui, sans-serif";
    const wide = this.paper.clientWidth - 28;
    pen.fillText(record.title, 14, 24, wide);
    pen.font = "14px system-ui, sans-serif";
    pen.fillText(`${record.words}: ${field}`, 14, 44, wide);
    const words = [`t = ${+record.times[frame].toPrecision(4)} s`, `depth ${record.depth[frame].toPrecision(3)} mm`];
    if (record.force) words.push(`force ${record.force[frame].toPrecision(3)} N`);
    pen.fillText(words.join(",  "), 14, 64, wide);
    const right = this.paper.clientWidth - 84, tall = this.paper.clientHeight;
    const organs = this.marks, rated = organs?.rates && shown.rates;
    const top = this.paper.clientWidth < NARROW ? 112 : 84;  // below the words, where the bar would cross them
    this.bar(pen, right, top, 0.32 * tall, field, data.fields[field]);
    const lower = 0.64 * tall, height = 0.26 * tall, pressed = shown.pressure && shown.skin && field !== "pressure";
    if (pressed) this.bar(pen, right, lower, height, "pressure", data.pressure);
    if (rated) this.bar(pen, right - (pressed ? 130 : 0), lower, height, "rate", { low: 0, high: data.rate, colors: data.rates, unit: "Hz", extend: "neither" });
    const few = organs && organs.labels.length <= data.few;
    if (few) this.label(pen, organs.labels, ratio, right - 12, top + 20);
  }

  bar(pen, x, y, height, name, { low, high, colors, unit, extend }) {
    const map = data.maps[colors];
    for (let k = 0; k < 256; k++) {
      pen.fillStyle = `rgb(${map.slice(3 * k, 3 * k + 3)})`;
      pen.fillRect(x, y + (height * (255 - k)) / 256, 18, height / 256 + 1);
    }
    pen.fillStyle = pen.strokeStyle = INK;
    pen.lineWidth = 0.5;
    pen.strokeRect(x, y, 18, height);
    pen.font = "13px system-ui, sans-serif";
    for (let k = 0; k <= 4; k++) {
      const sign = { 0: ["min", "both"].includes(extend) ? "≤ " : "", 4: ["max", "both"].includes(extend) ? "≥ " : "" }[k] || "";
      pen.fillText(sign + +(low + ((high - low) * k) / 4).toPrecision(3), x + 24, y + height * (1 - k / 4) + 5);
    }
    pen.textAlign = "right";
    pen.fillText(`${name} / ${unit}`, x + 74, y - 12);
    pen.textAlign = "left";
  }

  // Labels stand in a column on the right of all organs, or on their left where there is no room.
  label(pen, labels, ratio, right, top) {
    const places = labels.map((words, k) => [words, ...this.project(this.organs, k)])
      .filter((place) => place[0]).sort((a, b) => a[2] - b[2]);
    pen.font = "13px system-ui, sans-serif";
    pen.strokeStyle = INK;
    pen.lineWidth = 0.8;
    const across = places.map((place) => place[1] / ratio), aside = 60;
    const width = Math.max(...places.map(([words]) => pen.measureText(words).width)) + 10;
    const beyond = Math.max(...across) + aside, fits = beyond + width <= right;
    const end = fits ? beyond : Math.max(Math.min(...across) - aside, width);
    this.uncross(places, ratio, end, top);
    places.forEach(([words, x, y], row) => {
      const level = top + 22 * row, wide = pen.measureText(words).width + 10, left = fits ? end : end - wide;
      pen.beginPath();
      pen.moveTo(x / ratio + (fits ? 6 : -6), y / ratio);
      pen.lineTo(end, level);
      pen.stroke();
      pen.fillStyle = "rgba(255, 255, 255, 0.8)";
      pen.fillRect(left, level - 10, wide, 20);
      pen.fillStyle = INK;
      pen.fillText(words, left + 5, level + 4);
    });
  }

  // Swaps places (words, x, y) whose lines to the column of labels cross, until none do.
  uncross(places, ratio, across, top) {
    const side = (p, q, r) => (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    const end = (row) => [across, top + 22 * row], start = (row) => [places[row][1] / ratio, places[row][2] / ratio];
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
    const ratio = devicePixelRatio || 1, box = this.canvas.getBoundingClientRect();
    const x = (event.clientX - box.left) * ratio, y = (event.clientY - box.top) * ratio;
    let best = null, close = (14 * ratio) ** 2;
    for (const piece of this.record.pieces.filter((each) => each.name !== "bone" && this.visible(each))) {
      for (const k of new Set(this.triangles.subarray(3 * piece.from, 3 * piece.to))) {
        const [px, py, depth] = this.project(this.points, k), away = (px - x) ** 2 + (py - y) ** 2;
        if (away < close && (!best || depth > best.depth - 0.5)) [best, close] = [{ k, depth }, away];
      }
    }
    return best;
  }
}

function start(scenes) {
  const draw = () => scenes.forEach((scene) => scene.draw());
  let request = 0;
  const redraw = () => { cancelAnimationFrame(request); request = requestAnimationFrame(draw); };
  const slider = element("time"), play = element("play"), status = element("status"), stamp = element("stamp");
  const move = (number) => {
    now = times[number];
    slider.value = number;
    stamp.textContent = `${+now.toPrecision(4)} s`;
    redraw();
  };
  slider.max = times.length - 1;
  slider.addEventListener("input", () => move(+slider.value));
  let playing = 0;
  play.addEventListener("click", () => {
    clearInterval(playing);
    playing = playing ? 0 : setInterval(() => move((+slider.value + 1) % times.length), 150);
    play.textContent = playing ? "stop" : "play";
  });
  element("field").value = field;
  element("field").addEventListener("change", (event) => { field = event.target.value; redraw(); });
  for (const part of PARTS.filter((name) => there(scenes, name))) {
    const label = document.createElement("label"), box = document.createElement("input");
    [box.type, box.checked] = ["checkbox", shown[part]];
    box.addEventListener("change", () => { shown[part] = box.checked; redraw(); });
    label.append(box, part);
    element("parts").append(label);
  }
  for (const scene of scenes) steer(scene, redraw, status);
  addEventListener("resize", redraw);
  move(times.reduce((best, t, k) => (Math.abs(t - now) < Math.abs(times[best] - now) ? k : best), 0));
}

function there(scenes, part) {
  const some = (test) => scenes.some(({ record }) => test(record));
  if (part === "rates") return some((record) => record.organs?.rates);
  if (part === "end organs") return some((record) => record.organs);
  return ["pressure", "indenter"].includes(part) || some((record) => record.pieces.some((piece) => piece.name === part));
}

function steer(scene, redraw, status) {
  const canvas = scene.canvas;
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) {
      if (event.shiftKey || event.buttons > 1) {
        view.x += event.movementX / canvas.clientWidth;
        view.y -= event.movementY / canvas.clientHeight;
      } else {
        view.yaw -= event.movementX * 0.008;
        view.pitch = Math.max(-1.55, Math.min(1.55, view.pitch + event.movementY * 0.008));
      }
      return redraw();
    }
    const nearest = scene.under(event);
    if (!nearest) return;
    const [x, y, z] = scene.points.subarray(3 * nearest.k, 3 * nearest.k + 3);
    const { drawn } = scene, { unit } = data.fields[drawn];
    status.textContent = `${drawn} ${+scene.nodal[nearest.k].toPrecision(3)} ${unit} at x ${x.toFixed(2)}, y ${y.toFixed(2)}, z ${z.toFixed(2)} mm`;
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoom *= Math.exp(-event.deltaY * 0.001);
    redraw();
  }, { passive: false });
  canvas.addEventListener("dblclick", () => { Object.assign(view, HOME); redraw(); });
}

if (data.field === "pressure") {
  Object.assign(HOME, { yaw: 0.6, pitch: -0.9 });
  Object.assign(view, HOME);
  shown["other half"] = true;
}
unpack()
  .then((buffer) => start(data.scenes.map((record) => new Scene(record, buffer))))
  .catch((error) => { element("status").className = "warning"; element("status").textContent = error.message; });
