// From where the points are seen: without perspective, so that lengths can be measured.

/** Radians that a drag across the whole panel turns. */
const FULL_TURN = Math.PI;

/** How far one may zoom, in units of the first view. */
const ZOOMS = [1e-6, 20];

/** Pixels beside and above the points at first, for titles and axes, and share of the panel at most. */
const ROOM = [60, 56];
const MOST_ROOM = 0.22;

class Camera {
  /** `axes`: rows to the right, up and towards the viewer. */
  constructor(axes, box) {
    this.look(axes, box);
    this.halfHeight = 1;
  }

  /** Half of what is seen across and up when the box fills a panel. */
  fit(panel) {
    const corners = boxCorners(this.box).map((corner) => minus(corner, this.center));
    const [across, up] = [0, 1].map((k) =>
      Math.max(...corners.map((corner) => Math.abs(dot(corner, this.axes[k])))),
    );
    const [width, height] = [panel.width, panel.height].map((size, k) =>
      size - 2 * Math.min(ROOM[k], MOST_ROOM * size));
    this.halfHeight = (panel.height / 2) * Math.max(across / (width / 2), up / (height / 2), 1e-6);
    this.fitted = this.halfHeight;
  }

  /** Look from there at the middle of a box; `fit` is to follow. */
  look(axes, box) {
    this.axes = axes;
    this.box = box;
    this.center = times(plus(...box), 0.5);
  }

  /** Pixels of a panel for a length of 1. */
  scale(panel) {
    return panel.height / (2 * this.halfHeight);
  }

  turn(across, up, panel) {
    const size = Math.min(panel.width, panel.height);
    const [yaw, pitch] = [(FULL_TURN * across) / size, (FULL_TURN * up) / size];
    const [right, above, towards] = this.axes;
    const turned = unit(
      plus(plus(times(towards, Math.cos(yaw) * Math.cos(pitch)), times(right, -Math.sin(yaw))),
        times(above, Math.sin(pitch))),
    );
    const level = unit(minus(right, times(turned, dot(right, turned))));
    this.axes = [level, cross(turned, level), turned];
  }

  move(across, up, panel) {
    const scale = this.scale(panel);
    this.center = minus(this.center, plus(
      times(this.axes[0], across / scale), times(this.axes[1], -up / scale)));
  }

  /** Enlarge, so that what is at a pixel stays there. */
  zoom(factor, x, y, panel) {
    const before = this.scale(panel);
    const [least, most] = ZOOMS.map((zoom) => zoom * this.fitted);
    this.halfHeight = clamp(this.halfHeight / factor, least, most);
    const after = this.scale(panel);
    const step = 1 / before - 1 / after;
    const [across, up] = [x - panel.x - panel.width / 2, panel.y + panel.height / 2 - y];
    this.center = plus(this.center,
      plus(times(this.axes[0], across * step), times(this.axes[1], up * step)));
  }

  /** Pixel of a place, and how near it is. */
  seen(place, panel) {
    const [across, up, near] = this.axes.map((axis) => dot(axis, minus(place, this.center)));
    const scale = this.scale(panel);
    return [
      panel.x + panel.width / 2 + across * scale,
      panel.y + panel.height / 2 - up * scale,
      near,
    ];
  }

  /**
   * The two axes of space that run across and up, and whether forwards (1) or backwards (-1), if it
   * looks along the third; else null.
   */
  get plane() {
    const found = this.axes.slice(0, 2).map((axis) => {
      const number = axis.findIndex((part) => Math.abs(part) > 1 - 1e-9);
      return number < 0 ? null : { axis: number, sign: Math.sign(axis[number]) };
    });
    return found.includes(null) ? null : found;
  }
}

function boxCorners([low, high]) {
  return Array.from({ length: 8 }, (_, corner) =>
    [0, 1, 2].map((k) => (corner & (1 << k) ? high[k] : low[k])),
  );
}

/** Axes of the views that have names. */
const VIEWS = {
  top: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  front: [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  right: [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
};
