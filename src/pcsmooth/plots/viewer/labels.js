// Texts on the picture: one is left out where it would touch another.

/** Pixels kept free around a text. */
const APART = 3;

/** How much of what is behind a text is covered. */
const BACKED = 0.75;

class Labels {
  constructor(context, ink, paper) {
    this.context = context;
    this.ink = ink;
    this.paper = paper;
    this.taken = [];
  }

  /** Keep a rectangle free of texts. */
  reserve(left, top, right, bottom) {
    this.taken.push([left, top, right, bottom]);
  }

  /**
   * Write a text if there is room for it in the panel; `across` and `down` say where the place lies
   * in the text, from 0 to 1. Returns whether it was written.
   */
  place(text, x, y, panel, { across = 0.5, down = 0.5, size = 12, isBold = false } = {}) {
    const { context } = this;
    context.font = `${isBold ? "600 " : ""}${size}px system-ui, sans-serif`;
    const width = context.measureText(text).width;
    const [left, top] = [x - across * width, y - down * size];
    const box = [left - APART, top - APART, left + width + APART, top + size + APART];
    const fits = box[0] >= panel.x && box[2] <= panel.x + panel.width
      && box[1] >= panel.y && box[3] <= panel.y + panel.height;
    const isFree = this.taken.every(
      (other) => box[2] <= other[0] || other[2] <= box[0] || box[3] <= other[1] || other[3] <= box[1],
    );
    if (!fits || !isFree) return false;
    this.taken.push(box);
    context.textAlign = "left";
    context.textBaseline = "middle";
    context.globalAlpha = BACKED;
    context.fillStyle = this.paper;
    context.fillRect(left - APART, top - APART, width + 2 * APART, size + 2 * APART);
    context.globalAlpha = 1;
    context.fillStyle = this.ink;
    context.fillText(text, left, top + size / 2);
    return true;
  }

  /** The text, cut where it is wider than so many pixels. */
  cut(text, width, size, isBold) {
    this.context.font = `${isBold ? "600 " : ""}${size}px system-ui, sans-serif`;
    if (this.context.measureText(text).width <= width) return text;
    let end = text.length;
    while (end && this.context.measureText(`${text.slice(0, end)}…`).width > width) end--;
    return `${text.slice(0, end)}…`;
  }
}

/** A length of 1, 2 or 5 times a power of ten, not shorter. */
function roundStep(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return power * ([1, 2, 5].find((factor) => factor * power >= length * (1 - 1e-9)) || 10);
}

/** Round numbers between two, so that steps are not shorter than told, and their texts. */
function ticks(low, high, least) {
  const step = roundStep(least);
  const digits = clamp(-Math.floor(Math.log10(step) + 1e-9), 0, 15);
  const first = Math.ceil(low / step - 1e-9);
  const count = clamp(Math.floor(high / step + 1e-9) - first + 1, 0, 200);
  const largest = Math.max(Math.abs(low), Math.abs(high));
  const isOdd = largest >= 1e15 || step < 1e-6; // neither is read as a row of digits
  return Array.from({ length: count }, (_, k) => {
    const value = (first + k) * step;
    const text = isOdd ? String(Number(value.toPrecision(6))) : value.toFixed(digits);
    return { value, text: text.replace(/^-(?=[0.]*$)/, "").replace("-", "−") };
  });
}
