// The page: jobs, links to what is seen of them, and the start.

function placeDivider() {
  $('divider').style.left = `${100 * state.split}%`;
  $('divider').setAttribute('aria-valuenow', Math.round(100 * state.split));
}

/** Shows a job's words, and its scene where it has one; `beside`: another scene's place. */
async function show(job, beside = null) {
  state.job = job;
  for (const row of document.querySelectorAll('tr[data-job]')) {
    if (Number(row.dataset.job) === job) row.setAttribute('aria-current', 'true');
    else row.removeAttribute('aria-current');
  }
  document.querySelectorAll('section.job').forEach((s, k) => { s.hidden = k !== job; });
  const index = heads.findIndex((head) => head.job === job);
  $('view').hidden = index < 0;
  if (index < 0) return;
  const [scene, other] = await Promise.all([load(index), beside === null ? null : load(beside)]);
  const fresh = !state.scene || state.scene.head.name !== scene.head.name;
  Object.assign(state, { scene, other, nextFold: 0 });
  clearPicked();
  $('level').max = Math.max(scene.levels.length, other?.levels.length ?? 0) - 1;
  for (const id of ['divider', 'left', 'right']) $(id).hidden = !other;
  // A board needs texture coordinates.
  const board = $('mode').options[MODES.length - 1];
  board.disabled = !scene.uvs && !other?.uvs;
  if (board.disabled && board.selected) $('mode').value = 'smooth';
  $('left').textContent = scene.head.label;
  $('right').textContent = other?.head.label ?? '';
  $('other').value = beside ?? '';
  placeDivider();
  if (fresh && !sameBox(scene)) Object.assign(camera, wholeView(scene, aspect()));
  refresh();
}

// Jobs of one model keep the view: what is compared is seen from the same place.
let lastBox = null;
function sameBox({ centre, radius }) {
  const same = lastBox && Math.abs(lastBox.radius - radius) < 0.05 * radius &&
      Math.hypot(...minus(lastBox.centre, centre)) < 0.05 * radius;
  lastBox = { centre, radius };
  return same;
}

/** The address says what is seen, so that a link shows the same. */
function writeLink() {
  const link = new URLSearchParams({ job: state.job });
  if (state.other) link.set('other', heads.indexOf(state.other.head));
  for (const id of ['mode', 'level', 'stripes', 'top']) link.set(id, $(id).value);
  for (const id of [...Object.values(CHECKS), 'facets']) if ($(id).checked) link.set(id, '1');
  const digits = (x) => Number(x.toPrecision(5));
  for (const key of ['yaw', 'pitch']) link.set(key, digits(camera[key]));
  link.set('distance', digits(camera.distance / state.scene.radius));
  link.set('target', minus(camera.target, state.scene.centre)
      .map((x) => digits(x / state.scene.radius)).join(','));
  try {
    history.replaceState(null, '', `#${link}`);
  } catch { /* some browsers refuse it for files; the page works without */ }
}

function readControls(link) {
  for (const id of ['mode', 'level', 'stripes', 'top']) {
    if (link.has(id)) $(id).value = link.get(id);
  }
  if (!$('mode').value) $('mode').value = 'smooth';
  for (const id of [...Object.values(CHECKS), 'facets']) {
    if (link.has(id)) $(id).checked = link.get(id) !== '0';
  }
}

function readCamera(link) {
  const { radius, centre } = state.scene;
  const number = (key) => link.has(key) && Number.isFinite(Number(link.get(key)));
  for (const key of ['yaw', 'pitch']) if (number(key)) camera[key] = Number(link.get(key));
  if (number('distance')) camera.distance = Math.max(1e-3, Number(link.get('distance'))) * radius;
  const target = (link.get('target') ?? '').split(',').map(Number);
  if (target.length === 3 && target.every(Number.isFinite)) {
    camera.target = centre.map((x, k) => x + radius * target[k]);
  }
}

/** Follows the address: a link's, or one that was typed. */
async function followLink() {
  const hash = location.hash.slice(1), link = new URLSearchParams(hash);
  const section = hash.match(/^job(\d+)$/);
  readControls(link);
  const count = document.querySelectorAll('section.job').length;
  const wish = Number(section ? section[1] : link.get('job')) || 0;
  const other = link.has('other') ? Number(link.get('other')) : NaN;
  await show(Math.max(0, Math.min(count - 1, wish)), heads[other] ? other : null);
  if (!state.scene) return;
  readCamera(link);
  if (link.get('at') === 'worst') goWorst();
  if (link.get('at') === 'fold') goFold();
  render();
}

async function start() {
  $('mode').append(...MODES.map(([value, text]) => new Option(text, value)));
  $('other').append(new Option('nothing', ''), ...heads.map((head, i) => new Option(head.label, i)));
  $('otherLabel').hidden = heads.length < 2;
  if (heads.length === 0) {
    $('plain').textContent = 'The 3-D view is left out of this page; all figures stand below.';
    await show(0);
  } else {
    if (!('DecompressionStream' in window)) throw new Error('this browser is too old to unpack it');
    state.renderer = new GlView(canvas, redraw);
    $('plain').hidden = true;
    $('view').hidden = false;
    listen();
    await followLink();
  }
  document.documentElement.dataset.ready = state.renderer?.constructor.name ?? 'none';
}

start().catch((error) => {
  $('view').hidden = true;
  $('plain').hidden = false;
  $('plain').textContent = `The 3-D view could not start: ${error.message}. ` +
      'Still pictures and all figures stand below.';
  document.querySelectorAll('section.job').forEach((section) => { section.hidden = false; });
  document.documentElement.dataset.ready = 'failed';
});
