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

  /** Draw the scale of a column, or hide it where points are shaded only. */
  draw(column, colors, ratio) {
    const { canvas, scene } = this;
    canvas.hidden = !column;
    if (!column) return;
    const { clientWidth: width, clientHeight: height } = canvas;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const [left, right] = [BESIDE, width - BESIDE];
    const bottom = height - BELOW - BAR;
    const shades = scene.maps[column.is_signed ? 1 : 0];
    for (let x = left; x < right; x++) {
      const shade = shades[Math.floor(((x - left) / (right - left)) * (shades.length - 1))];
      context.fillStyle = `rgb(${shade.join()})`;
      context.fillRect(x, bottom, 1.2, BAR);
    }
    const [low, high] = column.limits;
    const names = Object.keys(column.counts);
    const highest = Math.max(1, ...names.flatMap((name) => column.counts[name]));
    const lines = scene.line_colors.slice(-names.length);
    const labels = new Labels(context, colors.ink, colors.paper);
    const panel = { x: 0, y: 0, width, height };
    names.forEach((name, k) => {
      const bars = column.counts[name];
      const step = (right - left) / bars.length;
      context.fillStyle = lines[k];
      context.globalAlpha = 0.55;
      bars.forEach((count, i) => {
        const tall = (count / highest) * (bottom - ABOVE - 18);
        context.fillRect(left + i * step, bottom - tall, step, tall);
      });
      context.globalAlpha = 1;
      if (names.length > 1) {
        const x = left + k * 80;
        context.fillRect(x, ABOVE + 1, 10, 10);
        labels.place(name, x + 15, ABOVE + 6, panel, { across: 0, size: 11 });
      }
    });
    context.font = "11px system-ui, sans-serif";
    const shown = ticks(low, high, (high - low) / Math.max(1, Math.floor((right - left) / 48)));
    for (const { value, text } of shown) {
      const x = left + ((value - low) / (high - low)) * (right - left);
      context.fillStyle = colors.ink;
      context.fillRect(x - 0.5, bottom + BAR, 1, 4);
      labels.place(text, x, height - 9, panel, { size: 11 });
    }
  }
}
