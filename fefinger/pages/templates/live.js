// The page of `fefinger live`: sends what the hand does, and draws the frames that come back.
const data = JSON.parse(element("data").textContent);
const WINDOW = 4, RATED = 0.5;  // s on the charts, and s that rates are taken over
const NOTCH = 0.03, KEY = 0.02, CLEAR = -0.5;  // shares of the most that a notch and a key add; mm of a lifted object
const NEAR = 0.7, CHARTS = 60;  // pixels below which a point is left out; ms between two drawings of a chart
const REST = 250, SLOW = 28, BATCH = 8;  // ms after which all is still; ms that a frame may take to be drawn; frames that are judged at once
const COARSEST = 0.5, finest = () => Math.max(2, devicePixelRatio || 1);  // pixels of a picture along one of the page
const MOST_CLICKS = 30;  // spikes of a frame that are heard
const PITCH = { SAII: 330, SAI: 550, FAI: 880, FAII: 1320 };  // Hz
const PARTS = ["skin", "subcutaneous tissue", "bone", "pressure", "end organs", "indenter"];
const HOMES = { section: { yaw: 0.45, pitch: -0.2, zoom: 0.95, x: 0, y: 0 }, pad: { yaw: 0.6, pitch: -0.95, zoom: 0.95, x: 0, y: 0 } };
const parts = (extra) => Object.fromEntries([...PARTS, ...extra].map((part) => [part, true]));
const states = {
  section: { view: { ...HOMES.section }, shown: parts([]), field: "compressive strain" },
  pad: { view: { ...HOMES.pad }, shown: { ...parts(["other half"]), "end organs": false }, field: "pressure" },
};
const socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/#.*$/, "") + "socket");
socket.binaryType = "arraybuffer";
let shape = null, scenes = [], frame = null, requested = 0, wanted = null;
let trace = [], spikes = [];
const dragged = new Map();

// How finely what moves is drawn: more coarsely where drawing delays the frames, and finer again where it does not,
// after a while that doubles with every time that finer was too slow.
const pace = {
  fineness: finest(), slow: 0, count: 0, quick: 0, patience: 4,
  note(taken) {
    this.slow += taken > SLOW;
    if (++this.count < BATCH) return;
    const late = this.slow > 1;
    [this.slow, this.count, this.quick] = [0, 0, late ? 0 : this.quick + 1];
    if (late && this.fineness > COARSEST) {
      this.fineness = Math.max(COARSEST, this.fineness / Math.SQRT2);
      this.patience = Math.min(64, 2 * this.patience);
    } else if (this.quick >= this.patience) {
      this.fineness = Math.min(finest(), this.fineness * Math.SQRT2);
      this.quick = 0;
    }
  },
};

class LiveScene extends Scene {
  static context = { preserveDrawingBuffer: false, antialias: false };  // at rest four pixels are one of the screen

  get fineness() { return still ? finest() : pace.fineness; }

  get hollow() { return this.state.shown["other half"] && this.turn[2][0] <= 0; }  // its cut end is seen

  get closed() { return !this.hollow; }  // backs of triangles are not seen

  get normals() { return (frame.normals ??= super.normals); }

  // The whole finger hides its inside, but from the end that is cut off.
  visible(piece) {
    const inside = piece.flat || piece.name === "subcutaneous tissue" || piece.name === "bone";
    return super.visible(piece) && !(inside && this.state.shown["other half"] && !this.hollow);
  }

  get places() { return frame.places; }

  get linePlaces() { return frame.lines; }

  get organPlaces() { return frame.organs; }

  get marks() { return this.state.shown["end organs"] && this.record; }

  get rates() { return null; }

  get depth() { return frame.depth; }

  values(name) { return name === "pressure" ? frame.pressure : frame.strain; }

  get words() {
    if (this.state.field === "pressure") return ["pad", `contact area ${frame.area.toFixed(1)} mm²`];
    return [`${frame.force.toFixed(3)} N`, `at ${frame.depth.toFixed(3)} mm`, `t = ${frame.time.toFixed(2)} s`];
  }
}

const send = (message) => { if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); };
const say = (text, bad = false) => {
  element("status").textContent = text;
  element("status").className = bad ? "warning" : "quiet";
};

