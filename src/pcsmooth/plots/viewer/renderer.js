// Draws points into a picture with depths, in as many steps as it takes, and shows it.

/**
 * Diameter of a point in units of the spacing, that in the plane where two clouds lie in one picture,
 * least pixels of it and most, by dimension.
 */
const OVERLAPS = { 2: 0.8, 3: 2.2 };
const LEAST_PIXELS = { 2: 3, 3: 1.3 };
const MOST_PIXELS = 60;

/** How much larger points may be drawn while only some of them are. */
const MOST_LARGER = 4;

/** Depths are averaged over so many diameters, and pixels at least, for the shadow in hollows. */
const SHADOW = 2;
const LEAST_SHADOW = 5;

/** Places around a pixel that are looked at for it: with all points, and with some. */
const PLACES = 16;
const FEW_PLACES = 5;

class Renderer {
  /** Throws an error, in words for the user, where the browser cannot draw. */
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.scene = scene;
    const options = { antialias: false, alpha: false, powerPreference: "high-performance" };
    const gl = canvas.getContext("webgl2", options);
    if (!gl) {
      throw new Error(
        "This browser does not draw in 3D (WebGL 2 is missing or switched off). Switch on " +
          "hardware acceleration, or open the page in another browser.",
      );
    }
    canvas.addEventListener("webglcontextlost", () => {
      tell("The browser has given up drawing. Load the page again.");
    });
    this.gl = gl;
    this.most = gl.getParameter(gl.ALIASED_POINT_SIZE_RANGE)[1];
    this.points = program(gl, POINT_VERTEX, POINT_FRAGMENT);
    this.shadow = program(gl, SHADOW_VERTEX, SHADOW_FRAGMENT);
    this.nothing = gl.createVertexArray();
    this.maps = scene.maps.map((shades) => shadesTexture(gl, shades));
    this.arrays = new Map(scene.sets.map((set) => [set, this.arrayOf(set)]));
    this.buffers = new Map();
    this.target = null;
  }

  arrayOf(set) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const [before, after] = set.ends.map((end) => staticBuffer(gl, end));
    this.attribute("before", before, 3, gl.FLOAT);
    this.attribute("after", after, 3, gl.FLOAT);
    if (set.normals[0]) {
      const [first, last] = set.normals.map((normals) => staticBuffer(gl, normals));
      this.attribute("normalBefore", first, 2, gl.UNSIGNED_BYTE);
      this.attribute("normalAfter", last, 2, gl.UNSIGNED_BYTE);
    }
    gl.bindVertexArray(null);
    return array;
  }

  attribute(name, buffer, size, type) {
    const { gl } = this;
    const place = gl.getAttribLocation(this.points.handle, name);
    if (place < 0) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, type, false, 0, 0);
  }

  /** Use these values of a set, as `Scene.valuesOf` gives them. */
  setValues(set, values) {
    const { gl } = this;
    gl.bindVertexArray(this.arrays.get(set));
    ["valueBefore", "valueAfter"].forEach((name, k) => {
      if (!this.buffers.has(values[k])) {
        this.buffers.set(values[k], staticBuffer(gl, values[k]));
      }
      this.attribute(name, this.buffers.get(values[k]), 1, gl.HALF_FLOAT);
    });
    gl.bindVertexArray(null);
  }

  /** Begin a picture of what `picture` says; nothing is drawn yet. */
  begin(picture) {
    const { gl } = this;
    const { width, height } = picture;
    if (!this.target || this.target.width !== width || this.target.height !== height) {
      this.target = newTarget(gl, width, height, this.target);
    }
    this.picture = picture;
    this.drawn = 0;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target.frame);
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  get isComplete() {
    return this.drawn >= this.largest;
  }

  /** Points of the largest layer. */
  get largest() {
    return Math.max(...this.picture.panels.flatMap(({ layers }) => layers.map((l) => l.set.count)));
  }

  /** Layers that the points are drawn in. */
  get passes() {
    return this.picture.panels.reduce((sum, panel) => sum + panel.layers.length, 0);
  }

  diameter(panel) {
    const { scene, picture } = this;
    const pixels = picture.camera.scale(panel) * picture.ratio;
    const overlap = panel.layers.length > 1 ? OVERLAPS[2] : OVERLAPS[scene.dimension];
    const natural = overlap * scene.spacing * pixels;
    const least = LEAST_PIXELS[scene.dimension] * picture.ratio;
    return Math.min(this.most, MOST_PIXELS * picture.ratio, Math.max(least, natural) * picture.size);
  }

  /** Draw the next points of each layer. */
  draw(count, larger = 1) {
    const { gl, picture, scene } = this;
    const { camera, slab, column } = picture;
    const set = (name, ...numbers) => this.points.set(name, ...numbers);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target.frame);
    gl.useProgram(this.points.handle);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    const columnwise = [0, 1, 2].flatMap((k) => camera.axes.map((axis) => axis[k]));
    gl.uniformMatrix3fv(this.points.place("axes"), false, columnwise);
    set("center", ...camera.center);
    set("slabNormal", ...slab.normal);
    set("slab", slab.middle, slab.half);
    this.points.setNumber("isLit", scene.dimension === 3 ? 1 : 0);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.maps[column && column.is_signed ? 1 : 0]);
    this.points.setNumber("shades", 0);
    if (column && "axis" in column) {
      const [low, high] = column.limits.map((value) => (value - scene.origin[column.axis]) / scene.scale);
      set("valueAxis", ...[0, 1, 2].map((k) => (k === column.axis ? 1 : 0)));
      set("valueScale", (low + high) / 2, 2 / (high - low));
    }
    for (const panel of picture.panels) {
      const [x, y, width, height] = pixelsOf(panel, picture);
      gl.viewport(x, y, width, height);
      set("halfSize", (camera.halfHeight * width) / height, camera.halfHeight);
      set("diameter", Math.min(this.most, this.diameter(panel) * clamp(larger, 1, MOST_LARGER)));
      for (const layer of panel.layers) {
        const number = Math.min(count, layer.set.count - this.drawn);
        if (number <= 0) continue;
        set("share", layer.share);
        set("tint", ...(layer.tint || picture.plain));
        this.points.setNumber(
          "coloring", layer.tint ? 3 : !column ? 0 : "axis" in column ? 2 : 1,
        );
        gl.bindVertexArray(this.arrays.get(layer.set));
        gl.drawArrays(gl.POINTS, this.drawn, number);
      }
    }
    gl.bindVertexArray(null);
    this.drawn += count;
  }

  /** Wait until all is drawn. */
  finish() {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  /** Show the picture, with shadows. */
  present() {
    const { gl, picture, canvas, target } = this;
    resize(canvas, picture.width, picture.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.useProgram(this.shadow.handle);
    gl.disable(gl.DEPTH_TEST);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(...picture.paper, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.SCISSOR_TEST);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, target.colors);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, target.depths);
    this.shadow.setNumber("colors", 0);
    this.shadow.setNumber("depths", 1);
    this.shadow.setNumber("isLit", this.scene.dimension === 3 ? 1 : 0);
    this.shadow.setNumber("places", this.isComplete ? PLACES : FEW_PLACES);
    this.shadow.set("paper", ...picture.paper);
    gl.bindVertexArray(this.nothing);
    for (const panel of picture.panels) {
      const [x, y, width, height] = pixelsOf(panel, picture);
      gl.scissor(x, y, width, height);
      gl.uniform4i(this.shadow.place("panel"), x, y, x + width, y + height);
      this.shadow.set("pixel", 1 / (picture.camera.scale(panel) * picture.ratio));
      this.shadow.set("around", Math.max(LEAST_SHADOW * picture.ratio, SHADOW * this.diameter(panel)));
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.bindVertexArray(null);
  }
}

