"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const model = JSON.parse($("model").textContent);
  const text = atob($("data").textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const frames = model.frames;
  const [left, low, right, high] = model.window;
  const kinds = model.quantities.length;

  // Where each frame begins: coordinates of two bytes, a byte per quantity, coordinates of the water.
  let begin = 0;
  for (const f of frames) {
    f.begin = begin;
    begin += f.solid * (4 + kinds) + f.water * 4;
  }

  const canvas = $("map");
  const pen = canvas.getContext("2d");
  let now = 0;
  let playing = null;

  const round = (start, end, most) => {
    const rough = (end - start) / most;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
    const ticks = [];
    for (let k = Math.ceil(start / step); k * step <= end * (1 + 1e-9); k++) ticks.push(k * step);
    const decimals = Math.max(0, -Math.floor(Math.log10(step)));
    return ticks.map((v) => [v, v === 0 ? "0" : v.toFixed(decimals).replace("-", "\u2212")]);
  };

  function draw() {
    const wide = canvas.clientWidth || 960;
    const room = { left: 46, right: 10, top: 8 };
    const unit = (wide - room.left - room.right) / (right - left);
    const bottom = room.top + (high - low) * unit;
    const shown = model.quantities.findIndex((q) => q.name === $("shown").value);
    const tall = bottom + 44 + (shown < 0 ? 0 : 56);
    const fine = window.devicePixelRatio || 1;
    canvas.width = Math.round(wide * fine);
    canvas.height = Math.round(tall * fine);
    canvas.style.height = tall + "px";
    pen.setTransform(fine, 0, 0, fine, 0, 0);
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, wide, tall);
    pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
    const across = (x) => room.left + (x - left) * unit;
    const down = (y) => bottom - (y - low) * unit;

    if (model.tank > 0) {
      pen.fillStyle = "#c6e0f3";
      pen.fillRect(across(left), down(model.tank), across(0) - across(left), down(0) - down(model.tank));
    }
    const f = frames[now];
    const two = (at) => bytes[at] + 256 * bytes[at + 1];
    const place = (at) => [
      room.left + (two(at) / 65535) * (right - left) * unit,
      bottom - (two(at + 2) / 65535) * (high - low) * unit,
    ];
    const edge = model.edge * unit + 0.7;
    const values = f.begin + (4 + shown) * f.solid;
    pen.fillStyle = "#ddc89e";
    for (let p = 0; p < f.solid; p++) {
      const [x, y] = place(f.begin + 4 * p);
      if (shown >= 0) pen.fillStyle = model.colours[bytes[values + p]];
      pen.fillRect(x - edge / 2, y - edge / 2, edge, edge);
    }
    if ($("water").checked) {
      // Blue with a white heart: seen on dark and on light soil.
      const first = f.begin + (4 + kinds) * f.solid;
      const outer = Math.min(5, Math.max(1.6, 0.42 * edge));
      for (const [colour, size] of [["#005b8f", outer], ["#fff", 0.5 * outer]]) {
        pen.fillStyle = colour;
        for (let p = 0; p < f.water; p++) {
          const [x, y] = place(first + 4 * p);
          pen.fillRect(x - size / 2, y - size / 2, size, size);
        }
      }
    }
    pen.lineWidth = 1.4;
    if ($("outline").checked) {
      pen.strokeStyle = "#000";
      pen.beginPath();
      for (const [x, y] of model.outline) pen.lineTo(across(x), down(y));
      pen.closePath();
      pen.stroke();
    }
    frame(across, down, room, wide, bottom);
    if (shown >= 0) bar(model.quantities[shown], room, wide, bottom + 52);
    $("time").textContent = f.time;
    $("phase").textContent = f.phase;
    $("count").textContent = "frame " + (now + 1) + " of " + frames.length;
    $("slider").value = now;
    $("slider").setAttribute("aria-valuetext", f.time + ", " + f.phase);
  }

  function frame(across, down, room, wide, bottom) {
    pen.lineWidth = 1;
    pen.strokeStyle = "#6e6e6e";
    pen.strokeRect(room.left, room.top, wide - room.left - room.right, bottom - room.top);
    pen.fillStyle = "#000";
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const [x, name] of round(left, right, 10)) {
      pen.fillRect(across(x) - 0.5, bottom, 1, 5);
      pen.fillText(name, across(x), bottom + 8);
    }
    pen.fillText("x (m)", (room.left + wide - room.right) / 2, bottom + 24);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const [y, name] of round(low, high, 4)) {
      pen.fillRect(room.left - 5, down(y) - 0.5, 5, 1);
      pen.fillText(name, room.left - 8, down(y));
    }
    pen.save();
    pen.translate(10, (room.top + bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText("y (m)", 0, 0);
    pen.restore();
  }

  function bar(quantity, room, wide, top) {
    const [start, end] = quantity.range;
    const length = wide - room.left - room.right;
    const count = model.colours.length;
    for (let k = 0; k < count; k++) {
      pen.fillStyle = model.colours[k];
      pen.fillRect(room.left + (k / count) * length, top, length / count + 0.6, 12);
    }
    pen.strokeStyle = "#6e6e6e";
    pen.strokeRect(room.left, top, length, 12);
    pen.fillStyle = "#000";
    pen.textBaseline = "top";
    pen.textAlign = "center";
    for (const [value, name] of round(start, end, 6)) {
      const x = room.left + ((value - start) / (end - start)) * length;
      pen.fillRect(x - 0.5, top + 12, 1, 4);
      pen.fillText(name, x, top + 18);
    }
    pen.fillText(quantity.label, room.left + length / 2, top + 33);
  }

  function go(number) {
    now = Math.min(frames.length - 1, Math.max(0, number));
    draw();
  }

  function pause() {
    clearInterval(playing);
    playing = null;
    $("play").textContent = "Play";
  }

  function play() {
    if (playing !== null) return pause();
    if (now === frames.length - 1) now = 0;
    $("play").textContent = "Pause";
    const on = () => (now < frames.length - 1 ? go(now + 1) : pause());
    playing = setInterval(on, 1000 / Number($("pace").value));
  }

  // An address may name a frame and a quantity: #frame=40&show=pressure&water=0
  function address() {
    const asked = new URLSearchParams(location.hash.slice(1));
    if (asked.has("show")) $("shown").value = asked.get("show");
    if (asked.has("water")) $("water").checked = asked.get("water") !== "0";
    go(asked.has("frame") ? Number(asked.get("frame")) - 1 || 0 : now);
  }

  if (frames.length === 0) return;
  $("moving").style.display = "block";
  $("slider").max = frames.length - 1;
  $("play").addEventListener("click", play);
  $("back").addEventListener("click", () => { pause(); go(now - 1); });
  $("on").addEventListener("click", () => { pause(); go(now + 1); });
  $("slider").addEventListener("input", () => { pause(); go(Number($("slider").value)); });
  for (const id of ["shown", "water", "outline"]) $(id).addEventListener("change", draw);
  $("pace").addEventListener("change", () => { if (playing !== null) { pause(); play(); } });
  document.addEventListener("keydown", (event) => {
    const tag = event.target.tagName;
    const pressed = event.key === " " && (tag === "BUTTON" || event.target.type === "checkbox");
    if (tag === "SELECT" || pressed || event.ctrlKey || event.metaKey || event.altKey) return;
    const far = event.shiftKey ? 10 : 1;
    const to = { ArrowLeft: now - far, ArrowRight: now + far, Home: 0, End: frames.length - 1 }[event.key];
    if (event.key === " ") play();
    else if (to !== undefined) { pause(); go(to); }
    else return;
    event.preventDefault();
  });
  window.addEventListener("resize", draw);
  window.addEventListener("hashchange", address);
  window.addEventListener("beforeprint", draw);
  address();
})();