// The shape of a new finger; its arrays follow as the next binary message.
function prepare(message, buffer) {
  shape = message;
  frame = drawn = null;
  shape.pressure = shape.fields.pressure;
  shape.rates = null;
  scenes = ["section", "pad"].map((id) => {
    const scene = new LiveScene(element(id), shape, buffer, shape, states[id]);
    element(id).className = "scene";
    return scene;
  });
  const { depth, force } = shape.most;
  Object.assign(element("depth"), { min: CLEAR, max: depth });
  element("force").max = force;
  forget();
  say("Press the finger.");
  element("notes").textContent = shape.notes.join(" ");
  element("save").title = shape.saves ? "" : "start fefinger live with -o DIR to save";
  fill(shape.setup);
}

function forget() { trace = []; spikes = []; }

// A frame: lengths, a JSON text, the trace since the last frame, and the arrays of the picture.
function unpack(buffer) {
  const [text, traced] = new Uint32Array(buffer, 0, 2);
  const state = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, text)));
  const values = new Float32Array(buffer, 8 + text + 4 * traced);
  let from = 0;
  const take = (count) => values.subarray(from, from += count);
  const n = shape.vertices;
  const picture = { places: take(3 * n), strain: take(n), pressure: take(n), lines: take(3 * shape.lineCount), organs: take(3 * shape.labels.length) };
  return { ...state, ...picture, trace: new Float32Array(buffer, 8 + text, traced) };
}

function arrive(buffer) {
  const before = frame;
  frame = unpack(buffer);
  if (before && frame.time < before.time) forget();
  for (let k = 0; k < frame.trace.length; k += 3) trace.push(frame.trace.subarray(k, k + 3));
  spikes.push(...frame.spikes);
  const since = frame.time - WINDOW;
  trace = trace.slice(Math.max(0, trace.findIndex(([t]) => t >= since)));
  spikes = spikes.filter(([, t]) => t >= since);
  sound(frame.spikes);
  redraw();
}

let asked = 0, moved = 0, painted = 0;  // ms: when a picture was asked for, last changed by the hand, last drawn
let turn = 0;  // the picture that is drawn next, where one is at a time
let drawn = null, still = false;  // the frame that is shown, null where it has to be drawn anew; all is at rest
const renew = () => { drawn = null; redraw(); };

function redraw() {
  if (requested) return;
  asked = performance.now();
  requested = requestAnimationFrame(draw);
}

function draw() {
  requested = 0;
  if (!frame) return;
  if (wanted) send({ kind: "move", ...wanted });
  wanted = null;
  send({ kind: "drawn" });  // the next frame is computed while this one is drawn
  const now = performance.now(), driven = !drawn || frame.control !== drawn.control || differ("value", 0.001 * shape.most[frame.control]);
  if (driven) {
    const since = asked;
    if (!still) setTimeout(() => pace.note(performance.now() - since));  // after the browser has drawn it
    moved = now;
  }
  const rests = now - moved > REST, changed = driven || differ("depth", 0.001) || differ("force", 0.004 * shape.most.force);
  if (rests ? !still || (changed && now - painted > REST) : changed) {
    [still, drawn, painted] = [rests, frame, now];
    // Section and pad by turns where both at once would be slow.
    const both = still || pace.fineness >= 1;
    turn = 1 - turn;
    for (const scene of both ? scenes : [scenes[turn]]) scene.paint();
  }
  // Words and charts by turns, so that no frame bears all of them.
  const due = written.filter((each) => now - each.at > CHARTS).sort((a, b) => a.at - b.at).slice(0, 2);
  for (const each of due) {
    each.at = now;
    each.write();
  }
}

const differ = (name, least) => Math.abs(frame[name] - drawn[name]) > least;

const written = [() => scenes[0].write(), () => scenes[1].write(), timeChart, depthChart, rasterChart, tools].map((write) => ({ write, at: 0 }));

function tools() {
  element("depth-now").textContent = `${frame.depth.toFixed(3)} mm`;
  element("force-now").textContent = `${frame.force.toFixed(3)} N`;
  if (!held("depth")) element("depth").value = frame.depth;
  if (!held("force")) element("force").value = frame.force;
  const record = element("record");
  record.setAttribute("aria-pressed", frame.recording);
  record.textContent = frame.recording ? "stop" : "record";
  element("recorded").textContent = frame.recorded ? `${frame.recorded.toFixed(1)} s recorded` : "";
  element("save").disabled = !frame.recorded || !shape.saves;
  const lost = frame.lost > 0.05 ? `, ${frame.lost.toFixed(1)} s lost so far` : "";
  const slow = frame.pace < 0.99;
  element("pace").textContent = slow ? `runs at ${frame.pace.toFixed(2)} of real time${lost}` : `keeps time${lost}`;
  for (const [kind, rate] of Object.entries(rates())) element(`rate-${kind}`).textContent = `${rate.toFixed(0)} Hz`;
}