/** Give a canvas a size in pixels; it is emptied if it had another. */
function resize(canvas, width, height) {
  if (canvas.width !== width || canvas.height !== height) {
    [canvas.width, canvas.height] = [width, height];
  }
}

/** Left, bottom, width and height of a panel in pixels of the device. */
function pixelsOf(panel, { ratio, height }) {
  const [left, right] = [panel.x, panel.x + panel.width].map((x) => Math.round(x * ratio));
  const [top, bottom] = [panel.y, panel.y + panel.height].map((y) => Math.round(y * ratio));
  return [left, height - bottom, right - left, bottom - top];
}

function program(gl, vertex, fragment) {
  const handle = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(handle, shader);
  }
  gl.linkProgram(handle);
  if (!gl.getProgramParameter(handle, gl.LINK_STATUS)) {
    throw new Error(`This browser cannot draw the points: ${gl.getProgramInfoLog(handle)}`);
  }
  const places = new Map();
  const place = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(handle, name));
    return places.get(name);
  };
  return {
    handle,
    place,
    set: (name, ...numbers) => gl[`uniform${numbers.length}f`](place(name), ...numbers),
    setNumber: (name, number) => gl.uniform1i(place(name), number),
  };
}

function staticBuffer(gl, data) {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
  return buffer;
}

function texture(gl, format, width, height, kind, type, data) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, kind, type, data);
  for (const name of ["MIN_FILTER", "MAG_FILTER"]) {
    gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}`], gl.NEAREST);
  }
  for (const name of ["S", "T"]) {
    gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_WRAP_${name}`], gl.CLAMP_TO_EDGE);
  }
  return made;
}

function shadesTexture(gl, shades) {
  const bytes = Uint8Array.from(shades.flatMap((shade) => [...shade, 255]));
  return texture(gl, gl.RGBA8, shades.length, 1, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
}

function newTarget(gl, width, height, old) {
  if (old) {
    gl.deleteTexture(old.colors);
    gl.deleteTexture(old.depths);
    gl.deleteFramebuffer(old.frame);
  }
  const frame = gl.createFramebuffer();
  const colors = texture(gl, gl.RGBA8, width, height, gl.RGBA, gl.UNSIGNED_BYTE, null);
  const depths = texture(
    gl, gl.DEPTH_COMPONENT24, width, height, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null,
  );
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colors, 0);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, depths, 0);
  return { width, height, frame, colors, depths };
}
