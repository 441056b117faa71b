// Titles, axes with true coordinates, and the scale, drawn over the points.

/** Pixels between ticks at least, length of a tick, and room for what stands beside an axis. */
const TICKS_APART = 46;
const TICK = 5;
const MARGIN = 8;

/** Panels narrower than this have no room for two things beside each other at the bottom. */
const NARROW = 320;

/** Axes that point at the viewer more than this have no ticks: share of their length. */
const SHORTENED = 0.25;

const UNIT = "coordinate units";

class Axes {
  constructor(context, scene, box) {
    this.context = context;
    this.scene = scene;
    this.box = box;
  }

  draw(panel, camera, labels) {
    this.ink = labels.ink;
    const { plane } = camera;
    const edges = plane ? [] : this.edges(panel, camera);
    edges.forEach(({ from, to }) => this.line(from, to)); // under all texts
    this.title(panel, labels);
    if (plane) {
      this.rulers(panel, camera, plane, labels);
    } else {
      this.scaleBar(panel, camera, labels);
      this.directions(panel, camera, labels);
      this.edgeTicks(edges, panel, labels);
    }
  }

  title(panel, labels) {
    let y = panel.y + MARGIN + 7;
    const room = panel.width - 4 * MARGIN;
    const write = (text, look) => {
      const words = labels.cut(text, room, look.size, look.isBold);
      labels.place(words, panel.x + MARGIN, y, panel, { across: 0, ...look });
      y += look.size + 8;
    };
    write(panel.title, { size: 13, isBold: true });
    if (panel.note) write(panel.note, { size: 11 });
  }