// Mean rate in Hz of the units of each type.
function rates() {
  const counts = {}, units = {};
  for (const kind of shape.types) [counts[kind], units[kind]] = [0, (units[kind] || 0) + 1];
  for (const [unit, t] of spikes) if (t > frame.time - RATED) counts[shape.types[unit]]++;
  return Object.fromEntries(Object.keys(counts).map((kind) => [kind, counts[kind] / RATED / units[kind]]));
}

// A canvas with axes: returns its pen, and functions from values to places.
function axes(id, [x0, x1], [y0, y1], label, bottom) {
  const canvas = element(id), pen = sheet(canvas), wide = canvas.clientWidth, tall = canvas.clientHeight;
  pen.font = "12px system-ui, sans-serif";
  pen.fillStyle = INK;
  const [left, right, top, below] = [44, wide - 10, 26, tall - 22];
  pen.fillText(label, 8, 14);
  pen.textAlign = "right";
  pen.fillText(bottom, right, tall - 6);
  pen.strokeStyle = "#c6ced6";
  pen.strokeRect(left, top, right - left, below - top);
  const x = (value) => left + ((value - x0) / (x1 - x0)) * (right - left);
  const y = (value) => below - ((value - y0) / (y1 - y0)) * (below - top);
  return { pen, x, y, left, right, top, below };
}

function line({ pen, x, y, left, right, top, below }, points, color) {
  pen.save();
  pen.beginPath();
  pen.rect(left, top, right - left, below - top);
  pen.clip();
  pen.beginPath();
  let [u, v] = [-9, -9];
  for (const [a, b] of points) {
    const [c, d] = [x(a), y(b)];
    if (Math.abs(c - u) + Math.abs(d - v) > NEAR) pen.lineTo(u = c, v = d);
  }
  pen.strokeStyle = color;
  pen.lineWidth = 1.5;
  pen.stroke();
  pen.restore();
}

function ticks({ pen, y, left }, values) {
  pen.textAlign = "right";
  for (const value of values) pen.fillText(+value.toPrecision(2), left - 4, y(value) + 4);
}

const span = () => [frame.time - WINDOW, frame.time];
const most = () => Math.max(1.1 * shape.most.force, ...trace.map((row) => row[2]));

function timeChart() {
  const high = most(), deepest = shape.most.depth;
  const chart = axes("time", span(), [0, high], "force / N, depth in gray", `last ${WINDOW} s`);
  line(chart, trace.map(([t, depth]) => [t, (depth / deepest) * high]), "#8b98a5");
  line(chart, trace.map(([t, , force]) => [t, force]), "#0b5c8e");
  ticks(chart, [0, high / 2, high]);
}

function depthChart() {
  const deepest = shape.most.depth;
  const chart = axes("depths", [CLEAR, deepest], [0, most()], "force / N", `depth / mm, ${CLEAR} to ${deepest}`);
  line(chart, trace.map(([, depth, force]) => [depth, force]), "#0b5c8e");
  chart.pen.fillStyle = "#0b5c8e";
  chart.pen.fillRect(chart.x(frame.depth) - 2, chart.y(frame.force) - 2, 4, 4);  // now
}

// A tick a spike, the units of a type together.
function rasterChart() {
  const chart = axes("raster", span(), [0, shape.types.length], `${shape.types.length} units`, `last ${WINDOW} s`);
  const { pen, x, y, left, top, below } = chart;
  const rows = shape.types.map((kind, unit) => [Object.keys(data.colors).indexOf(kind), unit]).sort((a, b) => b[0] - a[0] || a[1] - b[1]);
  const row = [];
  rows.forEach(([, unit], k) => { row[unit] = k; });
  const high = Math.max(2, 0.7 * (below - top) / rows.length);
  for (const [unit, t] of spikes) {
    pen.fillStyle = data.colors[shape.types[unit]];
    pen.fillRect(x(t), y(row[unit] + 0.5) - high / 2, 1.5, high);
  }
  pen.textAlign = "right";
  for (const kind of Object.keys(data.colors)) {
    const own = rows.map(([, unit], k) => [shape.types[unit], k]).filter(([each]) => each === kind).map(([, k]) => k);
    if (!own.length) continue;
    pen.fillStyle = data.colors[kind];
    pen.fillText(kind, left - 4, y((own[0] + own[own.length - 1] + 1) / 2) + 4);
  }
}

