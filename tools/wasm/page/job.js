// One job of the page, in a worker: runs of the command over files in memory. Ends with the page's stop.
self.onmessage = async ({ data }) => {
  if (data.edit) return edit(data);
  const { module, files, runs } = data;
  const write = (FS) => {
    FS.mkdir('/in');
    FS.mkdir('/out');
    for (const { name, bytes } of files) FS.writeFile(`/in/${name}`, bytes);
    FS.chdir('/in');
  };
  const made = new Map();
  let status = 0, page, memory = false;
  for (const [number, run] of runs.entries()) {
    const say = (line) => self.postMessage({ line, share: [number, runs.length] });
    const command = await planish({
      print: say,
      printErr: say,
      instantiateWasm(imports, done) {
        WebAssembly.instantiate(module, imports).then((instance) => done(instance, module));
        return {};
      },
    });
    write(command.FS);
    try {
      status = command.callMain(run);
    } catch (error) {
      memory = error instanceof RangeError || /memory|OOM/.test(String(error));
      status = error?.name === 'ExitStatus' ? error.status : 1;
      if (error?.name !== 'ExitStatus') say(String(error));
    }
    const collect = (folder) => {
      for (const name of command.FS.readdir(folder)) {
        if (name === '.' || name === '..') continue;
        const path = `${folder}/${name}`;
        if (command.FS.isDir(command.FS.stat(path).mode)) collect(path);
        else made.set(path.slice('/out/'.length), command.FS.readFile(path));
      }
    };
    collect('/out');
    if (command.FS.analyzePath('/page.html').exists) page = command.FS.readFile('/page.html');
    if (status !== 0 && status !== 5) break;
  }
  const written = [...made].map(([name, bytes]) => ({ name, bytes }));
  self.postMessage({ status, files: written, page, memory },
    [...written.map((file) => file.bytes.buffer), ...(page ? [page.buffer] : [])]);
};

// Vertices that move, in the page's worker: the npm package's modules over the library in the command.
const EDITS = {
  async start({ module, file, options, level }) {
    const library = await modules['index.js'].load({ wasm: module });
    const mesh = library.read(file.bytes, file.name);
    const progress = (step, share) => void self.postMessage({ step, share });
    const fit = library.fit(mesh, { ...options, progress });
    const { indices, baseVertices } = fit.evaluate(level);
    this.editor = fit.edit(level, { origin: 'center' });
    Object.assign(this, { diagonal: fit.info.diagonal, moves: [], at: 0 });
    return { indices, baseVertices, rows: this.editor.rows(), origin: this.editor.origin };
  },
  /** A vertex is to be there, what is within `reach` of it (a part of the diagonal) along by its weight. */
  drag({ vertex, place, reach, isFirst }) {
    const { editor } = this;
    if (isFirst) {
      const { vertices, weights } = reach > 0 ? editor.select([vertex], reach * this.diagonal) : { vertices: [vertex], weights: [1] };
      const points = editor.points;
      const from = [...vertices].flatMap((v) => [...points.subarray(3 * v, 3 * v + 3)]);
      this.moves.splice(this.at++, Infinity, { vertices, weights, from, lead: 3 * vertices.indexOf(vertex) });
    }
    const move = this.moves[this.at - 1], { vertices, weights, from, lead } = move;
    move.to = from.map((x, i) => x + weights[Math.floor(i / 3)] * (place[i % 3] - from[lead + i % 3]));
    return editor.move(vertices, move.to);
  },
  undo() {
    const { vertices, from } = this.moves[--this.at];
    return this.editor.move(vertices, from);
  },
  redo() {
    const { vertices, to } = this.moves[this.at++];
    return this.editor.move(vertices, to);
  },
  save({ name, level }) {
    const fit = this.editor.fit();
    try {
      return { bytes: fit.write(name, level) };
    } finally {
      fit.dispose();
    }
  },
};

async function edit({ edit: name, ...given }) {
  try {
    const answer = await EDITS[name](given);
    const { at, moves, editor } = EDITS;
    self.postMessage({ ...answer, errorBound: editor.state.errorBound, canUndo: at > 0, canRedo: at < moves.length });
  } catch (error) {
    self.postMessage({ error: error.message });
  }
}
