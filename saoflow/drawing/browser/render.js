// From a drawing and its layout to SVG text. No document is needed here, so documents get the same pictures as the page.
"use strict";
{
  const esc = (text) => String(text).replace(/[&<>"']/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;" })[c]);
  SAO.escape = esc;
  const n = (x) => Math.round(x * 10) / 10;

  const thickness = (type) => (!type ? 1 : type[2] ? 1.2 : type[0].length === 0 ? 1.2 : type[0].length === 1 ? 2 : 2.8);

  function wirePath(edge) {
    return (edge.sections || []).map((s) => {
      const points = [s.startPoint, ...(s.bendPoints || []), s.endPoint];
      return points.map((p, k) => `${k ? "L" : "M"}${n(p.x)} ${n(p.y)}`).join("");
    }).join("");
  }

  function text(x, y, what, kind, anchor = "start") {
    return `<text class="${kind}" x="${n(x)}" y="${n(y)}" text-anchor="${anchor}">${esc(what)}</text>`;
  }

  function terminal(node, t, side, k) {
    const { width: w, height: h } = node;
    const shape = `M0 0H${w - 9}L${w} ${h / 2}L${w - 9} ${h}H0Z`;
    return `<g class="terminal ${side}" data-terminal="${side}${k}" transform="translate(${n(node.x)} ${n(node.y)})" tabindex="0" role="button" aria-label="${side === "i" ? "input" : "output"} ${esc(t.n)}">` +
      `<path class="box" d="${shape}"/>${text(9, h / 2 + 4, SAO.short(t.n), "name")}</g>`;
  }

  function sheetBox(node, block, types) {
    const { width: w, height: h } = node;
    let svg = "";
    if (block.k === "stack") {
      svg += `<rect class="box under" x="8" y="-8" width="${w}" height="${h}" rx="5"/><rect class="box under" x="4" y="-4" width="${w}" height="${h}" rx="5"/>`;
    }
    svg += `<rect class="box" width="${w}" height="${h}" rx="5"/><path class="rule" d="M0 33H${w}"/>`;
    const of = [block.of === block.n ? "" : SAO.short(block.of, 28), block.rate].filter(Boolean).join(", ");
    svg += text(w / 2, of ? 16 : 21, SAO.short(block.n, 24) + (block.k === "stack" ? ` ×${block.count}` : ""), "title", "middle");
    if (of) svg += text(w / 2, 28, of, "of", "middle");
    block.i.forEach((p, k) => (svg += text(8, SAO.portHeight(block, node, k, 0) + 4, SAO.short(p.n, 18) + (p.c ? " ↻" : ""), "port")));
    block.o.forEach((p, k) => {
      const shape = SAO.shape(types[p.w]), y = n(SAO.portHeight(block, node, k, 0) + 4);
      svg += `<text class="port" x="${w - 8}" y="${y}" text-anchor="end">${shape ? `<tspan class="shape">${shape}</tspan> ` : ""}${esc(SAO.short(p.n, 18))}</text>`;
    });
    return svg;
  }

  function symbolBox(node, block) {
    const { width: w, height: h } = node;
    const round = block.of === "add" ? 24 : block.of === "delay" ? 2 : 5;
    let svg = `<rect class="box" width="${w}" height="${h}" rx="${round}"/>`;
    if (block.of === "inv2") svg += `<path class="rule" d="M7 7V${h - 7}M${w - 7} 7V${h - 7}"/>`;
    svg += `<g transform="translate(${w / 2} ${h / 2})">${block.g}</g>`;
    if (block.i.length > 1) {
      block.i.forEach((p, k) => {
        const y = SAO.portHeight(block, node, k, block.i.length);
        if (p.n) svg += text(p.n === "+" || p.n === "−" ? 5 : 3, y + 3.5, p.n.slice(0, 4), "sign-port");
      });
    }
    return svg;
  }

  function portTexts(node, block, types) {
    let svg = "";
    for (const port of node.ports) {
      const label = port.labels && port.labels[0];
      if (!label) continue;
      const west = port.x === 0;
      const index = Number(port.id.split(/\.[io]/)[1] || 0);
      if (west) {
        const what = block ? block.i[index].t : label.text;
        svg += text(port.x - 4, port.y - 4, SAO.short(what, 24), "operand", "end");
      } else if (block) {
        const { name, shape } = SAO.wireLabel(block, types[block.o[index].w]);
        if (name || shape) svg += `<text class="wire-name" x="${n(port.x + 4)}" y="${n(port.y - 4)}">${esc(name)}${shape ? `<tspan class="shape" dx="${name ? 4 : 0}">${shape}</tspan>` : ""}</text>`;
      } else if (label.text.trim()) {
        svg += text(port.x + 4, port.y - 4, label.text, "wire-name shape");
      }
    }
    return svg;
  }

  // The drawing as the inside of an <svg>. `types`: type of every wire of its body, [shape, unit, boolean].
  SAO.render = function (drawing, layout, types) {
    const byId = new Map(layout.children.map((c) => [c.id, c]));
    const connections = SAO.edges(drawing);
    let wires = "", blocks = "";
    layout.edges.forEach((edge, k) => {
      const c = connections[k], type = types[c.wire];
      const kind = `wire${type && type[2] ? " boolean" : ""}${c.back ? " back" : ""}`;
      const d = wirePath(edge);
      wires += `<g class="${kind}" data-wire="${c.wire}" data-from="${c.from}" data-to="${c.to}"><path class="hit" d="${d}"/><path class="line" d="${d}" style="stroke-width:${thickness(type)}" marker-end="url(#arrow)"/>`;
      (edge.junctionPoints || []).forEach((p) => (wires += `<circle class="junction" cx="${n(p.x)}" cy="${n(p.y)}" r="2.6"/>`));
      wires += "</g>";
    });
    drawing.inputs.forEach((t, k) => {
      const node = byId.get("i" + k);
      blocks += terminal(node, t, "i", k);
      blocks += `<g transform="translate(${n(node.x)} ${n(node.y)})">${portTexts(node, null, types)}</g>`;
    });
    drawing.outputs.forEach((t, k) => {
      const node = byId.get("o" + k);
      blocks += terminal(node, t, "o", k);
      blocks += `<g transform="translate(${n(node.x)} ${n(node.y)})">${portTexts(node, null, types)}</g>`;
    });
    drawing.blocks.forEach((block, k) => {
      const node = byId.get("b" + k);
      const kind = block.k === "symbol" ? `symbol s-${block.of}${block.ft ? "" : " state"}` : block.k;
      const opens = block.in !== null ? " opens" : "";
      const label = `${block.k === "symbol" ? block.of : block.k} ${block.n}`;
      blocks += `<g class="block ${kind}${opens}" data-block="${k}" transform="translate(${n(node.x)} ${n(node.y)})" tabindex="0" role="button" aria-label="${esc(label)}">` +
        (block.k === "symbol" ? symbolBox(node, block) : sheetBox(node, block, types)) + portTexts(node, block, types) + "</g>";
    });
    return `<g class="wires">${wires}</g><g class="blocks">${blocks}</g><g class="values"></g>`;
  };

  SAO.MARKER = '<defs><marker id="arrow" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" markerUnits="userSpaceOnUse" orient="auto"><path class="arrow" d="M0 1L7 4L0 7Z"/></marker></defs>';
}
