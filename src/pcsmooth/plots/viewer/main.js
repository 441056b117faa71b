// The viewer: what is shown, and when it is drawn.

/** Milliseconds in which the points of a frame are drawn, and after which they stand still. */
const FRAME = 16;
const STANDING = 160;

/** Points drawn in the first frame, and in any at least. */
const FIRST_COUNT = 200_000;
const LEAST_COUNT = 10_000;

/** How much larger fewer points are drawn: not as if they overlapped as much as all do. */
const LARGER = 0.65;

/**
 * Pictures are coarser while points move, by this factor, if a frame has time for less than one of so
 * many points.
 */
const COARSE = 0.5;
const SLOW = 8;

/** Factor of the colors of what is before and after, on dark paper. */
const LIGHTER = 1.9;

/** Color of what was clicked. */
const MARK = "#e0391c";

/** Pixels between panels, and of the screen per pixel of the page at most. */
const GAP = 2;
const MOST_RATIO = 2;

class Viewer {
  constructor(scene, canvas, overlay) {
    this.scene = scene;
    this.canvas = canvas;
    this.overlay = overlay;
    this.renderer = new Renderer(canvas, scene);
    const box = scene.boxOf(NO_SLAB);
    this.box = box;
    this.camera = new Camera(scene.view, box);
    this.slab = new Slab(scene, box);
    this.axes = new Axes(overlay.getContext("2d"), scene, box);
    this.legend = new Legend(byId("legend"), scene);
    this.mode = scene.clouds.length > 1 ? "side" : "one";
    this.share = scene.clouds.length > 1 ? 1 : 0;
    this.columnNumber = 0;
    this.size = 1;
    this.isMeasuring = false;
    this.marks = []; // places that were clicked
    this.words = "";
    this.count = FIRST_COUNT; // points per frame, in all layers
    this.changed = 0;
    this.isWaiting = false;
    this.isSharp = true;
  }

  get isFlat() {
    return this.scene.dimension === 2;
  }

  /** Colors of the page, which the browser may change. */
  get colors() {
    const style = getComputedStyle(document.documentElement);
    return Object.fromEntries(
      ["paper", "ink"].map((name) => [name, style.getPropertyValue(`--${name}`).trim()]),
    );
  }

  get column() {
    return this.scene.columns[this.columnNumber] || null;
  }

