// Points of the page, unpacked: `point_blocks.py` says how they are packed.

/** What stands for a value that is unknown, in half precision. */
const NO_VALUE = 65504;

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Whole numbers of a block, a list of columns. */
async function unpacked(number, about) {
  const element = document.getElementById(`block-${number}`);
  const bytes = await inflated(element.textContent);
  element.remove(); // the text is longer than the numbers
  const planes = about.bits / 8;
  const rows = bytes.length / planes / about.columns;
  const mask = 2 ** about.bits - 1;
  return Array.from({ length: about.columns }, (_, column) => {
    const numbers = new Uint32Array(rows);
    for (let plane = 0; plane < planes; plane++) {
      const start = (column * planes + plane) * rows;
      for (let i = 0; i < rows; i++) numbers[i] |= bytes[start + i] << (8 * plane);
    }
    if (about.is_running) {
      for (let i = 1; i < rows; i++) numbers[i] = (numbers[i] + numbers[i - 1]) & mask;
    }
    return numbers;
  });
}

/** An order in which the first points are always some of everywhere; the same at each visit. */
function shuffledOrder(count) {
  const order = Uint32Array.from({ length: count }, (_, i) => i);
  let seed = 1;
  for (let i = count - 1; i > 0; i--) {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    const other = Math.floor((seed / 2 ** 32) * (i + 1));
    [order[i], order[other]] = [order[other], order[i]];
  }
  return order;
}

/** The number that 16 bits of half precision stand for. */
function halfValue(bits) {
  const exponent = (bits >> 10) & 31;
  const fraction = (bits & 1023) / 1024;
  const size = exponent ? 2 ** (exponent - 15) * (1 + fraction) : 2 ** -14 * fraction;
  return bits & 32768 ? -size : size;
}

/**
 * Points that are drawn at once, each with two ends: before and after. Of clouds that are not the
 * same points both ends are at one place.
 */
class PointSet {
  constructor(order, ends, normals) {
    this.order = order;
    this.count = order.length;
    this.ends = ends; // Float32Array of x, y, z between -1 and 1
    this.normals = normals; // Uint8Array of two numbers, or null
  }
}

/** All that the page holds. */
class Scene {
  constructor(about) {
    Object.assign(this, about);
    this.sets = [];
    this.values = new Map(); // by block, in the order of drawing
  }

  static async read() {
    const scene = new Scene(JSON.parse(document.getElementById("scene").textContent));
    const { clouds, blocks } = scene;
    const read = (number) => (number === null ? null : unpacked(number, blocks[number]));
    const orders = [];
    const ends = [];
    const normals = [];
    let before = null;
    for (const [k, cloud] of clouds.entries()) {
      const columns = await read(cloud.positions);
      const { bits } = blocks[cloud.positions];
      if (k && scene.is_paired) {
        const mask = 2 ** bits - 1;
        columns.forEach((column, c) => {
          for (let i = 0; i < column.length; i++) column[i] = (column[i] + before[c][i]) & mask;
        });
      }
      before = columns;
      orders.push(k && scene.is_paired ? orders[0] : shuffledOrder(cloud.count));
      ends.push(interleavedPlaces(columns, orders[k], bits));
      const packed = await read(cloud.normals);
      normals.push(packed && interleaved(packed, orders[k]));
    }
    scene.sets = scene.is_paired
      ? [new PointSet(orders[0], ends, normals)]
      : clouds.map((_, k) => new PointSet(orders[k], [ends[k], ends[k]], [normals[k], normals[k]]));
    return scene;
  }

  /** The cloud, or the end of the points, that is shown: its set and where between the ends. */
  layer(k) {
    return this.is_paired ? { set: this.sets[0], share: k } : { set: this.sets[k], share: 0 };
  }

  /** Values of a column at both ends of the points of a set, bits of half precision. */
  async valuesOf(column, set) {
    const numbers = column.values;
    const s = this.sets.indexOf(set);
    const wanted = this.is_paired ? numbers : [numbers[s], numbers[s]];
    const found = [];
    for (const number of wanted) {
      if (!this.values.has(number)) {
        const [bits] = await unpacked(number, this.blocks[number]);
        this.values.set(number, Uint16Array.from(set.order, (i) => bits[i]));
      }
      found.push(this.values.get(number));
    }
    return found;
  }

  /** Coordinates in the file of a place on the page. */
  coordinates(place) {
    return this.origin.map((start, k) => start + this.scale * place[k]);
  }

  /** Lowest and highest corner of the points in a slab, or null if there are none. */
  boxOf({ normal: [a, b, c], middle, half }) {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (const end of new Set(this.sets.flatMap((set) => set.ends))) {
      for (let i = 0; i < end.length; i += 3) {
        if (Math.abs(a * end[i] + b * end[i + 1] + c * end[i + 2] - middle) > half) continue;
        for (let k = 0; k < 3; k++) {
          if (end[i + k] < low[k]) low[k] = end[i + k];
          if (end[i + k] > high[k]) high[k] = end[i + k];
        }
      }
    }
    return low[0] <= high[0] ? [low, high] : null;
  }
}

function interleavedPlaces(columns, order, bits) {
  const places = new Float32Array(3 * order.length);
  const step = 2 / (2 ** bits - 1);
  columns.forEach((column, k) => {
    for (let i = 0; i < order.length; i++) places[3 * i + k] = column[order[i]] * step - 1;
  });
  return places;
}

function interleaved(columns, order) {
  const numbers = new Uint8Array(columns.length * order.length);
  columns.forEach((column, k) => {
    for (let i = 0; i < order.length; i++) numbers[columns.length * i + k] = column[order[i]];
  });
  return numbers;
}
