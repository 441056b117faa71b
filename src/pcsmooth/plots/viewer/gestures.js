// Mouse, touch and keys on the points.

/** Pixels that a click may move. */
const STILL = 5;

/** Milliseconds and pixels between two clicks that are a double click. */
const DOUBLE = 350;
const DOUBLE_APART = 20;

/** What a key turns or moves, pixels; what wheel and keys enlarge by. */
const KEY_STEP = 40;
const WHEEL = 0.0015;
const KEY_ZOOM = 1.25;

/**
 * Tell a viewer of what is done on its canvas: `turn`, `move` and `zoom` with pixels, `click` and
 * `doubleClick` with a place, `key` with a letter.
 */
function listen(canvas, viewer) {
  const held = new Map(); // pointers that are down, by their numbers
  let path = 0; // that the pointer went since it went down
  let last = null; // click
  const placeOf = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    if (!held.size) path = 0;
    held.set(event.pointerId, placeOf(event));
    if (held.size > 1) path = Infinity;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held.has(event.pointerId)) return;
    const [x, y] = placeOf(event);
    const [oldX, oldY] = held.get(event.pointerId);
    const [across, down] = [x - oldX, y - oldY];
    path += Math.hypot(across, down);
    if (held.size === 2) {
      const [other] = [...held].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const before = Math.hypot(oldX - other[0], oldY - other[1]);
      const after = Math.hypot(x - other[0], y - other[1]);
      const middle = [(x + other[0]) / 2, (y + other[1]) / 2];
      viewer.zoom(clamp(after / Math.max(before, 1), 0.5, 2), ...middle);
      viewer.move(across / 2, down / 2, ...middle);
    } else if (held.size === 1 && path > STILL) {
      const isMove = event.shiftKey || event.buttons & 6 || viewer.isFlat;
      viewer[isMove ? "move" : "turn"](across, down, x, y);
    }
    held.set(event.pointerId, [x, y]);
  });
  const release = (event) => {
    if (!held.delete(event.pointerId) || event.type !== "pointerup") return;
    if (held.size || path > STILL || event.button > 0) return;
    const [x, y] = placeOf(event);
    const isDouble = last && event.timeStamp - last.time < DOUBLE
      && Math.hypot(x - last.x, y - last.y) < DOUBLE_APART;
    viewer[isDouble ? "doubleClick" : "click"](x, y);
    last = isDouble ? null : { x, y, time: event.timeStamp };
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 20 : 1;
    viewer.zoom(Math.exp(-WHEEL * clamp(event.deltaY * lines, -400, 400)), ...placeOf(event));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const step = steps[event.key];
    const middle = [canvas.clientWidth / 4, canvas.clientHeight / 4];
    if (step) {
      const isMove = event.shiftKey || viewer.isFlat;
      viewer[isMove ? "move" : "turn"](KEY_STEP * step[0], KEY_STEP * step[1], ...middle);
    } else if (event.key === "+" || event.key === "=") {
      viewer.zoomMiddle(KEY_ZOOM);
    } else if (event.key === "-") {
      viewer.zoomMiddle(1 / KEY_ZOOM);
    } else if (!viewer.key(event.key.toLowerCase())) {
      return;
    }
    event.preventDefault();
  });
}
