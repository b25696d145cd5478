// The page of stored results: orbit, time, fields and parts are shared by all scenes.
const data = JSON.parse(element("data").textContent);
const PARTS = ["skin", "subcutaneous tissue", "bone", "other half", "pressure", "end organs", "rates", "indenter"];
const HOME = { yaw: 0.45, pitch: -0.2, zoom: 1, x: 0, y: 0 };
const view = { ...HOME };
const shown = Object.fromEntries(PARTS.map((part) => [part, part !== "other half"]));
const times = [...new Set(data.scenes.flatMap((scene) => scene.times))].sort((a, b) => a - b);
const state = { view, shown, field: data.field };
let now = data.time;

async function unpack() {
  const packed = Uint8Array.from(atob(element("blob").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

class StoredScene extends Scene {
  constructor(record, buffer) {
    const box = document.createElement("div");
    element("scenes").append(box);
    super(box, record, buffer, data, state);
  }

  // End organs in the cut, or units on the skin of the whole finger.
  get marks() { return shown["end organs"] && this.record[shown["other half"] ? "units" : "organs"]; }

  get frame() {
    const away = this.record.times.map((t) => Math.abs(t - now));
    return away.indexOf(Math.min(...away));
  }

  part(place, size) { return this.read(place).subarray(this.frame * size, (this.frame + 1) * size); }

  get places() { return this.part(this.record.points, 3 * this.record.vertices); }

  get linePlaces() {
    const { linePoints, times } = this.record;
    return this.part(linePoints, linePoints.count / times.length);
  }

  get organPlaces() { return this.part(this.marks.points, 3 * this.marks.labels.length); }

  get rates() { return this.marks.rates && this.part(this.marks.rates, this.marks.labels.length); }

  get depth() { return this.record.depth[this.frame]; }

  values(name) {
    const { low, step, ...place } = this.record.values[name];
    return Float32Array.from(this.part(place, this.record.vertices), (v) => low + step * v);
  }

  get words() {
    const { record, frame } = this;
    const words = [`t = ${+record.times[frame].toPrecision(4)} s`, `depth ${record.depth[frame].toPrecision(3)} mm`];
    if (record.force) words.push(`force ${record.force[frame].toPrecision(3)} N`);
    return [record.title, `${record.words}: ${state.field}`, words.join(",  ")];
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
  element("field").value = state.field;
  element("field").addEventListener("change", (event) => { state.field = event.target.value; redraw(); });
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
  .then((buffer) => start(data.scenes.map((record) => new StoredScene(record, buffer))))
  .catch((error) => { element("status").className = "warning"; element("status").textContent = error.message; });
