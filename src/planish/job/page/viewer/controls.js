// Hands and keys.

function listenToPointers() {
  const down = new Map();
  let moved = 0;
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, event);
    if (down.size === 1) moved = 0;
  });
  canvas.addEventListener('pointermove', (event) => {
    const last = down.get(event.pointerId);
    if (!last) return;
    const dx = event.clientX - last.clientX, dy = event.clientY - last.clientY;
    moved += Math.abs(dx) + Math.abs(dy);
    if (down.size === 2) {  // pinch: zooms by the fingers' distance and moves with their middle
      const still = [...down.values()].find((e) => e.pointerId !== event.pointerId);
      const apart = (e) => Math.hypot(e.clientX - still.clientX, e.clientY - still.clientY);
      zoom(apart(last) / Math.max(1, apart(event)));
      move(dx / 2, dy / 2);
    } else if (event.shiftKey || last.buttons === 2) {
      move(dx, dy);
    } else {
      turn(dx * 0.007, dy * 0.007);
    }
    down.set(event.pointerId, event);
  });
  const up = (event) => {
    if (!down.delete(event.pointerId) || moved >= 4 || event.type !== 'pointerup') return;
    const box = canvas.getBoundingClientRect();
    pick(event.clientX - box.left, event.clientY - box.top);
  };
  canvas.addEventListener('pointerup', up);
  canvas.addEventListener('pointercancel', up);
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const delta = event.deltaY * (event.deltaMode ? 20 : 1);
    zoom(Math.exp(Math.max(-60, Math.min(60, delta)) * 0.003));
  }, { passive: false });
}

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const { key } = event, arrow = arrows[key];
  const deeds = { '+': () => zoom(0.85), '=': () => zoom(0.85), '-': () => zoom(1 / 0.85),
    Home: goHome, w: goWorst, f: goFold };
  if (arrow && event.shiftKey) {
    move(30 * arrow[0], 30 * arrow[1]);
  } else if (arrow) {
    turn(0.1 * arrow[0], 0.1 * arrow[1]);
  } else if (key >= '1' && key <= '9' && !$('mode').options[key - 1].disabled) {
    $('mode').value = MODES[key - 1][0];
    refresh();
    writeLink();
  } else if (CHECKS[key.toLowerCase()]) {
    $(CHECKS[key.toLowerCase()]).click();
  } else if (deeds[key] ?? deeds[key.toLowerCase()]) {
    (deeds[key] ?? deeds[key.toLowerCase()])();
  } else {
    return;
  }
  event.preventDefault();
}

function listenToDivider() {
  const divider = $('divider');
  const slide = (to) => {
    state.split = Math.max(0, Math.min(1, to));
    placeDivider();
    redraw();
  };
  divider.addEventListener('pointerdown', (event) => divider.setPointerCapture(event.pointerId));
  divider.addEventListener('pointermove', (event) => {
    if (!divider.hasPointerCapture(event.pointerId)) return;
    const box = stage.getBoundingClientRect();
    slide((event.clientX - box.left) / box.width);
  });
  divider.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
    if (!step) return;
    slide(state.split + step);
    event.preventDefault();
  });
}

function savePicture() {
  render();
  canvas.toBlob((blob) => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = 'planish.png';
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  });
}

function listenToControls() {
  $('tools').addEventListener('input', async (event) => {
    if (event.target.id === 'other') {
      await show(state.job, event.target.value === '' ? null : Number(event.target.value));
    } else {
      refresh();
    }
    writeLink();
  });
  $('tools').addEventListener('submit', (event) => event.preventDefault());
  $('worst').addEventListener('click', goWorst);
  $('fold').addEventListener('click', goFold);
  $('home').addEventListener('click', goHome);
  $('save').addEventListener('click', savePicture);
  for (const link of document.querySelectorAll('tr[data-job] a')) {
    link.addEventListener('click', async (event) => {
      event.preventDefault();
      await show(Number(link.closest('tr').dataset.job));
      if (state.scene) writeLink();
    });
  }
}

function listen() {
  listenToPointers();
  listenToDivider();
  listenToControls();
  canvas.addEventListener('keydown', onKey);
  new ResizeObserver(redraw).observe(stage);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  addEventListener('hashchange', followLink);
  // On paper stand all jobs.
  addEventListener('beforeprint', () => {
    document.querySelectorAll('section.job').forEach((section) => { section.hidden = false; });
    render();
  });
  addEventListener('afterprint', () => {
    document.querySelectorAll('section.job').forEach((s, k) => { s.hidden = k !== state.job; });
  });
}