  async start() {
    await this.color(this.columnNumber);
    this.update = connect(this);
    listen(this.canvas, this);
    this.fit();
    new ResizeObserver(() => {
      this.refit();
      this.redraw();
    }).observe(this.canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
    this.redraw();
  }

  // What is shown

  /** "one" cloud, or a place between before and after; both "side" by side or as "overlay". */
  show(mode, share = this.share) {
    const wasSide = this.mode === "side";
    [this.mode, this.share] = [mode, share];
    if (wasSide !== (mode === "side")) this.refit();
    this.redraw();
  }

  /** Keep what is seen in view when panels become wider or narrower. */
  refit() {
    const zoom = this.camera.fitted / this.camera.halfHeight;
    this.fit();
    this.camera.halfHeight /= zoom;
  }

  /** Fill the panels, which are put beside or above each other, whichever shows more. */
  fit() {
    const { camera } = this;
    const scales = [false, true].map((isStacked) => {
      this.isStacked = isStacked;
      const [panel] = this.panels;
      camera.fit(panel);
      return camera.scale(panel);
    });
    this.isStacked = scales[1] > scales[0];
    camera.fit(this.panels[0]);
  }

  async color(number) {
    this.columnNumber = number;
    const { column, scene } = this;
    if (column && column.values) {
      for (const set of scene.sets) {
        this.renderer.setValues(set, await scene.valuesOf(column, set));
      }
    }
    this.redraw();
  }

  look(axes) {
    this.lookAt(axes, this.box);
  }

  /** Look along the normal of the slice at what is in it. */
  profile() {
    const axes = this.isFlat ? this.scene.view : this.slab.axes;
    this.lookAt(axes, this.scene.boxOf(this.slab.shape) || this.box);
  }

  lookAt(axes, box) {
    this.camera.look(axes, box);
    this.fit();
    this.redraw();
  }

  resize(size) {
    this.size = size;
    this.redraw();
  }

  slice(across) {
    this.slab.choose(across, this.camera);
    this.redraw();
  }

  setSlab(values) {
    Object.assign(this.slab, values);
    this.redraw();
  }

  measure(is) {
    this.isMeasuring = is;
    this.marks = [];
    this.words = is ? "Click two points." : "";
    this.redraw();
  }

  // Gestures

  turn(across, down, x, y) {
    this.camera.turn(across, down, this.panelAt(x, y));
    this.redraw();
  }

  move(across, down, x, y) {
    this.camera.move(across, down, this.panelAt(x, y));
    this.redraw();
  }

  zoom(factor, x, y) {
    this.camera.zoom(factor, x, y, this.panelAt(x, y));
    this.redraw();
  }

  zoomMiddle(factor) {
    const [panel] = this.panels;
    this.zoom(factor, panel.x + panel.width / 2, panel.y + panel.height / 2);
  }

  click(x, y) {
    const found = this.find(x, y);
    if (!found) {
      if (!this.isMeasuring) [this.marks, this.words] = [[], ""];
    } else if (this.isMeasuring) {
      this.marks = this.marks.length === 1 ? [...this.marks, found.place] : [found.place];
      this.words = this.marks.length === 2 ? distanceInWords(...this.marks, this.scene)
        : `from ${pointInWords(found.place, this.scene)}; click the second point`;
    } else {
      this.marks = [found.place];
      this.words = `${pointInWords(found.place, this.scene)}\n${this.valueInWords(found)}`;
    }
    this.redraw();
  }

  doubleClick(x, y) {
    const found = this.find(x, y);
    if (!found) return;
    this.camera.center = found.place;
    this.redraw();
  }

  key(letter) {
    const actions = {
      b: () => this.show("one", 0),
      a: () => this.show("one", 1),
      s: () => this.show("side"),
      o: () => this.show("overlay"),
      " ": () => this.show("one", this.mode === "one" && this.share > 0.5 ? 0 : 1),
      m: () => this.measure(!this.isMeasuring),
      0: () => this.look(this.scene.view),
      home: () => this.look(this.scene.view),
    };
    const isKnown = letter in actions && (this.scene.clouds.length > 1 || !"baso ".includes(letter));
    if (isKnown) actions[letter]();
    return isKnown;
  }

  find(x, y) {
    const panel = this.panelAt(x, y);
    const radius = this.renderer.diameter(panel) / 2 / this.renderer.picture.ratio;
    return pointAt(x, y, panel, this.camera, this.slab.shape, radius);
  }

  valueInWords({ set, share, i }) {
    const { column, scene } = this;
    if (!column || !column.values) return "";
    const ends = !scene.is_paired ? [scene.sets.indexOf(set)]
      : share === 0 ? [0] : share === 1 ? [1] : [0, 1];
    const values = ends.map((end) => halfValue(scene.values.get(column.values[end])[i]));
    if (values.includes(NO_VALUE)) return `${column.label}: unknown`;
    const [first, last = first] = values;
    const [low, high] = column.limits;
    const value = (low + high) / 2 + ((high - low) / 2) * (first + (last - first) * share);
    return `${column.label}: ${String(Number(value.toPrecision(3)))}`;
  }

  // Drawing

  get ratio() {
    return Math.min(window.devicePixelRatio || 1, MOST_RATIO);
  }

  /** Where clouds are drawn, and what is drawn there. */
  get panels() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const { scene, mode, share } = this;
    const whole = { x: 0, y: 0, width, height };
    const noted = (k) => ({ title: scene.clouds[k].title, note: scene.clouds[k].counts });
    if (mode === "side") {
      const { isStacked } = this;
      const size = isStacked ? { width, height: (height - GAP) / 2 } : { width: (width - GAP) / 2, height };
      return [0, 1].map((k) => ({
        x: isStacked ? 0 : k * (size.width + GAP), y: isStacked ? k * (size.height + GAP) : 0, ...size,
        ...noted(k), layers: [scene.layer(k)],
      }));
    }
    if (mode === "overlay") {
      const layers = [0, 1].map((k) => ({ ...scene.layer(k), tint: rgbOf(this.lines[k]) }));
      return [{ ...whole, title: "before and after", note: "before red, after blue", layers }];
    }
    if (scene.is_paired && share > 0 && share < 1) {
      const title = `${Math.round(100 * share)} % of the way from before to after`;
      return [{ ...whole, title, note: "", layers: [{ set: scene.sets[0], share }] }];
    }
    const k = Math.round(share);
    return [{ ...whole, ...noted(k), layers: [scene.layer(k)] }];
  }

  /** Colors of what is before and after, lighter on dark paper. */
  get lines() {
    const isDark = rgbOf(this.colors.paper)[0] < 0.5;
    const factor = isDark ? LIGHTER : 1;
    return this.scene.line_colors.map((color) =>
      hexOf(rgbOf(color).map((part) => Math.min(1, factor * part))));
  }

  panelAt(x, y) {
    const { panels } = this;
    return panels.find((panel) => x <= panel.x + panel.width && y <= panel.y + panel.height)
      || panels[panels.length - 1];
  }