  line(from, to, width = 1) {
    const { context } = this;
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...to);
    context.lineWidth = width;
    context.strokeStyle = this.ink;
    context.stroke();
  }

  /** Coordinates along the lower and the left border, where the view is along an axis. */
  rulers(panel, camera, [across, up], labels) {
    const { scene } = this;
    const unit = scene.scale / camera.scale(panel); // of the file, per pixel
    const center = scene.coordinates(camera.center);
    const [left, bottom] = [panel.x, panel.y + panel.height];
    const range = (axis, size) => [center[axis] - (size / 2) * unit, center[axis] + (size / 2) * unit];
    labels.place(`${"xyz"[across.axis]}, ${UNIT}`, left + panel.width - MARGIN, bottom - 34, panel,
      { across: 1, isBold: true });
    labels.place(`${"xyz"[up.axis]}, ${UNIT}`, left + MARGIN, panel.y + 62, panel,
      { across: 0, isBold: true });
    for (const { value, text } of this.fittingTicks(...range(across.axis, panel.width), unit)) {
      const x = left + panel.width / 2 + (across.sign * (value - center[across.axis])) / unit;
      if (labels.place(text, x, bottom - TICK - 9, panel)) {
        this.line([x, bottom - TICK], [x, bottom]);
      }
    }
    for (const { value, text } of ticks(...range(up.axis, panel.height), TICKS_APART * unit)) {
      const y = panel.y + panel.height / 2 - (up.sign * (value - center[up.axis])) / unit;
      if (labels.place(text, left + TICK + 4, y, panel, { across: 0 })) {
        this.line([left, y], [left + TICK, y]);
      }
    }
  }

  /** Ticks so far apart that the texts fit between them. */
  fittingTicks(low, high, unit) {
    let found = [];
    for (let apart = TICKS_APART; apart < 1000; apart *= 2) {
      found = ticks(low, high, apart * unit);
      const widest = Math.max(0, ...found.map(({ text }) => this.context.measureText(text).width));
      const step = found.length > 1 ? (found[1].value - found[0].value) / unit : Infinity;
      if (widest + 4 * APART < step) break;
    }
    return found;
  }

  /** Three edges of the box of all points, on its outline as it is seen, and their ticks. */
  edges(panel, camera) {
    const middle = camera.seen(times(plus(...this.box), 0.5), panel);
    const found = [];
    for (const axis of [0, 1, 2]) {
      const edge = this.outerEdge(axis, panel, camera);
      if (!edge) continue;
      const [from, to] = edge.map((corner) => camera.seen(corner, panel));
      const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
      if (length < TICKS_APART) continue;
      let outwards = [-(to[1] - from[1]) / length, (to[0] - from[0]) / length];
      const aside = [(from[0] + to[0]) / 2 - middle[0], (from[1] + to[1]) / 2 - middle[1]];
      if (outwards[0] * aside[0] + outwards[1] * aside[1] < 0) outwards = outwards.map((v) => -v);
      const [low, high] = edge.map((corner) => this.scene.coordinates(corner)[axis]);
      const shown = ticks(low, high, ((high - low) * TICKS_APART) / length);
      found.push({ axis, from, to, outwards, low, high, shown });
    }
    return found;
  }

  /** Names of the axes and ticks, outside of the edges. */
  edgeTicks(edges, panel, labels) {
    const { context } = this;
    context.font = "12px system-ui, sans-serif";
    for (const { axis, shown, outwards, from, to } of edges) {
      const widest = Math.max(0, ...shown.map(({ text }) => context.measureText(text).width));
      const far = TICK + 12 + Math.abs(outwards[0]) * (widest + 8) + Math.abs(outwards[1]) * 20;
      const [x, y] = [0, 1].map((k) => (from[k] + to[k]) / 2 + outwards[k] * far);
      labels.place("xyz"[axis], x, y, panel, { isBold: true, size: 13 });
    }
    for (const { low, high, shown, outwards, from, to } of edges) {
      for (const { value, text } of shown) {
        const share = (value - low) / (high - low);
        const [x, y] = [0, 1].map((k) => from[k] + (to[k] - from[k]) * share);
        const [across, down] = outwards;
        const [atX, atY] = [x + across * (TICK + 3), y + down * (TICK + 3)];
        const look = { across: 0.5 - 0.5 * across, down: 0.5 - 0.5 * down };
        if (labels.place(text, atX, atY, panel, look)) {
          this.line([x, y], [x + across * TICK, y + down * TICK]);
        }
      }
    }
  }

  /** Of the four edges of the box along an axis one that is on its outline, low or to the left. */
  outerEdge(axis, panel, camera) {
    const { box } = this;
    const others = [0, 1, 2].filter((k) => k !== axis);
    const shortened = Math.hypot(camera.axes[0][axis], camera.axes[1][axis]);
    if (shortened < SHORTENED || box[1][axis] === box[0][axis]) return null;
    let best = null;
    for (const sides of [[0, 0], [0, 1], [1, 0], [1, 1]]) {
      // A face is in front if its outward normal points at the viewer.
      const fronts = others.map((k, n) => (sides[n] ? 1 : -1) * camera.axes[2][k] > 0);
      if (fronts[0] === fronts[1]) continue;
      const edge = [0, 1].map((end) => {
        const corner = [0, 0, 0];
        corner[axis] = box[end][axis];
        others.forEach((k, n) => { corner[k] = box[sides[n]][k]; });
        return corner;
      });
      const [x, y] = camera.seen(times(plus(...edge), 0.5), panel);
      const score = axis === 2 ? -x : y;
      if (!best || score > best.score) best = { score, edge };
    }
    return best && best.edge;
  }

  scaleBar(panel, camera, labels) {
    const { scene } = this;
    const unit = scene.scale / camera.scale(panel);
    const step = roundStep(0.22 * Math.min(panel.width, 700) * unit);
    const length = step / unit > 0.5 * panel.width ? step / 2 : step;
    const [x, y] = [panel.x + MARGIN + 2, panel.y + panel.height - MARGIN - 4];
    const text = `${shortNumber(length)} ${UNIT}`;
    labels.reserve(x, y - 4, x + length / unit, y + 4);
    if (labels.place(text, x, y - 14, panel, { across: 0 })) {
      this.line([x, y], [x + length / unit, y], 3);
    }
  }

  directions(panel, camera, labels) {
    const { context } = this;
    const length = 26;
    const above = panel.width < NARROW ? 84 : 44; // the scale beside it, or below
    const [x, y] = [panel.x + panel.width - 44, panel.y + panel.height - above];
    context.globalAlpha = BACKED;
    context.fillStyle = labels.paper;
    context.beginPath();
    context.arc(x, y, 1.3 * length, 0, 2 * Math.PI);
    context.fill();
    context.globalAlpha = 1;
    camera.axes[0].forEach((across, k) => {
      const tip = [x + length * across, y - length * camera.axes[1][k]];
      this.line([x, y], tip, 1.5);
    });
    labels.reserve(x - 4, y - 4, x + 4, y + 4);
    [0, 1, 2]
      .map((k) => ({ k, seen: Math.hypot(camera.axes[0][k], camera.axes[1][k]) }))
      .sort((a, b) => b.seen - a.seen)
      .forEach(({ k, seen }) => {
        if (seen < SHORTENED) return;
        const [across, up] = [camera.axes[0][k], camera.axes[1][k]].map((part) => part * (1 + 0.35 / seen));
        labels.place("xyz"[k], x + length * across, y - length * up, panel, { isBold: true });
      });
  }
}