// Clicks, one a spike, of the types that are on.
let speaker = null;
const clicks = {};

function sound(fired) {
  const on = new Set([...document.querySelectorAll(".sound:checked")].map((box) => box.value));
  if (!on.size || !speaker || !fired.length) return;
  const heard = fired.filter(([unit]) => on.has(shape.types[unit])).slice(0, MOST_CLICKS);
  for (const [unit, t] of heard) {
    const source = speaker.createBufferSource();
    source.buffer = click(shape.types[unit]);
    source.connect(speaker.destination);
    source.start(speaker.currentTime + Math.max(0, 0.05 + t - frame.time));
  }
}

function click(kind) {
  if (clicks[kind]) return clicks[kind];
  const rate = speaker.sampleRate, made = speaker.createBuffer(1, Math.round(0.01 * rate), rate), wave = made.getChannelData(0);
  for (let k = 0; k < wave.length; k++) wave[k] = 0.25 * Math.exp(-k / (0.002 * rate)) * Math.sin((2 * Math.PI * PITCH[kind] * k) / rate);
  clicks[kind] = made;
  return made;
}

for (const box of document.querySelectorAll(".sound")) {
  element(`color-${box.value}`).style.background = data.colors[box.value];
  box.addEventListener("change", () => { speaker ??= new AudioContext(); speaker.resume(); });
}

// The hand: where the object is to be, in mm or N.
const control = () => element("control").value;
const reach = (name) => [name === "depth" ? CLEAR : 0, shape.most[name]];
const held = (id) => document.activeElement === element(id) && element(id).matches(":active");

function aim(name, value) {
  const [low, high] = reach(name);
  wanted = { control: name, value: Math.min(high, Math.max(low, value)) };
  redraw();
}

function push(share) {
  if (!frame) return;
  const name = control(), from = wanted?.control === name ? wanted.value : goal(name);
  aim(name, from + share * shape.most[name]);
  aimed = { name, value: wanted.value, at: performance.now() };
}

// The last goal while the object is still on its way there, or where it is.
let aimed = null;

function goal(name) {
  if (aimed?.name === name && performance.now() - aimed.at < 400) return aimed.value;
  return name === "depth" ? frame.depth : frame.force;
}

for (const name of ["depth", "force"]) {
  element(name).addEventListener("input", (event) => { if (frame) aim(name, +event.target.value); });
  element(name).addEventListener("change", () => { element("control").value = name; });
}
const lift = () => { aimed = null; if (frame) aim(control(), reach(control())[0]); };
element("lift").addEventListener("click", lift);
for (const button of document.querySelectorAll(".preset")) {
  button.addEventListener("click", () => send({ kind: "play", name: button.value }));
}
element("record").addEventListener("click", () => send({ kind: "record", on: !frame?.recording }));
element("save").addEventListener("click", () => send({ kind: "save" }));

function dragTo(scene, id, event) {
  const before = dragged.get(event.pointerId), box = scene.canvas.getBoundingClientRect();
  if (!before || !frame) return;
  const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
  dragged.set(event.pointerId, { x: event.clientX, y: event.clientY });
  if (event.shiftKey || event.buttons > 1 || dragged.size > 1 || element("turn").checked || id === "pad") {
    const { view } = states[id];
    view.yaw -= (dx * 0.008) / dragged.size;
    view.pitch = Math.max(-1.55, Math.min(1.55, view.pitch + (dy * 0.008) / dragged.size));
    renew();
    return;
  }
  // Pixels that a mm along the object's travel takes on the screen.
  const along = scene.turn.map((row) => row.reduce((sum, each, k) => sum + each * shape.indenter.axis[k], 0));
  const [sx, sy] = [(along[0] * scene.frameOf[0] * box.width) / 2, (-along[1] * scene.frameOf[1] * box.height) / 2];
  const size = Math.max(sx * sx + sy * sy, 100);
  push((dx * sx + dy * sy) / size / shape.most.depth);
}

