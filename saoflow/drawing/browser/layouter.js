// elkjs in a worker: the page is drawn and answers while a sheet is laid out. Where pages may have none, in the page itself.
"use strict";
{
  // The first message is elkjs, all others are graphs.
  const WORK = `self.onmessage = (first) => {
    importScripts(URL.createObjectURL(first.data));
    const elk = new ELK();
    self.onmessage = (e) => elk.layout(e.data.graph).then(
      (layout) => self.postMessage({ id: e.data.id, layout }),
      (error) => self.postMessage({ id: e.data.id, error: String((error && error.message) || error) }));
  }`;

  SAO.Layouter = class {
    // `code`: the text of elkjs, as a blob that is on its way; the worker starts meanwhile.
    constructor(code) {
      this.code = code; this.asked = new Map(); this.count = 0; this.worker = this.elk = null;
      try {
        this.worker = new Worker(URL.createObjectURL(new Blob([WORK], { type: "text/javascript" })));
        this.ready = code.then((blob) => this.worker && this.worker.postMessage(blob));
        this.worker.onmessage = (e) => this.answer(e.data.id, e.data.layout, e.data.error);
        this.worker.onerror = (e) => { e.preventDefault(); if (this.worker) this.withoutWorker(); };
      } catch {
        this.ready = this.withoutWorker();
      }
    }
    // The layout of a graph, as ELK.layout answers it.
    layout(graph) {
      return new Promise((done, failed) => {
        const id = this.count++;
        this.asked.set(id, { graph, done, failed });
        this.ready.then(() => this.ask(id));
      });
    }
    ask(id) {
      const { graph } = this.asked.get(id);
      if (this.elk) this.elk.layout(graph).then((layout) => this.answer(id, layout), (error) => this.answer(id, null, String(error)));
      else if (this.worker) this.worker.postMessage({ id, graph });
    }
    answer(id, layout, error) {
      const asked = this.asked.get(id);
      if (!asked) return;  // a worker that was given up answers, too
      this.asked.delete(id);
      if (error) asked.failed(new Error(error)); else asked.done(layout);
    }
    async withoutWorker() {
      if (this.worker) this.worker.terminate();
      this.worker = null;
      const script = document.createElement("script");
      script.textContent = await (await this.code).text();
      document.head.append(script);
      script.remove();
      this.elk = new ELK();
      for (const id of this.asked.keys()) this.ask(id);
    }
  };
}
