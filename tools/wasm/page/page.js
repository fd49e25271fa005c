'use strict';
(() => {
const $ = (id) => document.getElementById(id);
const MESHES = ['obj', 'ply', 'off', 'stl', 'glb', 'gltf'];
const POINTS = ['xyz', 'pts', 'pcd', 'las', 'ptx'];
const MOST_BYTES = 200e6;
const endingOf = (name) => name.split('.').pop().toLowerCase();
const stemOf = (name) => name.replace(/\.[^.]*$/, '');
// As a shell takes it.
const quoted = (word) => (/^[\w.,:=/+-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

let chosen = []; // {name, bytes}
let worker, links = [];

function unpack(id) {
  return unlzma(Uint8Array.from(atob($(id).textContent), (letter) => letter.charCodeAt(0)));
}

// Compiled once, at the first fit; a job's worker takes it as it is.
let program;
async function compiled() {
  if (program) return program;
  await new Promise((painted) => setTimeout(painted, 50));
  const module = await WebAssembly.compile(unpack('wasm'));
  program = { module, script: URL.createObjectURL(new Blob([unpack('worker')], { type: 'text/javascript' })) };
  return program;
}

function fail(text) {
  $('error').textContent = text;
  $('error').hidden = !text;
}

function mains() {
  return chosen.map((file) => file.name).filter((name) => MESHES.includes(endingOf(name)));
}

async function take(files) {
  files = [...files];
  if (files.length === 0) return;
  fail('');
  chosen = [];
  show();
  const points = files.find((file) => POINTS.includes(endingOf(file.name)));
  if (points) return fail(`${points.name}: points become a mesh by CGAL's surface reconstruction, which is not in this page. ` +
    `On your machine: planish fit ${quoted(points.name)} -o ${quoted(stemOf(points.name))}.glb`);
  if (!files.some((file) => MESHES.includes(endingOf(file.name))))
    return fail(`${files[0].name}: no format that is read here (OBJ, PLY, OFF, STL, glTF, GLB).`);
  const size = files.reduce((sum, file) => sum + file.size, 0);
  if (size > MOST_BYTES)
    return fail(`${Math.round(size / 1e6)} MB are more than this page takes (${MOST_BYTES / 1e6} MB). ` +
      `On your machine: planish fit ${quoted(files[0].name)} -o ${quoted(stemOf(files[0].name))}.glb`);
  chosen = await Promise.all(files.map(async (file) => ({ name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) })));
  show();
}

function show() {
  $('chosen').textContent = chosen.map((file) => file.name).join(', ');
  ready();
}

// What is chosen from is that of one mesh.
function ready() {
  $('fit').disabled = chosen.length === 0;
  $('try').disabled = mains().length !== 1;
}

// The run of the command that shows what a fit chooses from, as far as the form leaves it open.
function trials() {
  const named = [['interpolation', 'method', 'auto'], ['creases', 'creases', 'choose']];
  const flags = named.flatMap(([flag, id, open]) => ($(id).value === open ? [] : [`--${flag}`, $(id).value]));
  if ($('within').value.trim()) flags.push('--within', $('within').value.trim());
  flags.push(...($('flags').value.match(/\S+/g) ?? []));
  return [['try', ...mains(), ...flags, '--page', '/page.html', '--progress', 'json']];
}

// The runs of the command that make what the form asks for.
function runs() {
  const inputs = mains();
  const flags = ['--interpolation', $('method').value, '--creases', $('creases').value];
  if ($('chord').value.trim()) flags.push('--chord-error', $('chord').value.trim());
  else flags.push('--levels', $('levels').value);
  if ($('within').value.trim()) flags.push('--within', $('within').value.trim());
  flags.push(...($('flags').value.match(/\S+/g) ?? []));
  const format = $('format').value;
  const outputs = inputs.length === 1 ? ['-o', `/out/${stemOf(inputs[0])}.${format}`] : ['-o', '/out/', '--output-format', format];
  if ($('cage').checked) outputs.push('--cage', inputs.length === 1 ? `/out/${stemOf(inputs[0])}_cage.obj` : '/out/cages/');
  outputs.push('--report', '/out/report.json');
  const page = ['--page', '/page.html'];
  const say = ['--progress', 'json'];
  // A page shows one mesh, and the file keeps all of them with materials and nodes.
  if (inputs.some((name) => ['glb', 'gltf'].includes(endingOf(name))) && ['glb', 'gltf'].includes(format))
    return [['fit', ...inputs, ...flags, ...outputs, ...say], ['fit', ...inputs, ...flags, ...page, ...say]];
  return [['fit', ...inputs, ...flags, ...outputs, ...page, ...say]];
}

function busy(is) {
  for (const id of ['stop', 'progress']) $(id).hidden = !is;
  if (is) $('fit').disabled = $('try').disabled = true;
  else ready();
  if (!is) $('step').textContent = '';
}

function stop() {
  worker?.terminate();
  worker = undefined;
  busy(false);
  leave();
}

// Runs of the command one after another; the page of the last is shown, and saved under this name.
async function work(runs, pageName) {
  if (worker || chosen.length === 0) return;
  leave();
  fail('');
  busy(true);
  $('progress').value = 0;
  $('step').textContent = 'starting';
  let started;
  try {
    started = await compiled();
  } catch (error) {
    busy(false);
    return fail(`This browser cannot run it: ${error.message}. Chrome 95, Firefox 113, Safari 16.4 and later can.`);
  }
  const said = [];
  worker = new Worker(started.script);
  worker.onerror = (event) => {
    stop();
    fail(event.message || 'the worker failed');
  };
  worker.onmessage = ({ data }) => {
    if (data.line !== undefined) return hear(data.line, said, data.share);
    stop();
    finish(data, said, pageName);
  };
  worker.postMessage({ module: started.module, files: chosen, runs });
}

const fit = () => chosen.length > 0 && work(runs(), `${stemOf(mains()[0])}.html`);
const tryAll = () => work(trials(), `${stemOf(mains()[0])}_tried.html`);

function hear(line, said, [run, count]) {
  let message;
  try {
    message = JSON.parse(line);
  } catch {
    said.push(line);
    return;
  }
  if (message.step !== undefined) {
    $('progress').value = (run + (message.share ?? 0)) / count;
    $('step').textContent = `${message.job}: ${message.step}`;
  } else {
    // Once, though two runs may say it.
    const text = message.text ?? message.message ?? line;
    if (run === 0 || message.level === 'error') said.push(text);
  }
}

function finish({ status, files, page, memory }, said, pageName) {
  for (const link of links) URL.revokeObjectURL(link);
  links = [];
  const names = mains();
  // 5: not converged, and written all the same.
  if (status !== 0 && files.length === 0 && !(status === 5 && page)) {
    $('result').hidden = true;
    const words = said.join('\n') || `it ended with status ${status}`;
    const larger = memory || status === 6 ? `\nWebAssembly has at most 4 GiB; on your machine: planish fit ${quoted(names[0])} -o ${quoted(stemOf(names[0]))}.glb` : '';
    return fail(words + larger);
  }
  $('downloads').replaceChildren(...[...files, ...(page ? [{ name: pageName, bytes: page }] : [])].map(link));
  $('said').textContent = said.join('\n');
  $('report').hidden = !page;
  if (page) {
    const url = URL.createObjectURL(new Blob([page], { type: 'text/html' }));
    links.push(url);
    $('report').src = url;
  }
  $('result').hidden = false;
  $('edit').hidden = names.length !== 1;
}

// Vertices that move: a worker keeps the fit, and is told one move after the other.
let editing, view;

function ask(message) {
  return new Promise((resolve, reject) => {
    editing.waiting.push({ resolve, reject });
    editing.worker.postMessage(message);
  });
}

async function edit() {
  if (worker || editing) return;
  fail('');
  busy(true);
  const level = Math.min(Number($('levels').value), 3);
  const within = $('within').value.trim();
  try {
    const { module, script } = await compiled();
    editing = { worker: new Worker(script), waiting: [], next: [], level };
    const { waiting } = editing;
    editing.worker.onmessage = ({ data }) => {
      if (data.step !== undefined) {
        $('progress').value = data.share;
        $('step').textContent = data.step;
      } else if (data.error) {
        waiting.shift().reject(new Error(data.error));
      } else {
        waiting.shift().resolve(data);
      }
    };
    const file = chosen.find(({ name }) => name === mains()[0]);
    const options = { interpolation: $('method').value, creases: $('creases').value };
    if (within) options.within = within === 'auto' ? within : Number(within);
    const start = await ask({ edit: 'start', module, file, options, level });
    $('result').hidden = true;
    $('editing').hidden = false;
    view ??= new EditView($('canvas'), drag);
    view.show(start);
    told(start);
  } catch (error) {
    leave();
    fail(error.message);
  }
  busy(false);
}

function told({ errorBound, canUndo, canRedo }) {
  $('undo').disabled = !canUndo;
  $('redo').disabled = !canRedo;
  $('moved').textContent = `The surface is off its vertices by at most ${errorBound.toExponential(0)} of the diagonal.`;
}

function drag(vertex, place, isFirst) {
  const message = { edit: 'drag', vertex, place, isFirst, reach: Number($('reach').value) };
  // What came while a move was made: the last place counts.
  const last = editing.next.at(-1);
  if (last?.edit === 'drag' && !isFirst) last.place = place;
  else editing.next.push(message);
  move();
}

async function move() {
  if (editing.isMoving) return;
  editing.isMoving = true;
  const job = editing;
  try {
    while (job.next.length > 0) {
      const change = await ask(job.next.shift());
      if (editing !== job) return;
      view.follow(change);
      told(change);
    }
  } catch (error) {
    fail(error.message);
  }
  job.isMoving = false;
}

// After all that is asked for already, which may be none.
function again(name) {
  return () => {
    if (!editing || $(name).disabled || editing.next.length > 0) return;
    editing.next.push({ edit: name });
    move();
  };
}
const takeBack = again('undo'), makeAgain = again('redo');

async function saveMoved() {
  const name = `${stemOf(mains()[0])}.${$('format').value}`;
  try {
    const { bytes } = await ask({ edit: 'save', name, level: Number($('levels').value) });
    const save = link({ name, bytes });
    save.click();
  } catch (error) {
    fail(error.message);
  }
}

function leave() {
  if (!editing) return;
  editing.worker.terminate();
  editing = undefined;
  $('editing').hidden = true;
  $('result').hidden = links.length === 0;
}

function sizeOf(bytes) {
  return bytes < 1e6 ? `${Math.ceil(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

function link({ name, bytes }) {
  const url = URL.createObjectURL(new Blob([bytes]));
  links.push(url);
  return Object.assign(document.createElement('a'),
    { href: url, download: name, textContent: `Save ${name} (${sizeOf(bytes.length)})` });
}

$('files').addEventListener('change', (event) => take(event.target.files));
$('form').addEventListener('submit', (event) => {
  event.preventDefault();
  fit();
});
$('stop').addEventListener('click', () => {
  stop();
  fail('Stopped; nothing was written.');
});
for (const [id, deed] of Object.entries({ try: tryAll, edit, leave, undo: takeBack, redo: makeAgain, saveMoved })) $(id).addEventListener('click', deed);
$('reach').addEventListener('input', (event) => {
  const part = Number(event.target.value);
  $('reached').textContent = part > 0 ? `${Math.round(100 * part)} % of the diagonal` : 'one vertex';
});
addEventListener('keydown', (event) => {
  if (!editing || event.key.toLowerCase() !== 'z' || !(event.ctrlKey || event.metaKey)) return;
  event.preventDefault();
  if (event.shiftKey) makeAgain();
  else takeBack();
});
$('example').addEventListener('click', () => {
  chosen = [{ name: 'goblet.obj', bytes: unpack('goblet') }];
  show();
  fit();
});
for (const kind of ['dragenter', 'dragover']) addEventListener(kind, (event) => {
  event.preventDefault();
  document.body.classList.add('over');
});
addEventListener('dragleave', () => document.body.classList.remove('over'));
addEventListener('drop', (event) => {
  event.preventDefault();
  document.body.classList.remove('over');
  take(event.dataTransfer.files).then(() => chosen.length && !worker && fit());
});
addEventListener('paste', (event) => take(event.clipboardData.files));
})();