  redraw() {
    this.changed = performance.now();
    this.isSharp = false;
    this.request();
  }

  request() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      this.frame();
    });
  }

  /**
   * While something moves, draw as many points as a frame has time for; then, in as many frames as
   * it takes, all of them.
   */
  frame() {
    const { renderer } = this;
    const isMoving = this.changed > (this.begun || 0);
    if (isMoving) {
      this.begun = performance.now();
      const isSlow = renderer.picture && this.count * SLOW < renderer.largest * renderer.passes;
      this.begin(isSlow ? this.ratio * COARSE : this.ratio);
      const count = Math.ceil(this.count / renderer.passes);
      this.timed(() => renderer.draw(count, LARGER * Math.sqrt(renderer.largest / count)));
      this.finished = false;
      this.isSharp = renderer.isComplete;
      this.show2d();
    } else if (!this.isSharp && performance.now() - this.changed > STANDING) {
      if (!this.finished) {
        this.begin(this.ratio);
        this.finished = true;
      }
      this.timed(() => renderer.draw(Math.ceil(this.count / renderer.passes)));
      this.isSharp = renderer.isComplete;
      if (this.isSharp) this.show2d();
    }
    if (!this.isSharp) this.request();
  }

  /** Draw, and learn how many points a frame has time for. */
  timed(draw) {
    this.renderer.finish(); // what was begun before
    const start = performance.now();
    draw();
    this.renderer.finish();
    const spent = Math.max(performance.now() - start, 1);
    this.count = clamp(this.count * clamp(FRAME / spent, 0.2, 1.5), LEAST_COUNT, 1e7);
  }

  begin(ratio) {
    const { canvas, colors } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((size) =>
      Math.max(1, Math.round(size * ratio)));
    this.renderer.begin({
      panels: this.panels, camera: this.camera, slab: this.slab.shape, column: this.column,
      size: this.size, width, height, ratio, paper: rgbOf(colors.paper),
      plain: this.isFlat ? rgbOf(colors.ink) : [0.96, 0.95, 0.93],
    });
  }

  /** Show the picture, with titles, axes and marks, and bring the controls up to date. */
  show2d() {
    this.renderer.present();
    const { overlay, camera, colors, lines, ratio } = this;
    const context = overlay.getContext("2d");
    resize(overlay, ...[overlay.clientWidth, overlay.clientHeight].map((size) =>
      Math.round(size * ratio)));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, overlay.width, overlay.height);
    const labels = new Labels(context, colors.ink, colors.paper);
    for (const panel of this.panels) {
      context.save();
      context.beginPath();
      context.rect(panel.x, panel.y, panel.width, panel.height);
      context.clip();
      this.drawMarks(context, panel, labels);
      this.axes.draw(panel, camera, labels);
      context.restore();
    }
    this.legend.draw(this.column, { ...colors, lines }, ratio, this.mode === "overlay");
    this.update();
  }

  drawMarks(context, panel, labels) {
    const seen = this.marks.map((place) => this.camera.seen(place, panel));
    if (seen.length === 2) {
      context.strokeStyle = MARK;
      context.lineWidth = 2;
      context.beginPath();
      context.moveTo(seen[0][0], seen[0][1]);
      context.lineTo(seen[1][0], seen[1][1]);
      context.stroke();
      const text = shortNumber(lengthOf(...this.marks, this.scene));
      const middle = [0, 1].map((k) => (seen[0][k] + seen[1][k]) / 2);
      labels.place(text, middle[0], middle[1] - 12, panel, { isBold: true });
    }
    context.fillStyle = MARK;
    for (const [x, y] of seen) {
      context.beginPath();
      context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fill();
    }
  }
}

/** A color in hexadecimal, of red, green and blue from 0 to 1. */
function hexOf(parts) {
  return `#${parts.map((part) => Math.round(255 * part).toString(16).padStart(2, "0")).join("")}`;
}

/** Red, green and blue from 0 to 1 of a color in hexadecimal. */
function rgbOf(color) {
  const digits = color.length === 4 ? [...color.slice(1)].map((d) => d + d).join("") : color.slice(1);
  return [0, 2, 4].map((k) => parseInt(digits.slice(k, k + 2), 16) / 255);
}

/** Show a message over the picture, or none. */
function tell(text) {
  byId("message").textContent = text;
  byId("message").hidden = !text;
}

async function main() {
  try {
    const viewer = new Viewer(await Scene.read(), byId("points"), byId("labels"));
    await viewer.start();
    tell("");
  } catch (error) {
    tell(error.message);
    throw error;
  }
}

main();
