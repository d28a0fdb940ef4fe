// The page: walking through sheets, looking closer, playing a run.
"use strict";
(async () => {
  const $ = (id) => document.getElementById(id);
  const esc = SAO.escape;
  const bytesOf = (text) => {
    if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
    const from = atob(text), bytes = new Uint8Array(from.length);
    for (let k = 0; k < from.length; k++) bytes[k] = from.charCodeAt(k);
    return bytes;
  };
  const unpack = (id) => new Response(new Blob([bytesOf($(id).textContent)]).stream().pipeThrough(new DecompressionStream("gzip")));

  const layouter = new SAO.Layouter(unpack("elk").blob());
  const data = await unpack("data").json();
  const layouts = new Map(), laidOut = new Set();
  const sheet = $("sheet");
  let player = null, pins = [], chosen = null, here = null, view = null, wanted = 0;
  const show = { heat: false, values: !!data.run };

  // -- where we are: a path through the drawings, such as step3.ip[2].stages

  function walk(path) {
    const steps = [{ name: data.title, path: "", drawing: 0, where: player && player.root(), cost: data.costs }];
    let from = "";
    for (const part of path ? path.split(".") : []) {
      const at = steps[steps.length - 1], drawing = data.drawings[at.drawing];
      const find = (d, name) => d.blocks.find((b) => b.n === name && b.in !== null);
      let block = find(drawing, part);
      const base = part.replace(/\[\d+\]$/, "");
      if (!block && base !== part) {
        const stack = find(drawing, base);
        if (stack) {
          steps.push({ name: base, path: join(from, base), drawing: stack.in, where: at.where, cost: at.cost, stack: true });
          block = find(data.drawings[stack.in], part);
        }
      }
      if (!block) break;
      const last = steps[steps.length - 1], stacked = block.k === "stack";
      const where = last.where && !stacked ? player.enter(last.where, block.call) : last.where;
      steps.push({ name: part, path: join(from, part), drawing: block.in, where, stack: stacked,
                   cost: stacked ? last.cost : last.cost && last.cost.parts[part] });
      if (!stacked) from = join(from, part);
    }
    return steps;
  }
  const join = (a, b) => (a ? a + "." + b : b);
  const typesOf = (drawing) => data.wires[drawing.body].map((t) => (t === null ? null : data.types[t]));
  const nameOfWire = (drawing, wire) => {
    for (const t of drawing.inputs) if (t.w === wire) return t.n;
    for (const b of drawing.blocks) for (const o of b.o) if (o.w === wire) return b.k === "symbol" || b.o.length === 1 ? b.n : `${b.n}.${o.n}`;
    return "wire";
  };

  function layoutOf(number) {
    if (!layouts.has(number)) {
      const drawing = data.drawings[number], graph = SAO.graph(drawing, typesOf(drawing), !!data.run);
      layouts.set(number, layouter.layout(graph).finally(() => laidOut.add(number)));
    }
    return layouts.get(number);
  }

  async function go(path, keepView) {
    const turn = ++wanted;
    const steps = walk(path), at = steps[steps.length - 1];
    const drawing = data.drawings[at.drawing];
    $("busy").hidden = laidOut.has(at.drawing);
    crumbs(steps);
    const layout = await layoutOf(at.drawing);
    if (turn !== wanted) return;
    $("busy").hidden = true;
    here = { ...at, drawing, number: at.drawing, layout, types: typesOf(drawing), steps };
    chosen = null;
    if (!keepView) fit();  // before anything is in it: what is drawn is laid out once, in its size
    sheet.innerHTML = SAO.MARKER + SAO.render(drawing, layout, here.types);
    if (decodeURIComponent(location.hash.slice(1)) !== at.path) history.pushState(null, "", "#" + encodeURI(at.path));
    document.title = `${at.name} · ${data.title}`;
    about();
    if (player || pins.length || show.heat) paint();
    document.body.dataset.ready = at.path || "root";
  }

  function crumbs(steps) {
    $("crumbs").innerHTML = steps.map((s, k) => `${k ? '<span class="sep">›</span>' : ""}<button data-go="${esc(s.path)}">${esc(s.name)}${s.stack ? " ▤" : ""}</button>`).join("");
  }

  // -- zoom

  function fit() {
    const { width, height } = here.layout, box = sheet.getBoundingClientRect();
    const scale = Math.min(box.width / width, box.height / height, 1.6);
    view = { x: (width - box.width / scale) / 2, y: (height - box.height / scale) / 2, scale };
    look();
  }
  const FAR = 0.1;  // below this scale letters are a pixel high: they are left out, which makes large sheets quick
  function look() {
    const box = sheet.getBoundingClientRect();
    sheet.classList.toggle("far", view.scale < FAR);
    sheet.setAttribute("viewBox", `${view.x} ${view.y} ${box.width / view.scale} ${box.height / view.scale}`);
  }
  function zoom(factor, x, y) {
    const box = sheet.getBoundingClientRect();
    const px = x === undefined ? box.width / 2 : x - box.left, py = y === undefined ? box.height / 2 : y - box.top;
    const scale = Math.min(6, Math.max(0.05, view.scale * factor));
    view.x += px / view.scale - px / scale; view.y += py / view.scale - py / scale; view.scale = scale;
    look();
  }
  sheet.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(-e.deltaY * 0.0015), e.clientX, e.clientY); }, { passive: false });
  let drag = null;
  sheet.addEventListener("pointerdown", (e) => { drag = { x: e.clientX, y: e.clientY, moved: false }; });
  addEventListener("pointermove", (e) => {
    if (!drag) return;
    const dx = e.clientX - drag.x, dy = e.clientY - drag.y;
    if (Math.abs(dx) + Math.abs(dy) > 3) drag.moved = true;
    if (!drag.moved) return;
    view.x -= dx / view.scale; view.y -= dy / view.scale; drag.x = e.clientX; drag.y = e.clientY; look();
  });
  addEventListener("pointerup", () => setTimeout(() => (drag = null)));
  addEventListener("resize", () => here && look());
  addEventListener("beforeprint", () => {
    if (!here) return;
    sheet.classList.remove("far");
    sheet.setAttribute("viewBox", `0 0 ${here.layout.width} ${here.layout.height}`);
  });
  addEventListener("afterprint", () => here && look());

  // -- what was meant by a click

  const hitOf = (target) => target.closest && (target.closest("[data-block]") || target.closest("[data-terminal]") || target.closest("[data-wire]"));
  sheet.addEventListener("click", (e) => {
    if (drag && drag.moved) return;
    choose(hitOf(e.target));
  });
  sheet.addEventListener("dblclick", (e) => open(hitOf(e.target)));
  sheet.addEventListener("pointerover", (e) => { if (!chosen) describe(hitOf(e.target)); });
  function open(hit) {
    if (!hit || hit.dataset.block === undefined) return;
    const block = here.drawing.blocks[hit.dataset.block];
    if (block.in === null) return;
    const outer = here.stack ? here.steps[here.steps.length - 2].path : here.path;
    go(join(outer, block.n));
  }
  function choose(hit) {
    sheet.querySelectorAll(".chosen,.near").forEach((g) => g.classList.remove("chosen", "near"));
    if (hit && chosen === hit && hit.dataset.block !== undefined) return open(hit);
    chosen = hit || null;
    if (!hit) return about();
    hit.classList.add(hit.dataset.wire === undefined ? "chosen" : "near");
    describe(hit);
  }

  // -- the panel

  const unit = (type) => (!type ? "" : `${type[2] ? "boolean" : "real"}${type[0].length ? " [" + type[0].join(", ") + "]" : ""}${type[1] ? " " + type[1] : ""}`);
  const short = (x) => (Number.isNaN(x) ? "NaN" : !Number.isFinite(x) ? (x > 0 ? "∞" : "−∞") : x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(2) : String(+x.toPrecision(4)));
  const sizeOf = (type) => (type ? type[0].reduce((a, b) => a * b, 1) : 1);
  const whereOf = (wire, loc = here.where) => (player && loc ? player.places(loc, wire, sizeOf(here.types[wire])) : null);
  function valuesOf(wire, loc) { const p = whereOf(wire, loc); return p && player.values(p); }

  function matrix(values, type) {
    if (!values) return "";
    if (type[0].length === 0) return `<p class="mono">${short(values[0])}${type[1] ? " " + esc(type[1]) : ""}</p>`;
    const columns = type[0][type[0].length - 1] || 1, top = Math.max(...values.map((v) => (Number.isFinite(v) ? Math.abs(v) : 0))) || 1;
    let rows = "";
    for (let k = 0; k < Math.min(values.length, 400); k += columns) {
      rows += "<tr>" + values.slice(k, k + columns).map((v) => `<td style="background:color-mix(in srgb,var(--estimate) ${Math.round(35 * Math.min(1, Math.abs(v) / top || 0))}%,transparent)">${short(v)}</td>`).join("") + "</tr>";
    }
    return `<div class="matrix"><table>${rows}</table></div>`;
  }
  const source = (file, line, text) => `<p class="soft mono">${esc(file)}:${line}</p>${text ? `<pre>${esc(text)}</pre>` : ""}`;

  function about() {
    const d = here.drawing, cost = here.cost;
    const kinds = cost ? Object.entries(cost.kinds || {}).map(([k, v]) => `<tr><td>${k}</td><td class="number">${v.toLocaleString("en").replace(/,/g, "\u202f")}</td></tr>`).join("") : "";
    $("panel").innerHTML = `<h2>${esc(d.sheet)}</h2><p class="soft">${here.stack ? `${d.blocks.length + d.left} instances${d.left ? `, ${d.blocks.length} shown` : ""}` : "sheet"}</p>` +
      (d.doc ? `<p>${esc(d.doc)}</p>` : "") + (d.eq ? `<h3>Equations</h3><p>${esc(d.eq)}</p>` : "") + source(d.f, d.l, "") +
      (cost && !here.stack ? `<h3>Operations a frame</h3><p class="mono">${cost.total.toLocaleString("en").replace(/,/g, "\u202f")}${data.limit ? `${here.path ? ", " + (100 * cost.total / data.costs.total).toFixed(1) + " % of the frame" : " of " + data.limit.toLocaleString("en").replace(/,/g, "\u202f") + " in the budget"}` : ""}</p><table>${kinds}</table>` : "") +
      (d.inputs.length ? `<h3>Inputs</h3>${terminals(d.inputs)}` : "") + (d.outputs.length ? `<h3>Outputs</h3>${terminals(d.outputs)}` : "");
  }
  const terminals = (list) => `<table>${list.map((t) => `<tr><td>${esc(t.n)}</td><td class="soft">${esc(unit(here.types[t.w]))}</td></tr>${t.d ? `<tr><td></td><td class="soft">${esc(t.d)}</td></tr>` : ""}`).join("")}</table>`;

  function describe(hit) {
    if (!here) return;
    if (!hit) return about();
    if (hit.dataset.wire !== undefined) return describeWire(Number(hit.dataset.wire));
    if (hit.dataset.terminal !== undefined) {
      const side = hit.dataset.terminal[0], t = here.drawing[side === "i" ? "inputs" : "outputs"][hit.dataset.terminal.slice(1)];
      return describeWire(t.w, t);
    }
    const b = here.drawing.blocks[hit.dataset.block], symbol = data.symbols[b.of] || data.sheets[b.of];
    const cost = costOf(b);
    $("panel").innerHTML = `<h2>${esc(b.n)}${b.k === "stack" ? ` ×${b.count}` : ""}</h2><p class="soft">${esc(b.k === "symbol" ? "symbol" : b.k)} ${esc(b.of)}</p>` +
      (symbol ? `<p>${esc(symbol[0])}</p>${symbol[1] ? `<h3>${b.k === "symbol" ? "Equation" : "Equations"}</h3><p>${esc(symbol[1])}</p>` : ""}` : "") +
      source(b.f, b.l, b.src) + (cost !== null ? `<h3>Operations a frame</h3><p class="mono">${cost.toLocaleString("en").replace(/,/g, "\u202f")}</p>` : "") +
      (b.in !== null ? `<button data-open="${hit.dataset.block}">open</button>` : "") +
      ports("Inputs", b.i) + ports("Outputs", b.o, b);
    $("panel").querySelectorAll("[data-open]").forEach((x) => x.addEventListener("click", () => open(hit)));
  }
  function ports(title, list, block) {
    if (!list.length) return "";
    return `<h3>${title}</h3>` + list.map((p) => {
      const type = here.types[p.w], values = valuesOf(p.w);
      return `<p><b>${esc(p.n || (block ? block.n : p.t) || "")}</b> ${p.n && p.t ? `<span class="soft">${esc(p.t)}</span> ` : ""}<span class="soft">${esc(unit(type))}</span>${p.c ? ' <span class="soft">from the instance before</span>' : ""}</p>` + (values ? matrix(values, type) : "");
    }).join("");
  }
  function describeWire(wire, terminal) {
    const type = here.types[wire], name = nameOfWire(here.drawing, wire), values = valuesOf(wire);
    const block = here.drawing.blocks.find((b) => b.o.some((o) => o.w === wire));
    $("panel").innerHTML = `<h2>${esc(terminal ? terminal.n : name)}</h2><p class="soft">${terminal ? "port" : "wire"}, ${esc(unit(type))}</p>` +
      (terminal && terminal.d ? `<p>${esc(terminal.d)}</p>` : "") + (block ? source(block.f, block.l, block.src) : "") +
      `<p class="mono soft">${esc(join(here.path, name))}</p>` + (player ? `<button id="pinit">pin (p)</button>` : "") + matrix(values, type || [[], "", false]);
    const button = $("pinit");
    if (button) button.addEventListener("click", () => pin(wire, terminal ? terminal.n : name));
    sheet.dataset.wire = wire;
  }

  // -- overlays: cost, values, what is lit

  function costOf(b) {
    if (!here.cost) return null;
    if (b.k !== "stack") return here.cost.parts[b.n] ? here.cost.parts[b.n].total : 0;
    return Object.entries(here.cost.parts).filter(([n]) => n.startsWith(b.n + "[")).reduce((a, [, t]) => a + t.total, 0);
  }
  function shown(values, type) {
    if (!values) return "";
    const brief = (x) => (x === 0 || !Number.isFinite(x) ? short(x) : Math.abs(x) >= 1e4 || Math.abs(x) < 1e-2 ? x.toExponential(1) : String(+x.toPrecision(3)));
    if (values.length <= 3) return values.map(type && type[2] ? short : brief).join(" ");
    return brief(values[0]) + " …";
  }
  function paint() {
    if (!here) return;
    const layer = sheet.querySelector(".values"), at = new Map(here.layout.children.map((c) => [c.id, c]));
    let text = "";
    const costs = here.drawing.blocks.map(costOf), top = Math.max(1, ...costs.map((c) => c || 0));
    sheet.querySelectorAll("[data-block]").forEach((g) => {
      const k = g.dataset.block, b = here.drawing.blocks[k];
      g.classList.toggle("heated", show.heat && costs[k] > 0);
      if (show.heat && costs[k] !== null) {
        g.style.setProperty("--heat", `color-mix(in srgb, var(--limit) ${Math.round(6 + 60 * Math.sqrt(costs[k] / top))}%, var(--paper))`);
        const node = at.get("b" + k);
        if (costs[k]) text += `<text class="cost" x="${node.x + node.width / 2}" y="${node.y + node.height + 11}">${costs[k]}</text>`;
      }
      g.classList.toggle("lit", !!player && show.values && lit(b));
    });
    if (player && show.values) {
      const label = (id, port, wire) => {
        const values = valuesOf(wire), type = here.types[wire];
        if (!values) return;
        const node = at.get(id), p = node.ports.find((q) => q.id === port);
        const on = type && type[2] && values.some((v) => v);
        text += `<text class="value${on ? " on" : ""}" x="${node.x + p.x + 4}" y="${node.y + p.y + 11}">${esc(shown(values, type))}</text>`;
      };
      here.drawing.inputs.forEach((t, k) => label("i" + k, `i${k}.o`, t.w));
      here.drawing.blocks.forEach((b, k) => { if (b.k !== "stack") b.o.forEach((o, j) => label("b" + k, `b${k}.o${j}`, o.w)); });
    }
    layer.innerHTML = text;
    sheet.querySelectorAll("[data-wire]").forEach((g) => {
      const type = here.types[g.dataset.wire], values = player && show.values && type && type[2] ? valuesOf(g.dataset.wire) : null;
      g.classList.toggle("lit", !!values && values.some((v) => v));
      g.classList.toggle("pinned", pins.some((p) => p.path === here.path && p.wire === Number(g.dataset.wire)));
    });
    here.drawing.outputs.forEach((t, k) => {
      const g = sheet.querySelector(`[data-terminal="o${k}"]`), type = here.types[t.w];
      const values = player && show.values ? valuesOf(t.w) : null;
      const flag = type && (type[2] || /(^|_)(faulty|lost|over)/.test(t.n));
      if (g) g.classList.toggle("lit", !!values && flag && values.some((v) => v));
    });
    $("legend").textContent = show.heat ? "Operations a frame, below each block" : player && show.values ? "Lit: flags that are up, limiters at a limit, tables at an end" : "";
  }
  // A limiter at its limit, a table at an end, a flag that is up.
  function lit(b) {
    if (b.k !== "symbol") return false;
    const out = valuesOf(b.o[0].w), type = here.types[b.o[0].w];
    if (!out) return false;
    if (type && type[2]) return out.some((v) => v);
    const given = b.i.length ? valuesOf(b.i[0].w) : null;
    if (b.of === "saturation" && given) return out.some((v, k) => v !== given[given.length === 1 ? 0 : k]);
    if (b.of === "lookup" && given) return b.i.some((p, axis) => (valuesOf(p.w) || []).some((v) => !(v > b.tab[axis][0] && v < b.tab[axis][1])));
    return false;
  }

  // -- a run

  function pin(wire, name) {
    if (!player || wire === undefined) return;
    const places = whereOf(wire);
    if (!places) return;
    const path = here.path, known = pins.findIndex((p) => p.path === path && p.wire === wire);
    if (known >= 0) pins.splice(known, 1);
    else pins.push({ path, wire, name: join(path, name), type: here.types[wire], rows: player.series(places.slice(0, 12)) });
    drawPins(); paint();
  }
  const COLOURS = ["var(--estimate)", "var(--limit)", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a8a8a", "#d55e00"];
  function drawPins() {
    $("pins").innerHTML = pins.map((p, k) => {
      const finite = p.rows.flatMap((r) => [Math.min(...r.filter(Number.isFinite)), Math.max(...r.filter(Number.isFinite))]).filter(Number.isFinite);
      let low = Math.min(...finite), high = Math.max(...finite);
      if (!(high > low)) { low -= 0.5; high = low + 1; }
      const x = (i) => 40 + (i / Math.max(1, data.run.frames - 1)) * 556, y = (v) => 64 - ((v - low) / (high - low)) * 56;
      const lines = p.rows.map((r, e) => {
        const step = Math.max(1, Math.floor(r.length / 700));
        let d = "", up = true;
        for (let i = 0; i < r.length; i += step) { if (!Number.isFinite(r[i])) { up = true; continue; } d += `${up ? "M" : "L"}${x(i).toFixed(1)} ${y(r[i]).toFixed(1)}`; up = false; }
        return `<path d="${d}" fill="none" stroke="${COLOURS[e % 8]}" stroke-width="1.2"/>`;
      }).join("");
      return `<div class="pin" data-pin="${k}"><div class="head"><b>${esc(p.name)}</b><span class="soft">${esc(p.type ? p.type[1] : "")}</span><button aria-label="unpin">✕</button></div>` +
        `<svg viewBox="0 0 600 74" preserveAspectRatio="none"><path d="M40 8V64H596" fill="none" stroke="var(--rule)"/>${lines}<path class="cursor" stroke="var(--ink)" stroke-width="1"/>` +
        `<text x="2" y="14">${short(high)}</text><text x="2" y="66">${short(low)}</text></svg></div>`;
    }).join("");
    $("pins").querySelectorAll(".pin").forEach((div) => {
      div.querySelector("button").addEventListener("click", () => { pins.splice(Number(div.dataset.pin), 1); drawPins(); paint(); });
      const svg = div.querySelector("svg");
      const scrub = (e) => { const box = svg.getBoundingClientRect(); seek(Math.round(((e.clientX - box.left) / box.width * 600 - 40) / 556 * (data.run.frames - 1))); };
      svg.addEventListener("pointerdown", (e) => { scrub(e); svg.setPointerCapture(e.pointerId); svg.onpointermove = scrub; });
      svg.addEventListener("pointerup", () => (svg.onpointermove = null));
    });
    cursors();
  }
  function cursors() {
    $("pins").querySelectorAll(".cursor").forEach((c) => { const x = 40 + (player.at / Math.max(1, data.run.frames - 1)) * 556; c.setAttribute("d", `M${x} 6V66`); });
  }
  function seek(k) {
    k = Math.max(0, Math.min(data.run.frames - 1, k));
    player.seek(k);
    $("time").value = k;
    const seconds = data.run.period ? `${(k * data.run.period).toFixed(3)} s, ` : "";
    $("clock").textContent = `${seconds}frame ${k} of ${data.run.frames}`;
    document.body.dataset.frame = k;
    cursors(); paint();
    if (chosen) describe(chosen);
  }
  let playing = null;
  function play() {
    if (playing) { cancelAnimationFrame(playing); playing = null; $("play").textContent = "▶"; return; }
    if (player.at >= data.run.frames - 1) seek(0);
    $("play").textContent = "❚❚";
    let last = performance.now(), due = player.at;
    const tick = (now) => {
      due += (now - last) / 1000 / (data.run.period || 0.05) * Number($("speed").value); last = now;
      if (Math.floor(due) !== player.at) seek(Math.floor(due));
      if (player.at >= data.run.frames - 1) { playing = null; $("play").textContent = "▶"; return; }
      playing = requestAnimationFrame(tick);
    };
    playing = requestAnimationFrame(tick);
  }

  // -- search

  function* everything() {
    const queue = [{ path: "", number: 0 }];
    let count = 0;
    while (queue.length && count < 60000) {
      const { path, number } = queue.shift(), d = data.drawings[number];
      for (const b of d.blocks) {
        count++;
        const outer = d.kind === "stack" ? path.replace(/\.?[^.]*$/, "") : path, inner = join(outer, b.n);
        yield { path, block: b, text: inner };
        if (b.in !== null) queue.push({ path: inner, number: b.in });
      }
    }
  }
  $("search").addEventListener("input", () => {
    const word = $("search").value.trim().toLowerCase();
    const box = $("found");
    if (word.length < 2) return (box.hidden = true);
    const hits = [];
    for (const e of everything()) {
      if (e.text.toLowerCase().includes(word) || e.block.of.toLowerCase().includes(word)) hits.push(e);
      if (hits.length >= 400) break;
    }
    hits.sort((a, b) => a.text.split(".").length - b.text.split(".").length || a.text.length - b.text.length);
    box.hidden = false;
    box.innerHTML = hits.slice(0, 40).map((e, k) => `<button data-hit="${k}">${esc(e.text)}<small>${esc(e.block.of)}</small></button>`).join("") || "<button disabled>nothing of that name</button>";
    box.querySelectorAll("[data-hit]").forEach((x) => x.addEventListener("click", async () => {
      const e = hits[x.dataset.hit];
      box.hidden = true; $("search").value = "";
      await go(e.path);
      const k = here.drawing.blocks.findIndex((b) => b.n === e.block.n);
      choose(sheet.querySelector(`[data-block="${k}"]`));
    }));
  });

  // -- keyboard, buttons, history

  const up = () => here.steps.length > 1 && go(here.steps[here.steps.length - 2].path);
  function nextIn(key) {
    const items = [...sheet.querySelectorAll("[data-block],[data-terminal]")];
    const middle = (g) => { const r = g.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; };
    const now = chosen && chosen.dataset.wire === undefined ? chosen : null;
    if (!now) return items[0];
    const [x, y] = middle(now), [dx, dy] = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] }[key];
    let best = now, least = Infinity;
    for (const g of items) {
      const [a, b] = middle(g), along = (a - x) * dx + (b - y) * dy, across = Math.abs((a - x) * dy) + Math.abs((b - y) * dx);
      if (along > 4 && along + 2 * across < least) { least = along + 2 * across; best = g; }
    }
    return best;
  }
  addEventListener("keydown", (e) => {
    if (e.target.tagName === "INPUT" && e.key !== "Escape") return;
    if (e.ctrlKey || e.metaKey || e.altKey || !here) return;
    const key = e.key;
    if (key.startsWith("Arrow")) { if (e.shiftKey && player) seek(player.at + (key === "ArrowRight" ? 1 : key === "ArrowLeft" ? -1 : 0)); else { const g = nextIn(key); chosen = null; choose(g); g.focus(); } }
    else if (key === "Enter") { if (chosen) open(chosen); else return; }
    else if (key === "Backspace" || key === "u") up();
    else if (key === "Escape") { $("found").hidden = $("keys").hidden = true; $("search").blur(); choose(null); }
    else if (key === "/") $("search").focus();
    else if (key === "+" || key === "=") zoom(1.25);
    else if (key === "-") zoom(0.8);
    else if (key === "0" || key === "f") fit();
    else if (key === "c") toggle("heat");
    else if (key === "v" && player) toggle("values");
    else if (key === "p" && chosen) { const d = chosen.dataset; if (d.wire !== undefined) pin(Number(d.wire), nameOfWire(here.drawing, Number(d.wire))); else if (d.block !== undefined && here.drawing.blocks[d.block].o[0]) { const o = here.drawing.blocks[d.block].o[0]; pin(o.w, nameOfWire(here.drawing, o.w)); } else if (d.terminal) { const t = here.drawing[d.terminal[0] === "i" ? "inputs" : "outputs"][d.terminal.slice(1)]; pin(t.w, t.n); } }
    else if (key === "?") help();
    else if (key === "s") side();
    else if (key === " " && player) play();
    else return;
    e.preventDefault();
  });
  function toggle(what) { show[what] = !show[what]; $(what).setAttribute("aria-pressed", show[what]); paint(); }
  $("heat").addEventListener("click", () => toggle("heat"));
  $("values").addEventListener("click", () => toggle("values"));
  $("fit").addEventListener("click", fit);
  const help = () => ($("keys").hidden = !$("keys").hidden);
  const side = () => { const off = document.body.classList.toggle("narrow"); $("panel").hidden = off; $("side").setAttribute("aria-pressed", !off); fit(); };
  $("help").addEventListener("click", help);
  $("side").addEventListener("click", side);
  $("theme").addEventListener("click", () => {
    const dark = getComputedStyle(document.documentElement).getPropertyValue("--is-dark").trim() === "1";
    document.documentElement.dataset.theme = dark ? "light" : "dark";
  });
  $("crumbs").addEventListener("click", (e) => { const b = e.target.closest("[data-go]"); if (b) go(b.dataset.go); });
  addEventListener("popstate", () => go(decodeURIComponent(location.hash.slice(1))));

  // -- start

  const first = decodeURIComponent(location.hash.slice(1));
  if (data.run) {
    layoutOf(walk(first).pop().drawing);  // which goes on while the run is computed
    const inputs = new Float64Array(await unpack("inputs").arrayBuffer());
    player = new SAO.Player({ ...data.run, inputs }, globalThis.frame);
    $("run").hidden = false; $("values").hidden = false; $("values").setAttribute("aria-pressed", "true");
    $("time").max = data.run.frames - 1;
    $("time").addEventListener("input", () => seek(Number($("time").value)));
    $("play").addEventListener("click", play);
    seek(0);
  }
  await go(first);
  // Open to scripts and tests: the same calls that the page makes.
  globalThis.saoView = { go, seek, pin, player: () => player, here: () => here, data };
})();
