// The library behind planish/c/planish.h for JavaScript: meshes in, surfaces through all of their vertices out.
import makeModule from './planish_library.mjs';
import { FitOptions, fitted, infoOf } from './fit.js';
import { Memory, PlanishError, check, refuse } from './memory.js';
import { Mesh } from './mesh.js';

export { PlanishError };

/** Compiles the library. `wasm`: its bytes or module, where they do not lie beside this file. */
export async function load({ wasm } = {}) {
  const given = {};
  if (wasm instanceof WebAssembly.Module) {
    given.instantiateWasm = (imports, done) => {
      WebAssembly.instantiate(wasm, imports).then((instance) => done(instance, wasm));
      return {};
    };
  } else if (wasm) {
    given.wasmBinary = wasm;
  }
  return new Planish(await makeModule(given));
}

// Files in the library's memory are called as the caller's: formats tell it, and some files hold the name.
const pathIn = (folder, name) => `${folder}/${String(name).replace(/.*[\\/]/, '') || 'unnamed'}`;

// What is there besides the file that was asked for, too: materials of an OBJ, say.
function removeAll({ FS }, folder) {
  for (const name of FS.readdir(folder)) if (name !== '.' && name !== '..') FS.unlink(`${folder}/${name}`);
}

class Planish {
  #module;
  constructor(module) {
    this.#module = module;
    for (const folder of ['/in', '/out', '/pages']) module.FS.mkdir(folder);
  }

  get version() {
    return this.#module.UTF8ToString(this.#module._planish_version());
  }

  /** Polygons as arrays, kept in the library: fit() takes them again and again. */
  mesh(arrays) {
    return new Mesh(this.#module, arrays);
  }

  /** A file's mesh; `name` tells its format by its ending. */
  read(bytes, name) {
    const module = this.#module;
    const path = pathIn('/in', name);
    module.FS.writeFile(path, bytes);
    try {
      return new Memory(module).use((memory) => {
        const handle = memory.out();
        check(module, module._planish_mesh_read(memory.text(path), handle), path, name);
        return new Mesh(module, memory.pointer(handle));
      });
    } finally {
      module.FS.unlink(path);
    }
  }

  /** Fits the surface; an arrays' mesh is taken for this fit only. */
  fit(mesh, options = {}) {
    if (mesh instanceof Mesh) return fitted(this.#module, mesh, options);
    const made = this.mesh(mesh);
    try {
      return fitted(this.#module, made, options);
    } finally {
      made.dispose();
    }
  }

  /** A file's bytes become another's, as `planish fit` makes them: of a glTF all that is no triangle comes along.
   * `output` tells the format by its ending; of `lods` "msft" several `levels` are levels of detail in one glTF.
   * With `report` the result has what was done, with `page` HTML to look at. */
  fitFile(bytes, name, { output = 'surface.glb', report = false, page = false, ...options } = {}) {
    const module = this.#module;
    const [several] = /\.(gltf|json)$/i.exec(output) ?? [];
    if (several) refuse(`output: a ${several} has files beside it; take .glb`);
    const from = pathIn('/in', name), to = pathIn('/out', output), warnings = [];
    const wanted = { ...(report && { report: '/out/report.json' }), ...(page && { page: '/out/page.html' }) };
    const text = (path) => module.FS.readFile(path, { encoding: 'utf8' });
    module.FS.writeFile(from, bytes);
    try {
      const info = new Memory(module).use((memory) => {
        const told = new FitOptions(memory, { ...options, ...wanted }, warnings);
        const at = memory.struct('fit_info', {});
        const status = module._planish_fit_file(memory.text(from), memory.text(to), told.pointer, at);
        told.end();
        check(module, status, from, name);
        return infoOf(module, memory.read('fit_info', at));
      });
      return {
        bytes: module.FS.readFile(to), info, warnings,
        ...(report && { report: JSON.parse(text(wanted.report)) }), ...(page && { page: text(wanted.page) }),
      };
    } finally {
      module.FS.unlink(from);
      removeAll(module, '/out');
    }
  }

  /** Many files, each {bytes, name}, as fitFile() makes them, one after another. One that cannot be fitted has an
   * `error` and stops nobody. With `page` each has a page, NAME.html, and `sheet` is a contact sheet that shows all, the
   * worst first, and links to these. */
  fitFiles(files, { extension = 'glb', page = false, ...options } = {}) {
    const module = this.#module;
    if (/^(gltf|json)$/i.test(extension)) refuse(`extension: a .${extension} has files beside it; take glb`);
    const given = files.map(({ name }) => pathIn('/in', name)), warnings = [], errors = new Map();
    const named = (message) => given.reduce((text, path, i) => text.replaceAll(path, files[i].name), message);
    const text = (path) => module.FS.readFile(path, { encoding: 'utf8' });
    try {
      files.forEach(({ bytes }, i) => module.FS.writeFile(given[i], bytes));
      new Memory(module).use((memory) => {
        const told = new FitOptions(memory, { ...options, ...(page && { page: '/pages' }) }, warnings);
        const failed = memory.callback('viii', (user, input, message) =>
          errors.set(input, named(module.UTF8ToString(message))));
        const status = module._planish_fit_files(memory.texts(given), given.length, memory.text('/out'),
          memory.text(extension), told.pointer, failed, 0);
        told.end();
        try {
          check(module, status);
        } catch (error) {
          throw new PlanishError(named(error.message), error.code, error.element);
        }
      });
      const stem = (i) => given[i].replace(/^\/in\//, '').replace(/\.[^.]*$/, '');
      return {
        files: files.map(({ name }, i) => errors.has(i) ? { name, error: errors.get(i) } : {
          name, bytes: module.FS.readFile(`/out/${stem(i)}.${extension}`), ...(page && { page: text(`/pages/${stem(i)}.html`) }),
        }),
        warnings, ...(page && { sheet: text('/pages/index.html') }),
      };
    } finally {
      for (const folder of ['/in', '/out', '/pages']) removeAll(module, folder);
    }
  }
}
