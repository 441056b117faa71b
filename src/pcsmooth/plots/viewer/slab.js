// The slice: points outside of a slab are hidden.

/** What hides nothing. */
const NO_SLAB = { normal: [0, 0, 0], middle: 0, half: 1 };

/** View along the normal of a slab, by axis. */
const PROFILES = { x: VIEWS.right, y: VIEWS.front, z: VIEWS.top };

class Slab {
  constructor(scene, box) {
    this.scene = scene;
    this.box = box;
    this.across = "off";
    this.position = 0.5; // between the lowest and the highest point
    this.thickness = 0.35; // between one spacing and all, by factors
  }

  /** Choose what it lies across: an axis, the present view, or "off". */
  choose(across, camera) {
    this.across = across;
    this.axes = across === "view" ? camera.axes : PROFILES[across];
    // Along an axis the position rises with the coordinate, from wherever the slab is looked at.
    this.normal = across === "view" ? camera.axes[2] : ["x", "y", "z"].map((name) => Number(name === across));
  }

  get isOn() {
    return this.across !== "off";
  }

  /** Lowest and highest place of the points along its normal. */
  get range() {
    const places = boxCorners(this.box).map((corner) => dot(corner, this.normal));
    return [Math.min(...places), Math.max(...places)];
  }

  /** Normal, place of its middle along that, and half its thickness. */
  get shape() {
    if (!this.isOn) return NO_SLAB;
    const [low, high] = this.range;
    const least = this.scene.spacing;
    const most = Math.max(high - low, least);
    return {
      normal: this.normal,
      middle: low + (high - low) * this.position,
      half: 0.5 * least * (most / least) ** this.thickness * 1.001,
    };
  }

  /** Where its middle is, and how thick it is, in words. */
  get words() {
    const { middle, half } = this.shape;
    const { scene } = this;
    const axis = "xyz".indexOf(this.across);
    const place = axis < 0 ? (middle - this.range[0]) * scene.scale
      : scene.origin[axis] + scene.scale * middle;
    return [
      axis < 0 ? `${shortNumber(place)} from the back` : coordinateText(place, scene),
      shortNumber(2 * half * scene.scale),
    ];
  }
}

const isInside = (shape, place) => Math.abs(dot(shape.normal, place) - shape.middle) <= shape.half;
