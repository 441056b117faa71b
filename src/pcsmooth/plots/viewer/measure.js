// Finding the point under the pointer, and what is said and drawn of one or two.

/** Pixels from the pointer within which a point is looked for. */
const REACH = 12;

/** The point that is seen at a pixel, or else the nearest to it: its set, number and place. */
function pointAt(x, y, panel, camera, shape, radius) {
  const [right, above, towards] = camera.axes;
  const scale = camera.scale(panel);
  const across = (x - panel.x - panel.width / 2) / scale + dot(right, camera.center);
  const up = (panel.y + panel.height / 2 - y) / scale + dot(above, camera.center);
  const covered = (radius / scale) ** 2;
  const reach = (Math.max(REACH, radius) / scale) ** 2;
  let best = null;
  for (const { set, share } of panel.layers) {
    const [from, to] = set.ends;
    for (let i = 0, k = 0; i < set.count; i++, k += 3) {
      const p = from[k] + (to[k] - from[k]) * share;
      const q = from[k + 1] + (to[k + 1] - from[k + 1]) * share;
      const r = from[k + 2] + (to[k + 2] - from[k + 2]) * share;
      const aside = right[0] * p + right[1] * q + right[2] * r - across;
      if (aside * aside > reach) continue;
      const over = above[0] * p + above[1] * q + above[2] * r - up;
      const apart = aside * aside + over * over;
      if (apart > reach || !isInside(shape, [p, q, r])) continue;
      const near = towards[0] * p + towards[1] * q + towards[2] * r;
      const isCovering = apart <= covered;
      const isBetter = !best || (isCovering
        ? !best.isCovering || near > best.near
        : !best.isCovering && apart < best.apart);
      if (isBetter) best = { set, share, i, near, apart, isCovering, place: [p, q, r] };
    }
  }
  return best;
}

/** A number with as many digits as one reads. */
function shortNumber(value) {
  return String(Number(value.toPrecision(4)));
}

/** A coordinate with the digits that points are apart by. */
function coordinateText(value, scene) {
  const digits = Math.ceil(-Math.log10(scene.scale * scene.spacing)) + 1;
  if (digits > 12 || Math.abs(value) >= 1e15) return value.toPrecision(7);
  return value.toFixed(Math.max(0, digits));
}

function pointInWords(place, scene) {
  const coordinates = scene.coordinates(place);
  return coordinates.map((value, k) => `${"xyz"[k]} ${coordinateText(value, scene)}`).join(", ");
}

/** Distance of two places, and along the axes. */
function distanceInWords(first, last, scene) {
  const apart = times(minus(last, first), scene.scale);
  const along = scene.origin.map((_, k) => `along ${"xyz"[k]}: ${shortNumber(apart[k])}`);
  return `distance: ${shortNumber(lengthOf(first, last, scene))} coordinate units\n${along.join("\n")}`;
}

/** In units of the page first: squares of lengths in the file may be too large for a number. */
function lengthOf(first, last, scene) {
  return Math.hypot(...minus(last, first)) * scene.scale;
}

/** Draw the places that were clicked, and the distance of two. */
function drawMarks(context, { marks, camera, scene }, panel, labels) {
  const seen = marks.map((place) => camera.seen(place, panel));
  if (seen.length === 2) {
    context.strokeStyle = MARK;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(seen[0][0], seen[0][1]);
    context.lineTo(seen[1][0], seen[1][1]);
    context.stroke();
    const text = shortNumber(lengthOf(...marks, scene));
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
