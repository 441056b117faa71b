// When what is drawn: some points while something moves, all when it stands still.

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

/** Pixels of the screen per pixel of the page at most. */
const MOST_RATIO = 2;

const pageRatio = () => Math.min(window.devicePixelRatio || 1, MOST_RATIO);

class Frames {
  constructor(viewer, canvas, overlay) {
    const { scene, box } = viewer;
    this.viewer = viewer;
    this.canvas = canvas;
    this.overlay = overlay;
    this.renderer = new Renderer(canvas, scene);
    this.axes = new Axes(overlay.getContext("2d"), scene, box);
    this.legend = new Legend(byId("legend"), scene);
    this.count = FIRST_COUNT; // points per frame, in all layers
    this.changed = 0; // when something last moved
    this.begun = -1; // when a picture of it was
    this.isWaiting = false; // for a frame
    this.isWhole = false; // whether the picture that was begun is to have all points
    this.isSharp = true;
  }

  /** Draw what has changed. */
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
    const isMoving = this.changed > this.begun;
    if (isMoving) {
      this.begun = performance.now();
      const isSlow = renderer.picture && this.count * SLOW < renderer.largest * renderer.passes;
      this.begin(isSlow ? pageRatio() * COARSE : pageRatio());
      const count = Math.ceil(this.count / renderer.passes);
      this.timed(() => renderer.draw(count, LARGER * Math.sqrt(renderer.largest / count)));
      this.isWhole = false;
      this.isSharp = renderer.isComplete;
      this.show();
    } else if (!this.isSharp && performance.now() - this.changed > STANDING) {
      if (!this.isWhole) {
        this.begin(pageRatio());
        this.isWhole = true;
      }
      this.timed(() => renderer.draw(Math.ceil(this.count / renderer.passes)));
      this.isSharp = renderer.isComplete;
      if (this.isSharp) this.show();
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
    const { viewer, canvas } = this;
    const theme = themeOf(viewer.scene);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((size) =>
      Math.max(1, Math.round(size * ratio)));
    this.renderer.begin({
      panels: viewer.panels, camera: viewer.camera, slab: viewer.slab.shape, column: viewer.column,
      size: viewer.size, width, height, ratio, paper: rgbOf(theme.paper),
      plain: rgbOf(viewer.isFlat ? theme.ink : PLAIN),
    });
  }

  /** Show the picture, with titles, axes and marks, and bring the controls up to date. */
  show() {
    this.renderer.present();
    const { overlay, viewer } = this;
    const ratio = pageRatio();
    const theme = themeOf(viewer.scene);
    const context = overlay.getContext("2d");
    resize(overlay, ...[overlay.clientWidth, overlay.clientHeight].map((size) =>
      Math.round(size * ratio)));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, overlay.width, overlay.height);
    const labels = new Labels(context, theme.ink, theme.paper);
    for (const panel of viewer.panels) {
      context.save();
      context.beginPath();
      context.rect(panel.x, panel.y, panel.width, panel.height);
      context.clip();
      drawMarks(context, viewer, panel, labels);
      this.axes.draw(panel, viewer.camera, labels);
      context.restore();
    }
    this.legend.draw(viewer.column, theme, ratio, viewer.mode === "overlay");
    viewer.update();
  }
}
