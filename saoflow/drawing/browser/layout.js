// From a drawing to a graph for elkjs: sizes of blocks, places of ports, room for labels. No document is needed here.
"use strict";
const SAO = (globalThis.SAO = globalThis.SAO || {});

SAO.FONT = 11;
SAO.width = (text, size = SAO.FONT) => Math.ceil(0.58 * size * String(text).length);
SAO.short = (text, most = 26) => (text.length > most ? text.slice(0, most - 1) + "…" : text);
SAO.shape = (type) => (type && type[0].length ? type[0].join("×") : "");

const PITCH = 22, HEAD = 38;

// Size of a block and the heights of its ports.
SAO.measure = function (block, types) {
  const rows = Math.max(block.i.length, block.o.length, 1);
  if (block.k === "symbol") {
    const height = Math.max(48, PITCH * rows + 8);
    return { width: 48, height, top: height / 2 };
  }
  const widest = (ports) => Math.max(0, ...ports.map((p) => SAO.width(SAO.short(p.n, 18)) + 0.6 * SAO.width(SAO.shape(types[p.w]))));
  const title = Math.max(SAO.width(SAO.short(block.n, 24), 13), SAO.width(SAO.short(block.of, 28), 10) + 26);
  return { width: Math.max(76, title + 20, widest(block.i) + widest(block.o) + 44), height: HEAD + PITCH * rows + 4, top: 0 };
};

SAO.portHeight = function (block, size, index, count) {
  if (block.k === "symbol") return size.height / 2 + PITCH * (index - (count - 1) / 2);
  return HEAD + PITCH * (index + 0.5);
};

// What stands on the wire behind an output: of a symbol its name, which is the wire's; a sheet names its ports inside.
SAO.wireLabel = (block, type) => (block.k === "symbol" ? { name: SAO.short(block.n), shape: SAO.shape(type) } : { name: "", shape: "" });

function portOf(id, side, y, width, label, least = 0) {
  const port = { id, x: side === "WEST" ? 0 : width, y };  // of no size; ELK finds the side by the place
  const room = Math.max(least, label ? SAO.width(label, side === "WEST" ? 9 : 10) + 4 : 0);
  if (room) port.labels = [{ text: label, width: room, height: 22 }];
  return port;
}

// The graph of one drawing. Node ids: b0, b1, ... for blocks, i0 and o0 for terminals; edges in the order of SAO.edges.
// `values`: leave room for numbers on the wires.
SAO.graph = function (drawing, types, values) {
  const typeOf = (wire) => types[wire];
  const room = (wire) => {
    if (!values) return 0;
    const type = typeOf(wire), size = type ? type[0].reduce((a, b) => a * b, 1) : 1;
    return type && type[2] ? 12 + 12 * Math.min(size, 3) : size <= 3 ? 12 + 36 * size : 56;
  };
  const children = [];
  drawing.inputs.forEach((terminal, k) => {
    const width = SAO.width(SAO.short(terminal.n)) + 26;
    children.push({
      id: "i" + k, width, height: 26, ports: [portOf(`i${k}.o`, "EAST", 13, width, SAO.shape(typeOf(terminal.w)), room(terminal.w))],
      layoutOptions: { "elk.layered.layering.layerConstraint": "FIRST", "elk.portConstraints": "FIXED_POS" },
    });
  });
  drawing.blocks.forEach((block, k) => {
    const size = SAO.measure(block, types);
    const ports = [
      ...block.i.map((p, n) =>
        portOf(`b${k}.i${n}`, "WEST", SAO.portHeight(block, size, n, block.i.length), size.width, SAO.short(p.t, 24))),
      ...block.o.map((p, n) => {
        const { name, shape } = SAO.wireLabel(block, typeOf(p.w));
        return portOf(`b${k}.o${n}`, "EAST", SAO.portHeight(block, size, n, block.o.length), size.width, `${name} ${shape}`.trim(), room(p.w));
      }),
    ];
    children.push({ id: "b" + k, width: size.width, height: size.height, ports, layoutOptions: { "elk.portConstraints": "FIXED_POS" } });
  });
  drawing.outputs.forEach((terminal, k) => {
    const width = SAO.width(SAO.short(terminal.n)) + 26;
    children.push({
      id: "o" + k, width, height: 26, ports: [portOf(`o${k}.i`, "WEST", 13, width, SAO.short(terminal.t, 24))],
      layoutOptions: { "elk.layered.layering.layerConstraint": "LAST", "elk.portConstraints": "FIXED_POS" },
    });
  });
  const edges = SAO.edges(drawing).map((e, k) => ({ id: "e" + k, sources: [e.from], targets: [e.to] }));
  const large = children.length > 45, huge = children.length > 900;
  return {
    id: "root", children, edges,
    layoutOptions: {
      "elk.algorithm": "layered", "elk.direction": "RIGHT", "elk.edgeRouting": "ORTHOGONAL",
      "elk.portLabels.placement": "OUTSIDE NEXT_TO_PORT_IF_POSSIBLE", "elk.portLabels.nextToPortIfPossible": "true",
      "elk.layered.cycleBreaking.strategy": "MODEL_ORDER",
      "elk.layered.nodePlacement.strategy": huge ? "SIMPLE" : large ? "BRANDES_KOEPF" : "NETWORK_SIMPLEX",
      "elk.layered.nodePlacement.bk.fixedAlignment": "BALANCED",
      "elk.layered.thoroughness": huge ? "1" : large ? "3" : "7",
      "elk.layered.crossingMinimization.greedySwitch.type": huge ? "OFF" : "TWO_SIDED",
      "elk.layered.spacing.nodeNodeBetweenLayers": "34", "elk.layered.spacing.edgeNodeBetweenLayers": "14",
      "elk.layered.spacing.edgeEdgeBetweenLayers": "9", "elk.spacing.nodeNode": "26", "elk.spacing.edgeNode": "14",
      "elk.spacing.edgeEdge": "9", "elk.padding": "[top=24,left=24,bottom=24,right=24]",
      "elk.separateConnectedComponents": "false",
    },
  };
};

// Every connection of a drawing: from a port to a port, with the wire that it carries.
SAO.edges = function (drawing) {
  const found = [];
  const sourcePort = ([block, port]) => (block < 0 ? `i${port}.o` : `b${block}.o${port}`);
  const sourceWire = ([block, port]) => (block < 0 ? drawing.inputs[port].w : drawing.blocks[block].o[port].w);
  drawing.blocks.forEach((block, k) =>
    block.i.forEach((p, n) =>
      p.s.forEach((s) => found.push({ from: sourcePort(s), to: `b${k}.i${n}`, wire: sourceWire(s), source: s, back: !block.ft }))));
  drawing.outputs.forEach((terminal, k) =>
    terminal.s.forEach((s) => found.push({ from: sourcePort(s), to: `o${k}.i`, wire: sourceWire(s), source: s, back: false })));
  return found;
};
