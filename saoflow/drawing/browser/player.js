// A flight played in the page: the sheet's own frame program, every wire of every instance kept.
"use strict";
{
  const above = (x, u) => { let a = 0, b = x.length; while (a < b) { const m = (a + b) >> 1; if (u < x[m]) b = m; else a = m + 1; } return a; };
  const place = (x, u) => (!(u > x[0]) ? [0, x[0]] : !(u < x[x.length - 1]) ? [x.length - 1, x[x.length - 1]] : [above(x, u) - 1, u]);
  // The look-ups: the same operations in the same order as the interpreter's.
  globalThis.look1 = function (t, given) {
    const x = t.x[0], [i, u] = place(x, given);
    return t.linear ? t.z[i] + (u - x[i]) * t.d[i] : t.z[i];
  };
  globalThis.look2 = function (t, givenU, givenV) {
    const [i, u] = place(t.x[0], givenU), [j, v] = place(t.x[1], givenV);
    if (!t.linear) return t.z[i][j];
    const p = (u - t.x[0][i]) * t.r[0][i], q = (v - t.x[1][j]) * t.r[1][j];
    const k = Math.min(i + 1, t.z.length - 1);
    const a = t.z[i][j] + q * t.d[i][j], b = t.z[k][j] + q * t.d[k][j];
    return a + p * (b - a);
  };

  const EVERY = 64;

  // `run`: {frames, width, inputs: Float64Array row by row, initial, size, bodies, period}
  SAO.Player = class {
    constructor(run, frame) {
      this.run = run; this.frameOf = frame; this.trace = new Float64Array(run.size);
      this.state = Float64Array.from(run.initial); this.next = new Float64Array(run.initial.length);
      this.kept = []; this.at = -1;  // frames are computed when one looks at them: a page opens without waiting for its run
    }
    step(k) {
      const w = this.run.width;
      if (k === EVERY * this.kept.length) this.kept.push(this.state.slice());
      this.frameOf(this.run.inputs.subarray(k * w, (k + 1) * w), this.state, this.next, this.trace);
      [this.state, this.next] = [this.next, this.state];
      this.at = k;
    }
    seek(k) {
      if (k === this.at) return;
      const start = Math.min(Math.floor(k / EVERY), this.kept.length - 1);
      if (k < this.at || start * EVERY > this.at + 1) {
        this.state = this.kept[start].slice(); this.at = start * EVERY - 1;
      }
      while (this.at < k) this.step(this.at + 1);
    }
    // Where an instance's wires are: the body it was lowered into, the path inside it, the base of its values.
    root() { return { body: this.run.bodies.length - 1, prefix: "", base: 0 }; }
    enter(where, call) {
      if (!call) return where;
      const key = where.prefix + call, found = this.run.bodies[where.body].calls[key];
      return found ? { body: found[0], prefix: "", base: where.base + found[1] } : { ...where, prefix: key + "." };
    }
    places(where, wire, size) {
      const scope = this.run.bodies[where.body].scopes[where.prefix], found = scope && scope[wire];
      if (found === null || found === undefined) return null;
      if (typeof found === "number") return Array.from({ length: size }, (_, k) => ({ at: where.base + found + k }));
      return found.map((a) => (Array.isArray(a) ? { is: Number(a[0]) } : { at: where.base + a }));
    }
    values(places) { return places.map((p) => ("at" in p ? this.trace[p.at] : p.is)); }
    // Every element over the whole run, one Float64Array each.
    series(places) {
      const back = this.at, rows = places.map(() => new Float64Array(this.run.frames));
      this.seek(0);
      for (let k = 0; k < this.run.frames; k++) {
        this.seek(k);
        places.forEach((p, e) => (rows[e][k] = "at" in p ? this.trace[p.at] : p.is));
      }
      this.seek(back);
      return rows;
    }
  };
}
