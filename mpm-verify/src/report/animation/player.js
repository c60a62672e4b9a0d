"use strict";
(async () => {
  const $ = (id) => document.getElementById(id);
  const model = JSON.parse($("model").textContent);
  const { frames, story, quantities } = model;
  const [left, low, right, high] = model.window;
  if (frames.length === 0) return;
  if (typeof DecompressionStream === "undefined") {
    $("unable").hidden = false;
    return;
  }

  // ---- frames: differences from the frame before, folded and deflated (packed.rs says how) ----

  const text = atob($("data").textContent.trim());
  const deflated = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const unfold = (folded) => (folded >>> 1) ^ -(folded & 1);
  let at = 0;
  const wide = (before, count) => {
    const list = new Uint16Array(count);
    for (let k = 0; k < count; k++) {
      list[k] = (before?.[k] ?? 0) + unfold(bytes[at + k] + 256 * bytes[at + count + k]);
    }
    at += 2 * count;
    return list;
  };
  const narrow = (before, count) => {
    const list = new Uint8Array(count);
    for (let k = 0; k < count; k++) list[k] = (before?.[k] ?? 0) + unfold(bytes[at + k]);
    at += count;
    return list;
  };
  let before = {};
  for (const f of frames) {
    f.x = wide(before.x, f.solid);
    f.y = wide(before.y, f.solid);
    f.values = quantities.map((_, q) => narrow(before.values?.[q], f.solid));
    f.wx = wide(before.wx, f.water);
    f.wy = wide(before.wy, f.water);
    before = f;
  }

  // ---- state ----

  const last = frames.length - 1;
  // It opens at the moment of failure.
  let now = Math.min(last, model.opens);
  let pointed = null;
  let playing = null;
  let printing = false;
  let look;

  const LIGHT = {
    back: "#fff", text: "#1b1f24", soft: "#59636e", line: "#c5ccd4", faint: "#e4e8ec", band: "#f6f1e7", tank: "#b9d9ef", level: "#00558c",
    series: ["#0072b2", "#d55e00", "#007a5a", "#a8417f", "#8a6100", "#59636e", "#7b4b3a"],
  };
  const DARK = {
    back: "#15181c", text: "#e6e9ec", soft: "#a3adb8", line: "#4a525c", faint: "#2a3037", band: "#241f17", tank: "#2c5a7d", level: "#8fd0ff",
    series: ["#56b4e9", "#ff9a4d", "#3fd0a4", "#e79cc8", "#f0c04a", "#c3cbd3", "#d4a294"],
  };
  function choose() {
    const colour = getComputedStyle(document.body).backgroundColor.match(/[\d.]+/g)?.map(Number) ?? [255, 255, 255];
    const dark = !printing && colour.length >= 3 && (colour[3] ?? 1) > 0 && colour[0] + colour[1] + colour[2] < 300;
    look = dark ? DARK : LIGHT;
  }

  const clockOf = (seconds) => {
    const tenths = Math.round(10 * seconds);
    const [h, m, s] = [Math.floor(tenths / 36000), Math.floor(tenths / 600) % 60, (tenths % 600) / 10];
    return `${h} h ${String(m).padStart(2, "0")} min ${s} s`;
  };
  const told = (value) => {
    const digits = Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 10 ? 1 : 2;
    return value.toFixed(digits).replace("-", "\u2212");
  };
  const round = (start, end, most) => {
    const rough = (end - start) / most;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * (1 - 1e-9));
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const ticks = [];
    for (let k = Math.ceil(start / step - 1e-9); k * step <= end + 1e-9 * step; k++) {
      ticks.push([k * step, (k * step).toFixed(decimals).replace("-", "\u2212").replace(/^\u2212(0\.?0*)$/, "$1")]);
    }
    return ticks;
  };

  // ---- canvases ----

  const narrowPage = () => document.documentElement.clientWidth < 560;
  const margins = () => (narrowPage() ? { left: 38, right: 10 } : { left: 52, right: 14 });

  function prepare(canvas, tall) {
    const width = canvas.clientWidth || 900;
    const fine = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * fine);
    canvas.height = Math.round(tall * fine);
    canvas.style.height = tall + "px";
    const pen = canvas.getContext("2d");
    pen.setTransform(fine, 0, 0, fine, 0, 0);
    pen.fillStyle = look.back;
    pen.fillRect(0, 0, width, tall);
    pen.font = `${narrowPage() ? 11 : 12}px system-ui, "DejaVu Sans", sans-serif`;
    pen.textBaseline = "middle";
    pen.lineJoin = "round";
    return [pen, width];
  }

  /** Writes a text; `hold` is the side at which it is held. */
  function write(pen, words, x, y, hold = "center", colour = look.text) {
    pen.fillStyle = colour;
    pen.textAlign = hold;
    pen.fillText(words, x, y);
  }

  function stroke(pen, points, colour, width = 1, dash = []) {
    if (points.length === 0) return;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.setLineDash(dash);
    pen.beginPath();
    for (const [x, y] of points) pen.lineTo(x, y);
    pen.stroke();
    pen.setLineDash([]);
  }

  // ---- time ----

  /** Place of a time among the frames: 3.5 is halfway between the fourth and the fifth. */
  function place(time) {
    if (time <= frames[0].time) return 0;
    if (time >= frames[last].time) return last;
    let [a, b] = [0, last];
    while (b - a > 1) {
      const middle = (a + b) >> 1;
      if (frames[middle].time <= time) a = middle;
      else b = middle;
    }
    return a + (time - frames[a].time) / (frames[b].time - frames[a].time || 1);
  }
  function timeAt(where) {
    const a = Math.max(0, Math.min(last, Math.floor(where)));
    const b = Math.min(last, a + 1);
    return frames[a].time + (where - a) * (frames[b].time - frames[a].time);
  }
  /** Index of the last entry of a list of times that is not later. */
  function indexAt(times, time) {
    let [a, b] = [0, times.length];
    while (b - a > 1) {
      const middle = (a + b) >> 1;
      if (times[middle] <= time + 1e-3) a = middle;
      else b = middle;
    }
    return a;
  }
  const shownTime = () => pointed ?? frames[now].time;

  /** Ticks of the axis of time: hours, and minutes and seconds after the onset of failure, as many as have room. */
  function timeTicks(across) {
    const ticks = [];
    const add = (time, words, room) => {
      const x = across(time);
      if (time >= frames[0].time && time <= frames[last].time && ticks.every((t) => Math.abs(t.x - x) >= room)) {
        ticks.push({ x, words });
      }
    };
    const end = story.onset ?? frames[last].time;
    for (let h = Math.ceil(frames[0].time / 3600 - 1e-9); 3600 * h <= end; h++) add(3600 * h, `${h} h`, 30);
    for (const step of story.onset == null ? [] : [3600, 600, 60, 10, 5, 2, 1]) {
      for (let k = 1; k <= 60 && story.onset + k * step <= frames[last].time; k++) {
        const seconds = k * step;
        const words = seconds % 3600 === 0 ? `+${seconds / 3600} h` : seconds % 60 === 0 ? `+${seconds / 60} min` : `+${seconds} s`;
        add(story.onset + seconds, words, 46);
      }
    }
    return ticks;
  }

  // ---- the map ----

  const mix = (a, b, share) => a.map((v, k) => Math.round(v + share * (b[k] - v)));
  const css = (c) => `rgb(${c[0]},${c[1]},${c[2]})`;
  const [SAND, WET] = [[222, 201, 158], [116, 169, 214]];
  const RAMPS = [
    [[0.4, [238, 138, 52]], [0.7, [206, 50, 32]], [1, [110, 8, 46]]],
    [[0.4, [150, 92, 178]], [0.7, [158, 30, 110]], [1, [84, 0, 50]]],
  ];
  function strained(base, ramp, share) {
    let [from, colour] = [0, base];
    for (const [to, next] of ramp) {
      if (share <= to) return mix(colour, next, (share - from) / (to - from));
      [from, colour] = [to, next];
    }
    return colour;
  }
  const OVERVIEW = [SAND, WET].map((base, wet) => Array.from({ length: 256 }, (_, k) => css(strained(base, RAMPS[wet], k / 255))));
  const STRAIN = quantities.findIndex((q) => q.name === "strain");

  /** The level of the water as px, from the tank on. */
  function levelOf(f, across, down) {
    const start = model.tank > 0 && f.level.length > 0 ? [[0, model.tank]] : [];
    return [...start, ...f.level].map(([x, y]) => [across(x), down(y)]);
  }
  /** Whether a place is below a line of px. */
  function below(line, x, y) {
    const next = line.findIndex(([end]) => end >= x);
    if (next < 0) return false;
    const [[a, up], [b, end]] = [line[Math.max(0, next - 1)], line[next]];
    return y >= up + (b > a ? (x - a) / (b - a) : 0) * (end - up);
  }

  function drawMap() {
    const canvas = $("map");
    const room = { ...margins(), top: 10 };
    const probe = canvas.clientWidth || 900;
    const unit = (probe - room.left - room.right) / (right - left);
    const bottom = room.top + (high - low) * unit;
    const [pen, width] = prepare(canvas, bottom + 78);
    const across = (x) => room.left + (x - left) * unit;
    const down = (y) => bottom - (y - low) * unit;
    const f = frames[now];
    const name = $("shown").value;
    const q = quantities.findIndex((one) => one.name === name);

    // Ticks of both axes stand behind all else.
    pen.save();
    pen.beginPath();
    pen.rect(room.left, room.top, width - room.left - room.right, bottom - room.top);
    pen.clip();
    if (model.tank > 0) {
      pen.fillStyle = look.tank;
      pen.fillRect(across(left), down(model.tank), across(0) - across(left), down(0) - down(model.tank));
      stroke(pen, [[across(left), down(model.tank)], [across(0), down(model.tank)]], look.level, 2);
    }
    const spot = (x, y) => [room.left + (x / 65535) * (right - left) * unit, bottom - (y / 65535) * (high - low) * unit];
    // A little larger than at rest, for soil that has spread.
    const edge = 1.1 * model.edge * unit + 0.5;
    const level = levelOf(f, across, down);
    for (let p = 0; p < f.solid; p++) {
      const [x, y] = spot(f.x[p], f.y[p]);
      pen.fillStyle = q >= 0 ? model.colours[f.values[q][p]] : OVERVIEW[below(level, x, y) ? 1 : 0][f.values[STRAIN][p]];
      pen.fillRect(x - edge / 2, y - edge / 2, edge, edge);
    }
    if ($("water").checked) {
      const outer = Math.min(5, Math.max(1.6, 0.42 * edge));
      for (const [colour, size] of [["#005b8f", outer], ["#fff", 0.5 * outer]]) {
        pen.fillStyle = colour;
        for (let p = 0; p < f.water; p++) {
          const [x, y] = spot(f.wx[p], f.wy[p]);
          pen.fillRect(x - size / 2, y - size / 2, size, size);
        }
      }
    }
    const closed = [...model.outline, model.outline[0]].map(([x, y]) => [across(x), down(y)]);
    stroke(pen, closed, look.text, 1.3, [5, 3]);
    stroke(pen, level, look.back, 4);
    stroke(pen, level, look.level, 2.2);
    if ($("points").checked) {
      story.paths.forEach((path, k) => {
        if (path.off) return;
        const i = indexAt(path.times, f.time);
        const [x, y] = [across(path.x[i]), down(path.y[i])];
        pen.beginPath();
        pen.arc(x, y, narrowPage() ? 3 : 4.5, 0, 2 * Math.PI);
        pen.fillStyle = look.series[k % look.series.length];
        pen.fill();
        pen.strokeStyle = "#fff";
        pen.lineWidth = 1.4;
        pen.stroke();
        if (narrowPage()) return;
        pen.lineWidth = 3;
        pen.strokeStyle = look.back;
        pen.textAlign = "left";
        pen.strokeText(path.name, x + 7, y - 8);
        write(pen, path.name, x + 7, y - 8, "left");
      });
    }
    pen.restore();
    pen.strokeStyle = look.line;
    pen.lineWidth = 1;
    pen.strokeRect(room.left, room.top, width - room.left - room.right, bottom - room.top);
    for (const [x, words] of round(left, right, narrowPage() ? 6 : 12)) {
      stroke(pen, [[across(x), bottom], [across(x), bottom + 5]], look.soft);
      write(pen, words, across(x), bottom + 14);
    }
    write(pen, "x (m)", (room.left + width - room.right) / 2, bottom + 30, "center", look.soft);
    for (const [y, words] of round(low, high, 4)) {
      stroke(pen, [[room.left - 5, down(y)], [room.left, down(y)]], look.soft);
      write(pen, words, room.left - 8, down(y), "right");
    }
    pen.save();
    pen.translate(9, (room.top + bottom) / 2);
    pen.rotate(-Math.PI / 2);
    write(pen, "y (m)", 0, 0, "center", look.soft);
    pen.restore();
    scale(pen, q, room.left, width - room.right, bottom + 44);
    const moved = story.moved?.map((s) => `${s.name} ${told(s.values[indexAt(story.times, f.time)])} m`) ?? [];
    canvas.setAttribute("aria-label", `The section at ${f.clock}, ${f.phase}: ${moved.join(", ")}`);
  }

  /** The colour scale with what it means. */
  function scale(pen, q, start, end, top) {
    const shown = quantities[q < 0 ? STRAIN : q];
    const length = end - start;
    const rows = q < 0 ? [OVERVIEW[0], OVERVIEW[1]] : [model.colours];
    const tall = 12 / rows.length;
    rows.forEach((row, r) => {
      for (let k = 0; k < 256; k++) {
        pen.fillStyle = row[k];
        pen.fillRect(start + (k / 256) * length, top + r * tall, length / 256 + 0.6, tall);
      }
    });
    pen.strokeStyle = look.line;
    pen.lineWidth = 1;
    pen.strokeRect(start, top, length, 12);
    const [from, to] = shown.range;
    for (const [value, words] of round(from, to, narrowPage() ? 4 : 8)) {
      const x = start + ((value - from) / (to - from)) * length;
      stroke(pen, [[x, top + 12], [x, top + 16]], look.soft);
      write(pen, words, x, top + 23, x > end - 12 ? "right" : "center");
    }
    const clipped = model.clipped.charAt(0).toLowerCase() + model.clipped.slice(1);
    const kinds = q < 0 ? "; upper row: soil above the water level, lower row: below it" : "";
    $("scale").textContent = `${shown.label}${kinds}; ${clipped}`;
  }

  // ---- curves over time, under the slider and in line with it ----

  const tracks = [
    { title: "Water level (m)", series: story.levels ?? [] },
    { title: "Water (m\u00b3 per m)", series: story.water ?? [] },
    { title: "Displacement (m)", series: story.moved ?? [] },
  ].filter((track) => track.series.length > 0 && story.times.length > 1);

  function key(words, k, target, redraw) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "key";
    button.setAttribute("aria-pressed", "true");
    button.addEventListener("click", () => {
      target.off = !target.off;
      button.setAttribute("aria-pressed", String(!target.off));
      redraw();
    });
    target.key = { button, words, k };
    return button;
  }
  const colourKeys = (list) => {
    for (const { key } of list) if (key) key.button.style.setProperty("--own", look.series[key.k % look.series.length]);
  };

  for (const track of tracks) {
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    const title = document.createElement("b");
    title.textContent = track.title;
    caption.append(title);
    track.series.forEach((s, k) => caption.append(key(s.short ?? s.name, k, s, draw)));
    track.canvas = document.createElement("canvas");
    track.canvas.setAttribute("role", "img");
    figure.append(caption, track.canvas);
    $("tracks").append(figure);
    scrub(track.canvas, (x) => {
      const { left: a, right: b } = margins();
      const share = (x - a) / (track.canvas.clientWidth - a - b);
      return timeAt(Math.max(0, Math.min(1, share)) * last);
    });
  }

  function drawTrack(track, isLast) {
    const room = { ...margins(), top: 6 };
    const tall = 84;
    const [pen, width] = prepare(track.canvas, room.top + tall + (isLast ? 24 : 6));
    const bottom = room.top + tall;
    const across = (time) => room.left + (place(time) / (last || 1)) * (width - room.left - room.right);
    const on = track.series.filter((s) => !s.off);
    const values = on.flatMap((s) => s.values);
    let [from, to] = [Math.min(0, ...values), Math.max(0, ...values)];
    if (to - from < 1e-9) to = from + 1;
    [from, to] = [from - 0.04 * (to - from), to + 0.06 * (to - from)];
    const down = (v) => bottom - ((v - from) / (to - from)) * tall;
    if (story.onset != null && story.onset < frames[last].time) {
      pen.fillStyle = look.band;
      pen.fillRect(across(story.onset), room.top, width - room.right - across(story.onset), tall);
    }
    for (const [v, words] of round(from, to, 3)) {
      stroke(pen, [[room.left, down(v)], [width - room.right, down(v)]], look.faint);
      write(pen, words, room.left - 7, down(v), "right");
    }
    for (const { x, words } of timeTicks(across)) {
      stroke(pen, [[x, room.top], [x, bottom]], look.faint);
      if (isLast) {
        stroke(pen, [[x, bottom], [x, bottom + 4]], look.soft);
        write(pen, words, x, bottom + 14);
      }
    }
    for (const event of story.events) stroke(pen, [[across(event.time), room.top], [across(event.time), bottom]], look.soft, 1, [3, 3]);
    track.series.forEach((s, k) => {
      if (s.off) return;
      stroke(pen, story.times.map((t, i) => [across(t), down(s.values[i])]), look.series[k % look.series.length], 1.9);
    });
    pen.strokeStyle = look.line;
    pen.strokeRect(room.left, room.top, width - room.left - room.right, tall);
    if (pointed !== null) stroke(pen, [[across(pointed), room.top], [across(pointed), bottom]], look.soft, 1);
    stroke(pen, [[across(frames[now].time), room.top], [across(frames[now].time), bottom]], look.text, 2);
    const i = indexAt(story.times, shownTime());
    colourKeys(track.series);
    for (const s of track.series) s.key.button.textContent = `${s.key.words}: ${told(s.values[i])}`;
    const said = on.map((s) => `${s.name} ${told(s.values[i])}`).join(", ");
    track.canvas.setAttribute("aria-label", `${track.title} over time; at ${clockOf(shownTime())}: ${said}`);
  }

  // ---- factor of safety and stress paths ----

  const sections = { safety: $("safety"), paths: $("paths") };
  function section(figure, title) {
    const caption = document.createElement("figcaption");
    const head = document.createElement("b");
    head.textContent = title;
    caption.append(head);
    const canvas = document.createElement("canvas");
    canvas.setAttribute("role", "img");
    figure.append(caption, canvas);
    figure.canvas = canvas;
    return caption;
  }

  const factors = story.factors ?? [];
  const methods = [
    { name: "strength reduction", of: (f) => 0.5 * (f.low + f.high), dash: [] },
    { name: "Spencer", of: (f) => f.spencer, dash: [7, 4] },
    { name: "Spencer, Davis", of: (f) => f.davis, dash: [2, 3] },
  ];
  const safetyEnds = () => {
    const times = factors.map((f) => f.time);
    return [Math.min(frames[0].time, ...times), Math.max(frames[last].time, ...times)];
  };
  if (factors.length > 0) {
    const caption = section(sections.safety, "Factor of safety");
    methods.forEach((method, k) => caption.append(key(method.name, k, method, draw)));
    scrub(sections.safety.canvas, (x) => {
      const [a, b] = safetyEnds();
      const room = margins();
      return a + ((x - room.left) / (sections.safety.canvas.clientWidth - room.left - room.right)) * (b - a);
    });
  } else {
    sections.safety.innerHTML = "<figcaption><b>Factor of safety</b></figcaption><p class=\"note\">Not computed for this run. To compute it: <code>mpm-verify levee --safety-factor 6,8,10,12,14,18</code></p>";
  }

  if (factors.length > 0 && story.why) {
    const note = document.createElement("p");
    note.className = "note";
    note.textContent = story.why;
    sections.safety.append(note);
  }

  function drawSafety() {
    if (factors.length === 0) return;
    const room = { ...margins(), top: 6 };
    const tall = 190;
    const [pen, width] = prepare(sections.safety.canvas, room.top + tall + 38);
    const bottom = room.top + tall;
    const [start, end] = safetyEnds();
    const across = (time) => room.left + ((time - start) / (end - start || 1)) * (width - room.left - room.right);
    const on = methods.filter((m) => !m.off);
    const values = [1, ...on.flatMap((m) => factors.map(m.of)).filter((v) => v != null)];
    const [from, to] = [Math.min(...values) - 0.05, Math.max(...values) + 0.05];
    const down = (v) => bottom - ((v - from) / (to - from)) * tall;
    for (const [v, words] of round(from, to, 5)) {
      stroke(pen, [[room.left, down(v)], [width - room.right, down(v)]], look.faint);
      write(pen, words, room.left - 7, down(v), "right");
    }
    for (const [h, words] of round(start / 3600, end / 3600, narrowPage() ? 5 : 8)) {
      stroke(pen, [[across(3600 * h), room.top], [across(3600 * h), bottom + 4]], look.faint);
      write(pen, words, across(3600 * h), bottom + 13);
    }
    write(pen, "time (h)", (room.left + width - room.right) / 2, bottom + 29, "center", look.soft);
    stroke(pen, [[room.left, down(1)], [width - room.right, down(1)]], look.text, 1.4);
    methods.forEach((method, k) => {
      if (method.off) return;
      const known = factors.filter((f) => method.of(f) != null);
      const colour = look.series[k];
      stroke(pen, known.map((f) => [across(f.time), down(method.of(f))]), colour, 1.9, method.dash);
      if (k > 0) return;
      for (const f of known) {
        stroke(pen, [[across(f.time), down(f.low)], [across(f.time), down(f.high)]], colour, 5);
      }
    });
    const failure = story.events.find((event) => event.name === "E2");
    if (failure) {
      stroke(pen, [[across(failure.time), room.top], [across(failure.time), bottom]], look.soft, 1, [3, 3]);
      write(pen, "E2", across(failure.time) - 5, room.top + 10, "right", look.soft);
    }
    stroke(pen, [[across(frames[now].time), room.top], [across(frames[now].time), bottom]], look.text, 2);
    pen.strokeStyle = look.line;
    pen.lineWidth = 1;
    pen.strokeRect(room.left, room.top, width - room.left - room.right, tall);
    colourKeys(methods);
    // Between two computed times the straight line.
    const time = shownTime();
    const interpolated = (method) => {
      const next = factors.findIndex((f) => f.time >= time);
      if (next < 0 || (next === 0 && factors[0].time > time + 1)) return null;
      const [a, b] = [factors[Math.max(0, next - 1)], factors[next]];
      if (method.of(a) == null || method.of(b) == null) return null;
      return method.of(a) + ((time - a.time) / (b.time - a.time || 1)) * (method.of(b) - method.of(a));
    };
    const said = methods.map((m) => [m, interpolated(m)]);
    for (const [m, value] of said) m.key.button.textContent = m.key.words + (value == null ? "" : `: ${value.toFixed(2)}`);
    const first = said[0][1];
    sections.safety.canvas.setAttribute("aria-label", `Factor of safety over time${first == null ? "" : `; at ${clockOf(time)} ${first.toFixed(2)} by strength reduction`}`);
  }

  const paths = story.paths ?? [];
  if (paths.length > 0) {
    const caption = section(sections.paths, "Stress paths");
    paths.forEach((path, k) => caption.append(key(path.name, k, path, draw)));
    caption.title = "s' = mean, t = radius of Mohr's circle of the effective stress in the plane";
    const point = (event) => {
      const { across, down } = sections.paths.scales;
      const box = sections.paths.canvas.getBoundingClientRect();
      const [x, y] = [event.clientX - box.left, event.clientY - box.top];
      let best = [Infinity, 0];
      for (const path of paths.filter((p) => !p.off)) {
        path.times.forEach((time, i) => {
          const off = Math.hypot(across(path.s[i]) - x, down(path.t[i]) - y);
          if (off < best[0]) best = [off, time];
        });
      }
      return best[0] < 40 ? best[1] : null;
    };
    sections.paths.canvas.addEventListener("click", (event) => {
      const time = point(event);
      if (time !== null) goTo(time);
    });
  } else {
    sections.paths.hidden = true;
  }

  function pathEnds() {
    const top = (list) => list.sort((a, b) => a - b)[Math.floor(0.995 * (list.length - 1))] ?? 1;
    return [1.06 * top(paths.flatMap((p) => p.s)), 1.15 * top(paths.flatMap((p) => p.t))];
  }
  const [mostS, mostT] = paths.length > 0 ? pathEnds() : [1, 1];

  function drawPaths() {
    if (paths.length === 0) return;
    const room = { ...margins(), top: 6 };
    const tall = 190;
    const canvas = sections.paths.canvas;
    const [pen, width] = prepare(canvas, room.top + tall + 38);
    const bottom = room.top + tall;
    const across = (s) => room.left + (s / mostS) * (width - room.left - room.right);
    const down = (t) => bottom - (t / mostT) * tall;
    sections.paths.scales = { across, down };
    for (const [v, words] of round(0, mostT, 4)) {
      stroke(pen, [[room.left, down(v)], [width - room.right, down(v)]], look.faint);
      write(pen, words, room.left - 7, down(v), "right");
    }
    for (const [v, words] of round(0, mostS, narrowPage() ? 5 : 8)) {
      stroke(pen, [[across(v), room.top], [across(v), bottom + 4]], look.faint);
      write(pen, words, across(v), bottom + 13);
    }
    write(pen, "mean effective stress s' (kPa)", (room.left + width - room.right) / 2, bottom + 29, "center", look.soft);
    pen.save();
    pen.beginPath();
    pen.rect(room.left, room.top, width - room.left - room.right, tall);
    pen.clip();
    if (story.strength) {
      const phi = (story.strength.phi * Math.PI) / 180;
      const limit = (s) => story.strength.c * Math.cos(phi) + s * Math.sin(phi);
      stroke(pen, [[across(0), down(limit(0))], [across(mostS), down(limit(mostS))]], look.text, 1.6, [6, 4]);
      const s = Math.min(0.72 * mostS, (0.82 * mostT) / Math.sin(phi));
      pen.save();
      pen.translate(across(s), down(limit(s)) - 8);
      pen.rotate(Math.atan2(down(limit(s + 1)) - down(limit(s)), across(s + 1) - across(s)));
      write(pen, "yield line", 0, 0);
      pen.restore();
    }
    const time = frames[now].time;
    paths.forEach((path, k) => {
      if (path.off) return;
      const colour = look.series[k % look.series.length];
      const i = indexAt(path.times, time);
      const points = path.s.map((s, j) => [across(s), down(path.t[j])]);
      pen.globalAlpha = 0.28;
      stroke(pen, points, colour, 1.2);
      pen.globalAlpha = 1;
      stroke(pen, points.slice(0, i + 1), colour, 1.8);
    });
    paths.forEach((path, k) => {
      if (path.off) return;
      const i = indexAt(path.times, time);
      const [x, y] = [across(path.s[i]), down(path.t[i])];
      pen.beginPath();
      pen.arc(x, y, 4.5, 0, 2 * Math.PI);
      pen.fillStyle = look.series[k % look.series.length];
      pen.fill();
      pen.strokeStyle = look.back;
      pen.lineWidth = 1.2;
      pen.stroke();
      pen.lineWidth = 3;
      pen.textAlign = "left";
      pen.strokeText(path.name, x + 7, y - 7);
      write(pen, path.name, x + 7, y - 7, "left");
    });
    pen.restore();
    write(pen, "t (kPa)", room.left + 6, room.top + 11, "left", look.soft);
    pen.strokeStyle = look.line;
    pen.lineWidth = 1;
    pen.strokeRect(room.left, room.top, width - room.left - room.right, tall);
    colourKeys(paths);
    for (const path of paths) path.key.button.textContent = path.name;
    canvas.setAttribute("aria-label", `Effective stress paths of ${paths.length} observed points up to ${clockOf(time)}, with the yield line`);
  }

  // ---- events at the slider ----

  const marks = story.events.map((event) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = event.name;
    button.title = `${event.name === "rest" ? "" : `${event.name}: `}${event.words}, ${clockOf(event.time)}`;
    button.setAttribute("aria-label", button.title);
    button.addEventListener("click", () => { pause(); goTo(event.time); });
    const line = document.createElement("i");
    $("marks").append(line, button);
    return { event, button, line };
  });
  function placeMarks() {
    const room = margins();
    const width = $("map").clientWidth - room.left - room.right;
    // The middle of the thumb is half its width away from the ends of the track.
    $("slider").style.marginLeft = `${room.left - 8}px`;
    $("slider").style.width = `${width + 16}px`;
    const rows = [];
    for (const { event, button, line } of marks) {
      const half = button.offsetWidth / 2;
      const x = room.left + (place(event.time) / (last || 1)) * width;
      const centre = Math.max(half, Math.min(room.left + width + room.right - half, x));
      let row = rows.findIndex((end) => end + 3 <= centre - half);
      if (row < 0) row = rows.length;
      rows[row] = centre + half;
      button.style.left = `${centre}px`;
      button.style.top = `${4 + 26 * row}px`;
      line.style.left = `${x}px`;
      line.style.height = `${12 + 26 * row}px`;
    }
    $("marks").style.height = `${8 + 26 * rows.length}px`;
  }

  // ---- moving ----

  function draw() {
    choose();
    const f = frames[now];
    drawMap();
    tracks.forEach((track, k) => drawTrack(track, k === tracks.length - 1));
    drawSafety();
    drawPaths();
    $("time").textContent = f.clock;
    $("phase").textContent = f.phase;
    $("count").textContent = `frame ${now + 1} of ${frames.length}`;
    $("slider").value = now;
    $("slider").setAttribute("aria-valuetext", `${f.clock}, ${f.phase}`);
  }
  function go(number) {
    now = Math.min(last, Math.max(0, number));
    draw();
  }
  const goTo = (time) => go(Math.round(place(time)));
  function pause() {
    clearInterval(playing);
    playing = null;
    $("play").textContent = "Play";
  }
  function play() {
    if (playing !== null) return pause();
    if (now === last) now = 0;
    $("play").textContent = "Pause";
    playing = setInterval(() => (now < last ? go(now + 1) : pause()), 1000 / Number($("pace").value));
  }
  function scrub(canvas, timeOf) {
    const of = (event) => timeOf(event.clientX - canvas.getBoundingClientRect().left);
    canvas.style.cursor = "crosshair";
    canvas.addEventListener("pointerdown", (event) => {
      if (event.pointerType === "mouse") canvas.setPointerCapture(event.pointerId);
      pause();
      goTo(of(event));
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons > 0) goTo(of(event));
      pointed = of(event);
      tracks.forEach((track, k) => drawTrack(track, k === tracks.length - 1));
      drawSafety();
    });
    canvas.addEventListener("pointerleave", () => { pointed = null; draw(); });
  }

  // An address may name a frame and a quantity: #frame=40&show=pressure&water=1
  function address() {
    const asked = new URLSearchParams(location.hash.slice(1));
    if (asked.has("show")) $("shown").value = asked.get("show");
    if (asked.has("water")) $("water").checked = asked.get("water") !== "0";
    go(asked.has("frame") ? Number(asked.get("frame")) - 1 || 0 : now);
  }

  $("player").hidden = false;
  $("slider").max = last;
  if (paths.length === 0) $("points").parentElement.hidden = true;
  $("play").addEventListener("click", play);
  $("back").addEventListener("click", () => { pause(); go(now - 1); });
  $("on").addEventListener("click", () => { pause(); go(now + 1); });
  $("slider").addEventListener("input", () => { pause(); go(Number($("slider").value)); });
  for (const id of ["shown", "water", "points"]) $(id).addEventListener("change", draw);
  $("pace").addEventListener("change", () => { if (playing !== null) { pause(); play(); } });
  document.addEventListener("keydown", (event) => {
    const tag = event.target.tagName;
    const pressed = event.key === " " && (tag === "BUTTON" || tag === "SUMMARY" || tag === "A" || event.target.type === "checkbox");
    const elsewhere = tag === "SELECT" || tag === "TEXTAREA" || (tag === "INPUT" && !$("player").contains(event.target));
    if (elsewhere || pressed || event.ctrlKey || event.metaKey || event.altKey) return;
    // Where the page is scrolled away from the player, keys scroll on.
    const box = $("player").getBoundingClientRect();
    if (box.bottom < 0 || box.top > window.innerHeight) return;
    const far = event.shiftKey ? 10 : 1;
    const to = { ArrowLeft: now - far, ArrowRight: now + far, Home: 0, End: last }[event.key];
    if (event.key === " ") play();
    else if (to !== undefined) { pause(); go(to); }
    else return;
    event.preventDefault();
  });
  const again = () => { placeMarks(); draw(); };
  // The layout around it may still change its width after this script has run.
  new ResizeObserver(again).observe($("map").parentElement);
  window.addEventListener("hashchange", address);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  window.addEventListener("beforeprint", () => { printing = true; draw(); });
  window.addEventListener("afterprint", () => { printing = false; draw(); });
  choose();
  address();
})();
