// Colors of the page, which the browser may change from light to dark.

/** Factor of the colors of what is before and after, on dark paper. */
const LIGHTER = 1.9;

/** Color of what was clicked, and of points without a color of their own in space. */
const MARK = "#e0391c";
const PLAIN = "#f5f2ed";

/** Colors of the paper and of the ink, and those of what is before and after. */
function themeOf(scene) {
  const style = getComputedStyle(document.documentElement);
  const [paper, ink] = ["paper", "ink"].map((name) => style.getPropertyValue(`--${name}`).trim());
  const factor = rgbOf(paper)[0] < 0.5 ? LIGHTER : 1;
  const lines = scene.line_colors.map((color) =>
    hexOf(rgbOf(color).map((part) => Math.min(1, factor * part))));
  return { paper, ink, lines };
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
