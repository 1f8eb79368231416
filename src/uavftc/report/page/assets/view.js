"use strict";
// The moving view: the aircraft in its attitude, with its surfaces, on its way; a sketch, projected onto a canvas.
// World: north, east, down, m, from the start. Body: forward, right, down, in half spans.
(function () {
  const GAIN = 3;  // surfaces are drawn at so many times their deflection
  const FOCAL = 1.5, RAD = Math.PI / 180;
  const view = { azimuth: 38 * RAD, elevation: 20 * RAD, zoom: 1, mode: "close" };

  const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

  // A flat part between a leading and a trailing edge: at stations along the span, [x ahead, x behind, y, z].
  const flat = (name, role, rows) => ({
    name, role, points: [...rows.map(([x, , y, z]) => [x, y, z]), ...rows.map(([, x, y, z]) => [x, y, z]).reverse()],
  });
  function mirrored(make) { return [make("right", 1), make("left", -1)]; }

  const FACES = [
    ...mirrored((side, s) => flat(null, "wing", [[0.17, -0.13, s * 0.05, 0], [0.1, -0.1, s, -0.04]])),
    ...mirrored((side, s) => ({
      name: `${side}_aileron`, role: "surface", hinge: "y",
      points: [[-0.115, s * 0.5, -0.02], [-0.1, s * 0.97, -0.039], [-0.185, s * 0.97, -0.039], [-0.215, s * 0.5, -0.02]],
    })),
    ...mirrored((side, s) => flat(null, "wing", [[-0.13, -0.215, s * 0.05, 0], [-0.115, -0.215, s * 0.5, -0.02]])),
    ...mirrored((side, s) => flat(null, "tail", [[-0.82, -0.92, 0, -0.04], [-0.85, -0.92, s * 0.34, -0.04]])),
    ...mirrored((side, s) => ({
      name: `${side}_elevator`, role: "surface", hinge: "y",
      points: [[-0.92, s * 0.02, -0.04], [-0.92, s * 0.34, -0.04], [-0.99, s * 0.34, -0.04], [-1.01, s * 0.02, -0.04]],
    })),
    { name: null, role: "tail", points: [[-0.74, 0, -0.05], [-0.86, 0, -0.34], [-0.92, 0, -0.34], [-0.92, 0, -0.05]] },
    {
      name: "rudder", role: "surface", hinge: "z",
      points: [[-0.92, 0, -0.06], [-0.92, 0, -0.34], [-0.99, 0, -0.34], [-1.03, 0, -0.06]],
    },
    ...body(),
  ];

  function body() {
    const stations = [[0.5, 0.012, 0.02], [0.4, 0.055, 0.02], [0.12, 0.075, 0.0], [-0.25, 0.06, -0.01],
      [-0.7, 0.03, -0.04], [-1.02, 0.012, -0.05]];
    const around = 8, made = [];
    const ring = ([x, r, z]) => Array.from({ length: around }, (_, k) => {
      const angle = 2 * Math.PI * (k + 0.5) / around;
      return [x, r * Math.cos(angle), z + r * Math.sin(angle)];
    });
    for (let i = 0; i + 1 < stations.length; i += 1) {
      const one = ring(stations[i]), next = ring(stations[i + 1]);
      for (let k = 0; k < around; k += 1) {
        const after = (k + 1) % around;
        made.push({ name: null, role: "body", points: [one[k], one[after], next[after], next[k]] });
      }
    }
    return made;
  }

  function turned(face, angle) {  // a surface about its hinge, the first two points; angle of the trailing edge, rad
    return face.points.map((point, i) => {
      if (i < 2) return point;
      const hinge = face.points[i === 2 ? 1 : 0], behind = hinge[0] - point[0];
      const moved = [hinge[0] - behind * Math.cos(angle), point[1], point[2]];
      moved[face.hinge === "y" ? 2 : 1] += behind * Math.sin(angle);
      return moved;
    });
  }

  function rotation(phi, theta, psi) {  // body to north, east, down
    const [cf, sf, ct, st, cp, sp] = [Math.cos(phi), Math.sin(phi), Math.cos(theta), Math.sin(theta), Math.cos(psi), Math.sin(psi)];
    const rows = [
      [ct * cp, sf * st * cp - cf * sp, cf * st * cp + sf * sp],
      [ct * sp, sf * st * sp + cf * cp, cf * st * sp - sf * cp],
      [-st, sf * ct, cf * ct],
    ];
    return (v) => rows.map((row) => dot(row, v));
  }

  function read() {
    const raw = uavftc.data.view, arrays = { t: uavftc.array(raw.t) };
    for (const name of ["phi", "theta", "psi"]) arrays[name] = uavftc.array(raw[name]);
    const n = arrays.t.length;
    for (const name of ["north", "east", "up"]) {
      arrays[name] = raw[name] ? uavftc.array(raw[name]).map((v) => (Number.isFinite(v) ? v : 0)) : new Float32Array(n);
    }
    const parts = {};
    for (const [name, part] of Object.entries(raw.parts)) parts[name] = { ...part, values: uavftc.array(part.angle) };
    const read_ = raw.read.map((one) => ({ ...one, values: uavftc.array(one.y) }));
    const ends = ["north", "east", "up"].map((name) => [Math.min(...arrays[name]), Math.max(...arrays[name])]);
    return { arrays, parts, read: read_, span: raw.span, way: Boolean(raw.north), ends };
  }

  function camera(flight, at, width, height) {
    const half = flight.span / 2;
    const close = view.mode === "close" || !flight.way;
    const [n, e, u] = flight.ends;
    const size = Math.max(n[1] - n[0], e[1] - e[0], u[1] - u[0], 4 * flight.span);
    const centre = close ? at : [(n[0] + n[1]) / 2, (e[0] + e[1]) / 2, -(u[0] + u[1]) / 2];
    const distance = (close ? 1.6 * flight.span : 1.15 * size) / view.zoom;
    const heading = flight.arrays.psi[0] * RAD + view.azimuth;
    const [ca, sa, ce, se] = [Math.cos(heading), Math.sin(heading), Math.cos(view.elevation), Math.sin(view.elevation)];
    const ahead = [ce * ca, ce * sa, se], right = [-sa, ca, 0], down = cross(ahead, right);
    const eye = sub(centre, ahead.map((v) => distance * v));
    const focal = FOCAL * Math.min(width, 1.3 * height) * 0.62;
    const project = (p) => {
      const from = sub(p, eye), depth = dot(from, ahead);
      return [width / 2 + focal * dot(from, right) / depth, height * 0.46 + focal * dot(from, down) / depth, depth];
    };
    const ground = close ? -u[0] + 1.2 * flight.span : -u[0] + 0.12 * size;
    return { project, close, size, half: close ? half : 0.055 * size, ground, near: 0.02 * distance, centre, distance };
  }

  function stroke(context, cam, from, to, colour, width) {
    const a = cam.project(from), b = cam.project(to);
    if (a[2] < cam.near || b[2] < cam.near) return;
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0], b[1]);
    context.stroke();
  }

  function grid(context, cam, flight, ink) {
    const reach = cam.close ? 9 * flight.span : cam.size, raw = reach / 9;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = power * [1, 2, 5, 10].find((k) => k * power >= raw);
    const [n0, e0] = [0, 1].map((i) => Math.round(cam.centre[i] / step) * step);
    const lines = Math.ceil(reach / step), pieces = 6;
    for (let k = -lines; k <= lines; k += 1) {
      for (let j = 0; j < 2 * pieces; j += 1) {
        const one = reach * (j / pieces - 1), next = reach * ((j + 1) / pieces - 1);
        stroke(context, cam, [n0 + k * step, e0 + one, cam.ground], [n0 + k * step, e0 + next, cam.ground], ink.grid, 1);
        stroke(context, cam, [n0 + one, e0 + k * step, cam.ground], [n0 + next, e0 + k * step, cam.ground], ink.grid, 1);
      }
    }
    return step;
  }

  function colourAt(t) {  // of the way: what acts on the aircraft then
    const { windows, shades } = uavftc.data;
    const acts = windows.find((one) => one.kind !== "disturbance" && one.kind !== "sensor" && t >= one.start && t < one.end);
    return acts ? shades[acts.kind].colour : uavftc.theme.colour(uavftc.data.looks.actual);
  }

  function way(context, cam, flight, now, ink) {
    const { arrays } = flight, n = arrays.t.length, every = Math.max(1, Math.floor(n / 500));
    const point = (i) => [arrays.north[i], arrays.east[i], -arrays.up[i]];
    const span = cam.close ? 60 * flight.span : Infinity;
    for (let i = 0; i + 1 < n; i += every) {
      const next = Math.min(i + every, n - 1), from = point(i);
      if (Math.abs(from[0] - cam.centre[0]) + Math.abs(from[1] - cam.centre[1]) > span) continue;
      const past = arrays.t[next] <= now;
      context.globalAlpha = past ? 1 : 0.45;
      context.setLineDash(past ? [] : [3, 4]);
      stroke(context, cam, from, point(next), colourAt(arrays.t[i]), past ? 3 : 1.5);
    }
    context.globalAlpha = 1;
    context.setLineDash([2, 3]);
    for (let k = 0; k <= 10; k += 1) {
      const at = point(Math.round((n - 1) * k / 10));
      if (!cam.close) stroke(context, cam, at, [at[0], at[1], cam.ground], ink.line, 1);
    }
    context.setLineDash([]);
  }

  function shaded(hex, light, dark) {
    const n = parseInt(hex.slice(1), 16), k = 0.55 + 0.45 * light, to = dark ? 20 : 0;
    const mixed = [n >> 16, (n >> 8) & 255, n & 255].map((v) => Math.round(v * k + to * (1 - k)));
    return `rgb(${mixed.join(",")})`;
  }

  function aircraft(context, cam, flight, place, at, now, ink) {
    const [phi, theta, psi] = ["phi", "theta", "psi"].map((name) => RAD * uavftc.at(flight.arrays[name], place));
    const turn = rotation(phi, theta, psi), dark = uavftc.theme.dark();
    const { windows, shades } = uavftc.data;
    const base = dark
      ? { body: "#9aa4b2", wing: "#c3cad6", tail: "#b4bccb", surface: "#7db4ee" }
      : { body: "#8b94a1", wing: "#cfd6df", tail: "#bcc5d0", surface: "#2f7fbf" };
    const drawn = FACES.map((face) => {
      let points = face.points, colour = base[face.role];
      if (face.name) {
        const part = flight.parts[face.name];
        points = turned(face, GAIN * RAD * uavftc.at(part.values, place));
        const on = part.windows.map((number) => windows[number - 1]).find((one) => now >= one.start && now < one.end);
        if (on) colour = shades[on.kind].colour;
      }
      const world = points.map((p) => add(at, turn(p.map((v) => v * cam.half))));
      const normal = cross(sub(world[1], world[0]), sub(world[2], world[0]));
      const length = Math.hypot(...normal) || 1;
      const shadow = Math.abs(dot(normal, [0.25, 0.35, -0.9])) / length;
      const screen = world.map(cam.project);
      return { screen, colour: shaded(colour, shadow, dark), depth: Math.max(...screen.map((p) => p[2])), face };
    });
    drawn.sort((one, other) => other.depth - one.depth);
    context.lineJoin = "round";
    for (const { screen, colour, face } of drawn) {
      context.beginPath();
      screen.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.closePath();
      context.fillStyle = colour;
      context.fill();
      context.strokeStyle = face.role === "body" ? colour : ink.faint;
      context.lineWidth = 0.8;
      context.stroke();
    }
  }

  function draw(canvas, flight) {
    const width = canvas.clientWidth, height = canvas.clientHeight, ratio = window.devicePixelRatio || 1;
    if (!width) return;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d"), ink = uavftc.theme.ink(), now = uavftc.clock.t;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = ink.ground;
    context.fillRect(0, 0, width, height);
    const place = uavftc.place(flight.arrays.t, now);
    const [north, east, up] = ["north", "east", "up"].map((name) => uavftc.at(flight.arrays[name], place));
    const at = [north, east, -up], cam = camera(flight, at, width, height);
    const step = grid(context, cam, flight, ink);
    if (flight.way) way(context, cam, flight, now, ink);
    if (cam.close) stroke(context, cam, at, [at[0], at[1], cam.ground], ink.line, 1);
    aircraft(context, cam, flight, place, at, now, ink);
    context.fillStyle = ink.faint;
    context.font = "12px system-ui, sans-serif";
    const said = cam.close ? "" : ", aircraft enlarged";
    context.fillText(`grid ${step >= 1 ? step : step.toPrecision(1)} m${said}; surfaces turned ${GAIN} times as far`, 10, height - 10);
    canvas.dataset.attitude = ["phi", "theta", "psi"].map((name) => uavftc.at(flight.arrays[name], place).toFixed(3)).join(" ");
  }

  function readout(flight) {
    const table = document.getElementById("readout");
    const cells = flight.read.map((one) => {
      const cell = uavftc.element("td", {});
      table.append(uavftc.element("tr", {}, uavftc.element("th", { scope: "row" }, `${one.name} [${one.unit}]`), cell));
      return cell;
    });
    uavftc.clock.listeners.push((t) => {
      const place = uavftc.place(flight.arrays.t, t);
      flight.read.forEach((one, i) => {
        const value = uavftc.at(one.values, place);
        cells[i].textContent = Number.isFinite(value) ? uavftc.number(value, one.digits) : "–";
      });
    });
  }

  function steer(canvas, again) {
    let held = null;
    const turn = (dx, dy) => {
      view.azimuth += dx;
      view.elevation = Math.min(Math.max(view.elevation + dy, -80 * RAD), 88 * RAD);
      again();
    };
    canvas.addEventListener("pointerdown", (event) => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      turn((event.clientX - held[0]) * 0.008, (event.clientY - held[1]) * 0.008);
      held = [event.clientX, event.clientY];
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { held = null; });
    canvas.addEventListener("keydown", (event) => {
      const keys = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
      if (keys[event.key]) turn(...keys[event.key]);
      else if (event.key === "+" || event.key === "-") { view.zoom *= event.key === "+" ? 1.2 : 1 / 1.2; again(); }
      else return;
      event.preventDefault();
    });
    const mode = document.getElementById("view-mode");
    if (mode) {
      mode.addEventListener("change", () => {
        view.mode = mode.value;
        view.elevation = (mode.value === "close" ? 20 : 35) * RAD;
        again();
      });
    }
  }

  uavftc.startView = function () {
    const canvas = document.getElementById("view");
    if (!canvas || !uavftc.data.view) return;
    let flight = read();
    const again = () => draw(canvas, flight);
    readout(flight);
    uavftc.clock.listeners.push(again);
    uavftc.theme.listeners.push(again);
    steer(canvas, again);
    new ResizeObserver(again).observe(canvas);
    uavftc.clock.set(uavftc.clock.t, "start");
  };
})();
