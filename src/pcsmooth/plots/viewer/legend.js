// The scale of colors, with the histogram of the values above it.

const BAR = 12;

/** Height of the texts below, the title above, and room at the sides. */
const BELOW = 20;
const ABOVE = 4;
const BESIDE = 16;

class Legend {
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.scene = scene;
  }

  /** Draw the scale of a column, or what the colors of two clouds in one picture mean. */
  draw(column, colors, ratio, isOverlay) {
    const { canvas } = this;
    canvas.hidden = !column && !isOverlay;
    if (canvas.hidden) return;
    const { clientWidth: width, clientHeight: height } = canvas;
    resize(canvas, Math.round(width * ratio), Math.round(height * ratio));
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const labels = new Labels(context, colors.ink, colors.paper);
    const panel = { x: 0, y: 0, width, height };
    const names = isOverlay ? ["before", "after"] : Object.keys(column.counts);
    const lines = colors.lines.slice(-names.length);
    if (!isOverlay) this.scale(context, column, lines, labels, panel);
    if (names.length > 1) {
      names.forEach((name, k) => {
        const x = BESIDE + k * 80;
        context.fillStyle = lines[k];
        context.fillRect(x, ABOVE + 1, 10, 10);
        labels.place(name, x + 15, ABOVE + 6, panel, { across: 0, size: 11 });
      });
    }
  }

  /** The colors, their values, and how often there are which. */
  scale(context, column, lines, labels, panel) {
    const { scene } = this;
    const [left, right] = [BESIDE, panel.width - BESIDE];
    const bottom = panel.height - BELOW - BAR;
    const shades = scene.maps[column.is_signed ? 1 : 0];
    for (let x = left; x < right; x++) {
      const shade = shades[Math.floor(((x - left) / (right - left)) * (shades.length - 1))];
      context.fillStyle = `rgb(${shade.join()})`;
      context.fillRect(x, bottom, 1.2, BAR);
    }
    const distributions = Object.values(column.counts);
    const highest = Math.max(1, ...distributions.flat());
    distributions.forEach((bars, k) => {
      const step = (right - left) / bars.length;
      context.fillStyle = lines[k];
      context.globalAlpha = 0.55;
      bars.forEach((count, i) => {
        const tall = (count / highest) * (bottom - ABOVE - 18);
        context.fillRect(left + i * step, bottom - tall, step, tall);
      });
      context.globalAlpha = 1;
    });
    const [low, high] = column.limits;
    context.font = "11px system-ui, sans-serif";
    const shown = ticks(low, high, (high - low) / Math.max(1, Math.floor((right - left) / 48)));
    for (const { value, text } of shown) {
      const x = left + ((value - low) / (high - low)) * (right - left);
      context.fillStyle = labels.ink;
      context.fillRect(x - 0.5, bottom + BAR, 1, 4);
      const half = context.measureText(text).width / 2 + APART + 1;
      labels.place(text, clamp(x, half, panel.width - half), panel.height - 9, panel, { size: 11 });
    }
  }
}
