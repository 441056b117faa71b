// What is shown, and what is done to it.

/** Pixels between panels. */
const GAP = 2;

class Viewer {
  constructor(scene, canvas, overlay) {
    this.scene = scene;
    this.canvas = canvas;
    this.box = scene.frame;
    this.camera = new Camera(scene.view, this.box);
    this.slab = new Slab(scene, this.box);
    this.mode = scene.clouds.length > 1 ? "side" : "one";
    this.share = scene.clouds.length > 1 ? 1 : 0;
    this.columnNumber = scene.column;
    this.wanted = scene.column; // until its values are there
    this.size = 1;
    this.isMeasuring = false;
    this.marks = []; // places that were clicked
    this.words = "";
    this.frames = new Frames(this, canvas, overlay);
  }

  get isFlat() {
    return this.scene.dimension === 2;
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

  redraw() {
    this.frames.redraw();
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

  /** Color by a column, which takes a moment; if another is chosen meanwhile, by that one. */
  async color(number) {
    this.wanted = number;
    const { frames, scene } = this;
    const column = scene.columns[number];
    const found = new Map();
    if (column && column.values) {
      for (const set of scene.sets) found.set(set, await scene.valuesOf(column, set));
    }
    if (number !== this.wanted) return;
    this.columnNumber = number;
    found.forEach((values, set) => frames.renderer.setValues(set, values));
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
    const { renderer } = this.frames;
    const radius = renderer.diameter(panel) / 2 / renderer.picture.ratio;
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

  // Panels

  /** Where clouds are drawn, and what is drawn there. */
  get panels() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const { scene, mode, share } = this;
    const whole = { x: 0, y: 0, width, height };
    const { notes } = this.column || scene.columns.at(-1); // coordinates are all known
    const noted = (k) => ({ title: scene.clouds[k].title, note: notes[k] });
    if (mode === "side") {
      const { isStacked } = this;
      const size = isStacked ? { width, height: (height - GAP) / 2 } : { width: (width - GAP) / 2, height };
      return [0, 1].map((k) => ({
        x: isStacked ? 0 : k * (size.width + GAP), y: isStacked ? k * (size.height + GAP) : 0, ...size,
        ...noted(k), layers: [scene.layer(k)],
      }));
    }
    if (mode === "overlay") {
      const { lines } = themeOf(scene);
      const layers = [0, 1].map((k) => ({ ...scene.layer(k), tint: rgbOf(lines[k]) }));
      return [{ ...whole, title: "before and after", note: "before red, after blue", layers }];
    }
    if (scene.is_paired && share > 0 && share < 1) {
      const title = `${Math.round(100 * share)} % of the way from before to after`;
      return [{ ...whole, title, note: "", layers: [{ set: scene.sets[0], share }] }];
    }
    const k = Math.round(share);
    return [{ ...whole, ...noted(k), layers: [scene.layer(k)] }];
  }

  panelAt(x, y) {
    const { panels } = this;
    return panels.find((panel) => x <= panel.x + panel.width && y <= panel.y + panel.height)
      || panels[panels.length - 1];
  }
}