for (const id of ["section", "pad"]) {
  const box = element(id), scene = () => scenes[["section", "pad"].indexOf(id)];
  box.className = "scene";
  box.addEventListener("pointerdown", (event) => {
    dragged.set(event.pointerId, { x: event.clientX, y: event.clientY });
    box.setPointerCapture(event.pointerId);
  });
  box.addEventListener("pointermove", (event) => { if (dragged.has(event.pointerId)) dragTo(scene(), id, event); });
  for (const end of ["pointerup", "pointercancel"]) box.addEventListener(end, (event) => dragged.delete(event.pointerId));
  box.addEventListener("contextmenu", (event) => event.preventDefault());
  box.addEventListener("dblclick", () => { Object.assign(states[id].view, HOMES[id]); renew(); });
  box.addEventListener("wheel", (event) => {
    event.preventDefault();
    if (event.ctrlKey || id === "pad") {
      states[id].view.zoom *= Math.exp(-event.deltaY * 0.001);
      renew();
    } else push(-NOTCH * Math.sign(event.deltaY));
  }, { passive: false });
}
element("section").addEventListener("keydown", (event) => {
  const steps = { ArrowUp: KEY, ArrowDown: -KEY, PageUp: 5 * KEY, PageDown: -5 * KEY };
  if (event.key in steps) push(steps[event.key]);
  else if (event.key === "Escape") lift();
  else return;
  event.preventDefault();
});

// The choice of finger, object, mechanics and units.
const form = element("setup");

function fill(setup) {
  for (const name of ["subject", "kind", "angle", "size", "mechanics", "units"]) form.elements[name].value = setup[name];
  form.elements.along.checked = setup.along;
  form.elements.soft.checked = setup.modulus !== null;
  if (setup.modulus !== null) form.elements.modulus.value = setup.modulus;
  adapt();
}

function adapt() {
  const { kind, soft, mechanics } = form.elements, kinds = [kind.value];
  const able = kind.value !== "bar";
  if (able && soft.checked) kinds.push("soft");
  for (const label of form.querySelectorAll("[data-for]")) label.hidden = !label.dataset.for.split(" ").some((each) => kinds.includes(each));
  for (const label of form.querySelectorAll("[data-for]")) label.style.display = label.hidden ? "none" : "";
  element("sized").textContent = kind.value === "bar" ? "width" : "radius";
  if (able && soft.checked && mechanics.value === "pressed") mechanics.value = "condensed";
}

form.addEventListener("input", adapt);
form.addEventListener("submit", (event) => {
  event.preventDefault();
  const value = (name) => form.elements[name].value, number = (name) => +value(name);
  const soft = form.elements.soft.checked && value("kind") !== "bar";
  const setup = {
    subject: value("subject"), kind: value("kind"), angle: number("angle"), size: number("size"),
    along: form.elements.along.checked, modulus: soft ? number("modulus") : null, mechanics: value("mechanics"), units: value("units"),
  };
  send({ kind: "choose", setup });
});
fill(data.setup);

addEventListener("resize", renew);
document.addEventListener("visibilitychange", () => {
  send({ kind: "pause", on: document.hidden });
  renew();
});
socket.addEventListener("open", () => { if (document.hidden) send({ kind: "pause", on: true }); });
socket.addEventListener("close", () => { if (!element("status").classList.contains("warning")) say("The connection has ended; load this page again, or start fefinger live anew.", true); });
let awaited = null, last = null;  // a shape whose arrays follow; the last JSON message
socket.addEventListener("message", ({ data: received }) => {
  if (received instanceof ArrayBuffer) {
    if (awaited) [awaited] = [null, prepare(awaited, received)];
    else arrive(received);
    return;
  }
  const message = last = JSON.parse(received);
  if (message.kind === "shape") awaited = message;
  else if (message.kind === "progress") say(`Computing: ${message.stage}, ${Math.round(100 * message.fraction)} %`);
  else if (message.kind === "saved") say(`Saved ${message.files.join(", ")}. Peak force ${message.peak.toPrecision(3)} N as played, ${message.run_peak.toPrecision(3)} N in the run.`);
  else {
    if (message.setup) fill(message.setup);
    say(message.text, true);
  }
});
