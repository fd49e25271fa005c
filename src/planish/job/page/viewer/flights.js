// Where the eye goes, and what lies under the pointer.

function fly(to) {
  if (reducedMotion.matches) {
    Object.assign(camera, to);
    redraw();
    writeLink();
    return;
  }
  const from = { ...camera, target: [...camera.target] }, start = performance.now();
  const step = (now) => {
    const time = Math.min(1, (now - start) / 450), eased = time * time * (3 - 2 * time);
    const mix = (a, b) => a + (b - a) * eased;
    camera.yaw = mix(from.yaw, to.yaw);
    camera.pitch = mix(from.pitch, to.pitch);
    camera.distance = from.distance * (to.distance / from.distance) ** eased;
    camera.target = from.target.map((x, k) => mix(x, to.target[k]));
    render();
    if (time < 1) requestAnimationFrame(step);
    else writeLink();
  };
  requestAnimationFrame(step);
}

const aspect = () => stage.clientWidth / Math.max(1, stage.clientHeight);
const goHome = () => fly(wholeView(state.scene, aspect()));

function goWorst() {
  const { scene } = state, vertex = scene.head.worst;
  if (vertex < 0) return;
  describeVertex(vertex, 'Worst vertex');
  fly({ ...facing(normalOf(scene, vertex), scene.head.up), distance: scene.radius * 0.45,
    target: pointOf(scene, vertex) });
}

function goFold() {
  const { scene } = state, { folds, diagonal, up } = scene.head;
  if (!folds.length) return;
  const number = state.nextFold++ % folds.length, fold = folds[number];
  const place = fold.position.map((x) => Number(x.toPrecision(4))).join(', ');
  $('picked').textContent = `Fold ${number + 1} of ${folds.length} at ${place}\n` +
      `${figure(100 * fold.area)} % of the area, over face ${fold.face} (counted from 0)`;
  state.marked = fold.position;
  const distance = Math.min(scene.radius, Math.max(5 * fold.size, diagonal / 200));
  fly({ ...facing(fold.direction, up), distance, target: fold.position });
  showFoldButton();
}

const turn = (dx, dy) => {
  camera.yaw -= dx;
  camera.pitch = Math.max(-1.55, Math.min(1.55, camera.pitch + dy));
  redrawMoving();
};
const move = (dx, dy) => {
  const rows = rotation(camera, state.scene.head.up);
  const scale = camera.distance * Math.tan(FIELD_OF_VIEW / 2) * 2 / stage.clientHeight;
  camera.target = camera.target.map((x, k) => x - scale * (dx * rows[0][k] - dy * rows[1][k]));
  redrawMoving();
};
const zoom = (factor) => {
  const { radius } = state.scene;
  camera.distance = Math.max(radius * 1e-3, Math.min(radius * 20, camera.distance * factor));
  redrawMoving();
};

/** The given vertex nearest to a place of the picture that the surface does not hide. */
function pick(x, y) {
  const { scene } = state, width = stage.clientWidth, height = stage.clientHeight;
  const frame = projection(scene, width / height);
  const within = [];
  for (let i = 0; i < scene.head.base; i++) {
    const [px, py, depth] = frame.place(pointOf(scene, i), width, height);
    const off = Math.hypot(px - x, py - y);
    if (depth > 0 && off < 14) within.push({ i, off, px, py, depth });
  }
  within.sort((a, b) => a.off - b.off);
  const slack = scene.radius * 5e-3;
  const seen = within.slice(0, 8).find(({ px, py, depth }) =>
    depth <= depthUnder(scene, frame, px, py, width, height) + slack);
  if (seen) describeVertex(seen.i, 'Vertex');
  else clearPicked();
  placeMark();
}
