// Words around the picture: scale, level, what was picked.

function svgElement(name, attributes, text = '') {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.textContent = text;
  return element;
}

/** Values that stand below the colours, with their places from 0 to 1. */
function ticksOf(field, top) {
  return [[field.kind === 'signed' ? -top : 0, 0], [field.kind === 'signed' ? 0 : top / 2, 0.5], [top, 1]];
}

function showScale(name) {
  $('scale').toggleAttribute('hidden', !name);
  if (!name) return;
  const field = fieldOf(state.scene, name), top = topOf(name);
  $('scaleName').textContent = `${field.label}, ${field.unit}`;
  const ticks = ticksOf(field, top);
  $('scaleTitle').textContent =
      `${field.label}: from ${figure(ticks[0][0])} to ${figure(top)} ${field.unit}`;
  $('ticks').replaceChildren(...ticks.map(([value, place], i) => {
    const anchor = i === 0 ? 'start' : place === 1 ? 'end' : 'middle';
    const beyond = place === 1 && field.largest > top * 1.001 ? '\u2265 ' : '';
    return svgElement('text', { x: 10 + 250 * place, y: 43, 'text-anchor': anchor },
        beyond + figure(value));
  }));
  $('ramp').replaceChildren(...MAPS[field.kind].map((color, i) => svgElement('stop', {
    offset: i / (STOPS - 1), 'stop-color': `rgb(${color.map((part) => Math.round(255 * part))})` })));
}

function showFoldButton() {
  const { folds, folded_faces: faces } = state.scene.head;
  $('fold').disabled = folds.length === 0;
  const next = state.nextFold % Math.max(folds.length, 1) + 1;
  $('fold').textContent = folds.length ? `Next fold (${next} of ${folds.length})` : 'No folds';
  $('fold').title = folds.length ? `${faces} quads are folded; these are the largest places` : '';
}

function refresh() {
  const view = currentView(), { scene, other } = state;
  const level = Math.min(Number($('level').value), scene.levels.length - 1);
  const triangles = scene.levels[level].indices.length / 3;
  $('levelText').textContent = `${level}: ${triangles.toLocaleString('en-US')} triangles`;
  $('stripesLabel').hidden = !['zebra', 'isophotes', 'checker'].includes(view.mode);
  $('top').options[2].disabled = Boolean(view.map) && view.map !== 'error';
  $('topLabel').hidden = !(view.points || (view.map && fieldOf(scene, view.map).kind === 'amount'));
  showScale(view.map ?? (view.points ? 'error' : null));
  showFoldButton();
  const mode = MODES.find(([name]) => name === view.mode)[1];
  canvas.setAttribute('aria-label', `3-D view of ${scene.head.label}: ${mode}, level ${level}` +
      (other ? `, beside ${other.head.label}` : ''));
  redraw();
}

/** The figures of a vertex of level 0, in words. */
function describeVertex(vertex, name) {
  const { scene } = state, lines = [];
  for (const { name: key, label, unit } of scene.head.fields) {
    const value = valueOf(scene, key, vertex);
    const noise = key === 'error' && value > 0 && value < ERROR_NOISE;
    lines.push(`${label}: ${noise ? `below ${figure(ERROR_NOISE)}` : figure(value)} ${unit}`);
  }
  state.marked = pointOf(scene, vertex);
  const place = pointOf(scene, vertex).map((x) => Number(x.toPrecision(4))).join(', ');
  const number = scene.names[vertex];
  const which = number < 0 ? 'a vertex that was added' : `${name} ${number} (counted from 0)`;
  $('picked').textContent = [`${which} at ${place}`, ...lines].join('\n');
}

function clearPicked() {
  $('picked').textContent = '';
  state.marked = null;
}

/** A ring around what those words are of. */
function placeMark() {
  const mark = $('mark'), { scene, marked } = state;
  mark.hidden = !marked;
  if (!marked) return;
  const width = stage.clientWidth, height = stage.clientHeight;
  const [x, y, depth] = projection(scene, width / height).place(marked, width, height);
  mark.hidden = depth <= 0;
  Object.assign(mark.style, { left: `${x}px`, top: `${y}px` });
}
