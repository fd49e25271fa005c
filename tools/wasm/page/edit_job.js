// Vertices that move, in the page's worker: the npm package's modules over the library in the command.
const EDITS = {
  async start({ module, file, options, level }) {
    const library = await modules['index.js'].load({ wasm: module });
    const mesh = library.read(file.bytes, file.name);
    const progress = (step, share) => void self.postMessage({ step, share });
    const fit = library.fit(mesh, { ...options, progress });
    const { indices, baseVertices } = fit.evaluate(level);
    this.editor = fit.edit(level, { origin: 'center' });
    return { indices, baseVertices, rows: this.editor.rows(), origin: this.editor.origin, points: this.editor.points };
  },
  move({ vertex, place }) {
    return this.editor.move([vertex], place);
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
    self.postMessage({ ...await EDITS[name](given), errorBound: EDITS.editor?.state.errorBound });
  } catch (error) {
    self.postMessage({ error: error.message });
  }
}
