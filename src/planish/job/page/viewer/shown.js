// What is shown: the controls' state, and pictures of it.

const $ = (id) => document.getElementById(id);
const MODES = [['smooth', 'Smooth surface'], ['zebra', 'Reflection lines (zebra)'],
  ['isophotes', 'Isophotes'], ['error', 'Interpolation error'], ['deviation', 'Normal deviation'],
  ['fold', 'Folds'], ['mean', 'Mean curvature'], ['gauss', 'Gaussian curvature'],
  ['checker', 'Texture checker board']];
const CHECKS = { m: 'mesh', l: 'lines', c: 'cage', p: 'points' };
const ERROR_NOISE = 1e-12;  // of the diagonal: what rounding leaves

const reducedMotion = matchMedia('(prefers-reduced-motion: reduce)');
const canvas = $('canvas'), stage = $('stage');
const heads = [...document.querySelectorAll('script.head')].map((s) => JSON.parse(s.textContent));
const payloads = [...document.querySelectorAll('script.payload')];
const loading = new Map();
const state = { scene: null, other: null, split: 0.5, nextFold: 0, marked: null, frames: 0, renderer: null };

/** The scene of a job by its place among those that have one; read once. */
function load(index) {
  if (!loading.has(index)) loading.set(index, readScene(heads[index], payloads[index].textContent));
  return loading.get(index);
}

/** A colour of the style as three parts of 0 to 1. */
function styleColour(name) {
  const hex = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);
}

/** The top of a map's scale, one for both of two compared surfaces. */
function topOf(name) {
  const choice = $('top').value;
  if (name === 'error' && choice === 'tolerance') return state.scene.head.tolerance;
  const tops = [state.scene, state.other].filter(Boolean).map((scene) => {
    const field = fieldOf(scene, name);
    if (field.kind !== 'amount') return field.limit;
    return choice === 'largest' ? field.largest : field.most;
  });
  // Colours for what rounding leaves would show nothing but it.
  return Math.max(...tops, name === 'error' ? ERROR_NOISE : 1e-30);
}

/** All that the controls say, for one picture. */
function currentView() {
  const mode = $('mode').value;
  const checked = (id) => $(id).checked;
  const level = Math.min(Number($('level').value), motion.moving ? motion.coarsest : Infinity);
  return {
    mode, level, ratio: pixelRatio(), top: topOf, stripes: Number($('stripes').value),
    map: fieldOf(state.scene, mode) ? mode : null,
    mesh: checked('mesh'), lines: checked('lines'), cage: checked('cage'), points: checked('points'),
    facets: checked('facets'), wireInk: styleColour('--wire'), cageInk: styleColour('--cage'),
  };
}

const pixelRatio = () => Math.min(devicePixelRatio, 2);

// While the picture moves, a coarser level is drawn where a frame takes over a tenth of a second.
const motion = { moving: false, coarsest: Infinity, last: 0, rest: 0 };

function redrawMoving() {
  motion.moving = true;
  clearTimeout(motion.rest);
  motion.rest = setTimeout(() => {
    Object.assign(motion, { moving: false, last: 0 });
    redraw();
    writeLink();
  }, 250);
  redraw();
}

function watchSpeed() {
  const now = performance.now(), took = now - motion.last;
  if (motion.last && took > 100 && took < 5000) {
    motion.coarsest = Math.max(0, Math.min(motion.coarsest, Number($('level').value)) - 1);
  } else if (motion.last && took < 25) {
    motion.coarsest++;
  }
  motion.last = now;
}

let queued = false;
function redraw() {
  if (queued) return;
  queued = true;
  requestAnimationFrame(render);
}

function render() {
  queued = false;
  if (!state.scene || $('view').hidden) return;
  const width = Math.round(stage.clientWidth * pixelRatio());
  const height = Math.round(stage.clientHeight * pixelRatio());
  if (!width || !height) return;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  if (motion.moving) watchSpeed();
  const view = currentView(), { renderer, scene, other, split } = state;
  const deepest = (s) => ({ ...view, level: Math.min(view.level, s.levels.length - 1) });
  renderer.begin();
  renderer.draw(scene, deepest(scene), 0, other ? split : 1);
  if (other) renderer.draw(other, deepest(other), split, 1);
  placeMark();
  document.documentElement.dataset.frames = ++state.frames;
}
