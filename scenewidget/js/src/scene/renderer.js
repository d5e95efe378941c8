/**
 * All that touches WebGL: a mesh into a buffer of face numbers, that buffer into a picture.
 *
 * The mesh is drawn when the camera, the size or the mesh changes (`drawFaces`); other labels and colours need
 * a full-screen pass (`paint`), other highlights a smaller one (`drawPicture`), whatever the size of the mesh.
 */

import {
  BufferAttribute,
  BufferGeometry,
  DataTexture,
  DepthTexture,
  DoubleSide,
  FrontSide,
  GLSL3,
  Matrix3,
  Matrix4,
  Mesh,
  NearestFilter,
  NoBlending,
  Points,
  RawShaderMaterial,
  RedIntegerFormat,
  RGBAFormat,
  RGBAIntegerFormat,
  RGIntegerFormat,
  Scene,
  Camera as ThreeCamera,
  UnsignedByteType,
  UnsignedIntType,
  UnsignedShortType,
  Vector2,
  Vector3,
  WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { NONE } from "../labels/partition.js";
import { scissor } from "./area.js";
import { frame, projectionView, TANGENT } from "./camera.js";
import { drawable, gather } from "./geometry.js";
import {
  FACES_FRAGMENT,
  FACES_VERTEX,
  PAINT_FRAGMENT,
  PICTURE_FRAGMENT,
  RELIEF_FRAGMENT,
  SCREEN_VERTEX,
} from "./shaders.js";

/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Ball} Ball */
/** @typedef {{ width: number, height: number, bytes: Uint8Array }} Numbers  face number + 1 in three bytes a pixel */

/**
 * @typedef {object} MeshArrays
 * @property {Float32Array} vertices
 * @property {Uint32Array} faces
 * @property {Int8Array} normals  rows of four; of points the last tells whether their side is known
 * @property {Float32Array | null} areas  of the points of a cloud, which are its faces; null for a mesh
 * @property {Uint8Array | null} colors  rows of three
 * @property {Ball} bounds
 * @property {import("./upright.js").Vec3Axes | null} axes  of the upright room in the mesh's own; null: the same
 */

/**
 * @typedef {object} Look
 * @property {0 | 1 | 2 | 3 | 4} colorBy  table of atoms, scan, plain, values, normals
 * @property {number} mixing
 * @property {boolean} outlines
 * @property {boolean} outlinesParts
 * @property {number} hovered  part, or NONE
 * @property {number} picked  part, or NONE
 * @property {number} target  segment, or NONE
 * @property {number} pulse  0 to 1
 * @property {boolean} isDark
 */

const TEXTURE_WIDTH = 2048;
const FENCE_MS = 8;
const OVERLAP = 10; // areas that the disc of a point covers: of points strewn by chance, e⁻¹⁰ of the places are bare

export class SceneRenderer {
  /**
   * @param {HTMLCanvasElement} canvas
   * @throws {Error} if the browser has no WebGL2
   */
  constructor(canvas) {
    const options = {
      ...{ alpha: true, antialias: false, depth: false, stencil: false, premultipliedAlpha: true },
      preserveDrawingBuffer: true, // or what prints and copies is empty
    };
    const context = canvas.getContext("webgl2", { ...options, powerPreference: "high-performance" });
    if (!context) throw new Error("This browser offers no WebGL 2.");
    this.gl = context;
    this.three = new WebGLRenderer({ canvas, context, ...options });
    this.three.autoClear = false;
    this.three.sortObjects = false; // there is one; to sort it, its bounds would be sought
    this.three.setClearColor(0x000000, 0);
    this.camera = new ThreeCamera();
    this.faces = facesMaterial();
    this.relief = screenMaterial(RELIEF_FRAGMENT, {
      depth: null,
      near: 0,
      far: 1,
      size: 1,
      reach: 1,
    });
    this.picture = screenMaterial(PICTURE_FRAGMENT, {
      painted: null,
      keys: null,
      hasOutlines: true,
      outlinesParts: false,
      accent: new Vector3(),
      scale: 1,
      width: 1,
      last: new Vector2(),
      pulse: 0,
      hovered: NONE,
      picked: NONE,
      target: NONE,
    });
    this.paints = screenMaterial(PAINT_FRAGMENT, {
      numbers: null,
      scan: null,
      relief: null,
      colormap: bytesTexture(new Uint8Array(4), 1, 1),
      faceAtom: integerTexture(new Uint32Array(1), 1),
      atoms: integerTexture(new Uint32Array([NONE, NONE, 0, 0]), 4),
      faceValue: integerTexture(new Uint16Array(1), 1),
      colorBy: 2,
      hasScan: false,
      hasPartition: false,
      mixing: 1,
      plain: new Vector3(),
      unlabeled: new Vector3(),
    });
    this.meshScene = new Scene();
    this.reliefScene = screenScene(this.relief);
    this.paintScene = screenScene(this.paints);
    this.pictureScene = screenScene(this.picture);
    /** @type {Mesh | Points | null} */
    this.fine = null;
    /** @type {Mesh | Points | null} */
    this.coarse = null;
    /** @type {MeshArrays | null} */
    this.arrays = null;
    this.size = { width: 1, height: 1, ratio: 1 };
    /** @type {WebGLRenderTarget | null} */
    this.numbers = null;
    this.reliefTarget = new WebGLRenderTarget(1, 1, { depthBuffer: false, ...nearest() });
    this.painted = new WebGLRenderTarget(1, 1, { count: 2, depthBuffer: false, ...nearest() });
    Object.assign(this.painted.textures[1], {
      format: RGIntegerFormat,
      type: UnsignedIntType,
      internalFormat: "RG32UI",
    });
  }

  /** @param {MeshArrays} arrays */
  setMesh(arrays) {
    this.arrays = arrays;
    this.#define("HAS_COLORS", arrays.colors !== null);
    this.#define("IS_CLOUD", arrays.areas !== null);
    for (const old of [this.fine, this.coarse]) {
      old?.geometry.dispose();
      old?.removeFromParent();
    }
    this.coarse = null;
    this.#uniform("hasScan", arrays.colors !== null);
    this.fine = arrays.areas ? this.#addPoints(null) : this.#add(arrays.faces);
    this.numbers?.dispose();
    this.numbers = null;
  }

  /**
   * The stand-in to draw while the camera moves.
   * @param {Uint32Array} faces
   * @param {Uint32Array} numbers
   */
  setCoarse(faces, numbers) {
    this.coarse = this.#add(faces, numbers);
  }

  /** The points to draw, larger, while the camera moves. @param {Uint32Array} numbers */
  setCoarsePoints(numbers) {
    this.coarse = this.#addPoints(numbers);
  }

  /** @param {Uint32Array | null} faceAtom */
  setFaceAtoms(faceAtom) {
    this.#uniform("hasPartition", faceAtom !== null);
    const texture = integerTexture(faceAtom ?? new Uint32Array(1), 1);
    texture.onUpdate = () => {
      texture.image.data = /** @type {any} */ (null); // it has been sent, and whoever gave it has it
    };
    this.#texture("faceAtom", texture);
  }

  /**
   * Other atoms of some faces, without sending those of all the others.
   * @param {Uint32Array} faceAtom
   * @param {number[]} ranges
   */
  changeFaceAtoms(faceAtom, ranges) {
    const texture = /** @type {DataTexture} */ (this.paints.uniforms.faceAtom.value);
    const { gl, three } = this;
    const known = /** @type {any} */ (three.properties.get(texture)).__webglTexture;
    if (!known) return this.setFaceAtoms(faceAtom); // the one before hasn't been sent yet
    const { width } = texture.image;
    /** @type {Set<number>} */
    const rows = new Set();
    for (let i = 0; i < ranges.length; i += 2)
      for (let row = Math.floor(ranges[i] / width); row * width < ranges[i + 1]; row++) rows.add(row);
    three.state.bindTexture(gl.TEXTURE_2D, known);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const send = (/** @type {number} */ row, /** @type {number} */ columns, /** @type {number} */ n) => {
      const part = faceAtom.subarray(row * width, row * width + columns * n);
      const place = /** @type {const} */ ([gl.TEXTURE_2D, 0, 0, row, columns, n]);
      gl.texSubImage2D(...place, gl.RED_INTEGER, gl.UNSIGNED_INT, part);
    };
    const nFull = Math.floor(faceAtom.length / width);
    for (const [first, end] of runs(rows)) {
      if (first < nFull) send(first, width, Math.min(end, nFull) - first);
      if (end > nFull) send(nFull, faceAtom.length - nFull * width, 1);
    }
  }

  /** @param {Uint32Array} table  four numbers an atom, see partition.js */
  setAtomTable(table) {
    this.#texture("atoms", integerTexture(table, 4));
  }

  /** Whether the table of atoms hides any. @param {boolean} hasHidden */
  setHidden(hasHidden) {
    this.#define("HAS_HIDDEN", hasHidden);
  }

  /** What lies in a box alone is drawn; null = everything. @param {import("./section.js").Box | null} box */
  setSection(box) {
    this.#define("HAS_SECTION", box !== null);
    if (!box) return;
    const { boxAxes, boxLow, boxHigh } = this.faces.uniforms;
    const [x, y, z] = box.axes;
    boxAxes.value.set(...x, ...y, ...z);
    boxLow.value.set(...box.low);
    boxHigh.value.set(...box.high);
  }

  /** Whether the faces' normals are drawn, in the place of the scan's colours. @param {boolean} hasNormals */
  setNormals(hasNormals) {
    this.#define("HAS_NORMALS", hasNormals);
  }

  /**
   * @param {Uint16Array} values  0 = none, else 1 to 65535 along the colour map
   * @param {Uint8Array} colormap  256 rows of three
   */
  setValues(values, colormap) {
    const rows = new Uint8Array(4 * 256).fill(255);
    for (let i = 0; i < 256; i++) rows.set(colormap.subarray(3 * i, 3 * i + 3), 4 * i);
    this.#texture("faceValue", integerTexture(values, 1));
    this.#texture("colormap", bytesTexture(rows, 256, 1));
  }

  /**
   * @param {number} width  CSS pixels
   * @param {number} height
   * @param {number} ratio  device pixels a CSS pixel
   */
  resize(width, height, ratio) {
    this.size = {
      width: Math.max(1, Math.round(width * ratio)),
      height: Math.max(1, Math.round(height * ratio)),
      ratio,
    };
    this.three.setSize(this.size.width, this.size.height, false);
  }

  /** Pixels that a picture may have along a side. */
  get mostPixels() {
    const { gl } = this;
    return Math.min(gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), ...gl.getParameter(gl.MAX_VIEWPORT_DIMS));
  }

  /**
   * Pass 1: number and light of the face at each pixel.
   * @param {Camera} camera
   * @param {object} quality
   * @param {number} quality.scale  1 = as fine as the screen
   * @param {boolean} quality.isCoarse
   * @param {boolean} quality.backFaces
   */
  drawFaces(camera, { scale, isCoarse, backFaces }) {
    if (!this.arrays || !this.fine) return;
    const width = Math.max(1, Math.round(this.size.width * scale));
    const height = Math.max(1, Math.round(this.size.height * scale));
    const target = this.#numbersTarget(width, height);
    const { bounds } = this.arrays;
    const { matrix, near, far } = projectionView(camera, width / height, bounds);
    const { eye, right, up, forward } = frame(camera);
    const uniforms = this.faces.uniforms;
    uniforms.projectionView.value.fromArray(matrix);
    uniforms.right.value.set(...right);
    uniforms.up.value.set(...up);
    uniforms.forward.value.set(...forward);
    uniforms.eye.value.set(...eye);
    uniforms.depths.value.set(near, far);
    uniforms.window.value.set(width, height);
    uniforms.tangent.value = camera.tangent ?? TANGENT;
    uniforms.showsBacks.value = backFaces;
    this.faces.side = backFaces ? DoubleSide : FrontSide;
    this.fine.visible = !(isCoarse && this.coarse);
    if (this.coarse) this.coarse.visible = !this.fine.visible;
    this.three.setRenderTarget(target);
    this.three.clear();
    this.three.render(this.meshScene, this.camera);
    this.relief.uniforms.near.value = near;
    this.relief.uniforms.far.value = far;
    this.relief.uniforms.size.value = bounds.radius;
    this.relief.uniforms.reach.value = Math.max(1, this.size.ratio * scale);
    this.relief.uniforms.depth.value = target.depthTexture;
    if (isCoarse !== "IS_DRAFT" in this.relief.defines) {
      this.relief.defines = isCoarse ? { IS_DRAFT: 1 } : {};
      this.relief.needsUpdate = true;
    }
    this.three.setRenderTarget(this.reliefTarget);
    this.three.render(this.reliefScene, this.camera);
    this.#uniform("numbers", target.textures[0]);
    this.#uniform("scan", target.textures[target.textures.length - 1]);
    this.#uniform("relief", this.reliefTarget.texture);
    this.picture.uniforms.scale.value = width / this.size.width;
    const isSmooth = scale > 1;
    if (isSmooth !== "IS_SMOOTH" in this.picture.defines) {
      this.picture.defines = isSmooth ? { IS_SMOOTH: 1 } : {};
      this.picture.needsUpdate = true;
    }
    this.picture.uniforms.width.value = Math.max(1, Math.round(this.size.ratio * scale));
    this.picture.uniforms.last.value.set(width - 1, height - 1);
  }

  /**
   * Pass 2: from faces to segments, parts and colours.
   * @param {Look} look
   * @param {import("./area.js").Area | null} [area]  all that is drawn; the rest stays as it was
   */
  paint(look, area = null) {
    if (!this.numbers) return;
    this.#uniform("colorBy", look.colorBy);
    this.#uniform("mixing", look.mixing);
    this.paints.uniforms.plain.value.set(...(look.isDark ? [0.78, 0.78, 0.77] : [0.86, 0.855, 0.84]));
    this.paints.uniforms.unlabeled.value.set(...(look.isDark ? [0.5, 0.51, 0.53] : [0.7, 0.7, 0.71]));
    this.painted.setSize(this.numbers.width, this.numbers.height);
    const scale = this.size.ratio * this.picture.uniforms.scale.value;
    this.painted.scissorTest = area !== null;
    if (area) this.painted.scissor.set(...scissor(area, scale, this.numbers));
    this.three.setRenderTarget(this.painted);
    this.three.render(this.paintScene, this.camera);
    this.picture.uniforms.painted.value = this.painted.textures[0];
    this.picture.uniforms.keys.value = this.painted.textures[1];
  }

  /**
   * Pass 3: onto the screen, with outlines and highlights.
   * @param {Look} look
   * @param {import("./area.js").Area | null} [area]  all that is drawn; the rest stays as it was
   */
  drawPicture(look, area = null) {
    if (!this.numbers) return;
    this.picture.uniforms.hasOutlines.value = look.outlines;
    this.picture.uniforms.outlinesParts.value = look.outlinesParts;
    this.picture.uniforms.accent.value.set(...(look.isDark ? [0.49, 0.69, 1] : [0.1, 0.36, 0.85]));
    this.picture.uniforms.target.value = look.target;
    this.picture.uniforms.hovered.value = look.hovered;
    this.picture.uniforms.picked.value = look.picked;
    this.picture.uniforms.pulse.value = look.pulse;
    if (area) this.three.setScissor(...scissor(area, this.size.ratio, this.size));
    this.three.setScissorTest(area !== null);
    this.three.setRenderTarget(null);
    this.three.clear();
    this.three.render(this.pictureScene, this.camera);
    this.three.setScissorTest(false);
  }

  /**
   * Face numbers of the last `drawFaces`, without making the page wait for them: asked too early, WebGL lets
   * everything wait until all is drawn, so ask for the state of a fence only.
   * @returns {Promise<Numbers | null>}  null if the context was lost meanwhile
   */
  async readNumbers() {
    const { gl, numbers } = this;
    if (!numbers) return null;
    const { width, height } = numbers;
    const bytes = new Uint8Array(4 * width * height);
    const buffer = gl.createBuffer();
    this.three.setRenderTarget(numbers);
    gl.readBuffer(gl.COLOR_ATTACHMENT0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, bytes.byteLength, gl.STREAM_READ);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    this.three.setRenderTarget(null);
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    if (!fence) return null;
    while (!gl.isContextLost() && gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) {
      await new Promise((resolve) => setTimeout(resolve, FENCE_MS));
    }
    if (gl.isContextLost()) return null;
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, bytes);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.deleteBuffer(buffer);
    gl.deleteSync(fence);
    return { width, height, bytes };
  }

  /** Give everything back, the context too: browsers allow about sixteen. */
  dispose() {
    for (const mesh of [this.fine, this.coarse]) mesh?.geometry.dispose();
    for (const { value } of Object.values(this.paints.uniforms)) value?.isTexture && value.dispose();
    for (const thing of [this.faces, this.relief, this.paints, this.picture]) thing.dispose();
    for (const target of [this.numbers, this.reliefTarget, this.painted]) target?.dispose();
    this.three.dispose();
    this.three.forceContextLoss();
  }

  /**
   * @param {Uint32Array} faces
   * @param {Uint32Array} [numbers]
   */
  #add(faces, numbers) {
    const { vertices, normals, colors } = /** @type {MeshArrays} */ (this.arrays);
    const { corner, face, index } = drawable(faces, vertices.length / 3, numbers);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", attribute(gather(vertices, 3, corner), 3));
    geometry.setAttribute("normal", attribute(gather(normals, 4, corner), 4));
    geometry.setAttribute("face", attribute(face, 1));
    if (colors) geometry.setAttribute("color", attribute(gather(colors, 3, corner, 4), 4));
    geometry.setIndex(attribute(index, 1));
    const mesh = new Mesh(geometry, this.faces);
    mesh.frustumCulled = false;
    this.meshScene.add(mesh);
    return mesh;
  }

  /**
   * Discs that reach so far that no hole is seen between them.
   * @param {Uint32Array | null} numbers  of some points, which then stand for all; null = all of them
   */
  #addPoints(numbers) {
    const { vertices, normals, colors, areas } = /** @type {MeshArrays} */ (this.arrays);
    const n = /** @type {Float32Array} */ (areas).length;
    const face = numbers ?? Uint32Array.from({ length: n }, (_, i) => i);
    const larger = (OVERLAP * n) / Math.max(1, face.length) / Math.PI;
    const reach = Float32Array.from(face, (i) => Math.sqrt(larger * /** @type {Float32Array} */ (areas)[i]));
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", attribute(numbers ? gather(vertices, 3, face) : vertices, 3));
    geometry.setAttribute("normal", attribute(numbers ? gather(normals, 4, face) : normals, 4));
    geometry.setAttribute("reach", attribute(reach, 1));
    geometry.setAttribute("face", attribute(face, 1));
    if (colors) geometry.setAttribute("color", attribute(gather(colors, 3, face, 4), 4));
    const points = new Points(geometry, this.faces);
    points.frustumCulled = false;
    this.meshScene.add(points);
    return points;
  }

  /**
   * @param {number} width
   * @param {number} height
   */
  #numbersTarget(width, height) {
    const count = this.arrays?.colors || "HAS_NORMALS" in this.faces.defines ? 2 : 1;
    if (this.numbers?.textures.length !== count) {
      this.numbers?.dispose();
      this.numbers = new WebGLRenderTarget(width, height, { count, depthBuffer: true, ...nearest() });
      this.numbers.depthTexture = new DepthTexture(width, height, UnsignedIntType);
    }
    this.numbers.setSize(width, height);
    this.reliefTarget.setSize(width, height);
    return this.numbers;
  }

  /** Choose a variant of the first shader. @param {string} name @param {boolean} isOn */
  #define(name, isOn) {
    if (isOn === name in this.faces.defines) return;
    const { [name]: _, ...defines } = this.faces.defines;
    this.faces.defines = isOn ? { ...defines, [name]: 1 } : defines;
    this.faces.needsUpdate = true;
  }

  /** @param {string} name @param {unknown} value */
  #uniform(name, value) {
    this.paints.uniforms[name].value = value;
  }

  /** @param {string} name @param {DataTexture} texture */
  #texture(name, texture) {
    this.paints.uniforms[name].value?.dispose();
    this.#uniform(name, texture);
    if (name in this.faces.uniforms) this.faces.uniforms[name].value = texture;
  }
}

/**
 * Numbers that the page forgets once they have been sent to where they are drawn; bytes are shares of the largest.
 * @param {Float32Array | Uint32Array | Int8Array | Uint8Array} array
 * @param {number} width  items a corner
 */
function attribute(array, width) {
  const isShare = array.BYTES_PER_ELEMENT === 1;
  return new BufferAttribute(array, width, isShare).onUpload(forget);
}

/** @this {BufferAttribute} */
function forget() {
  this.array = new /** @type {any} */ (this.array.constructor)(0);
}

function facesMaterial() {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: FACES_VERTEX,
    fragmentShader: FACES_FRAGMENT,
    defines: {},
    blending: NoBlending,
    uniforms: {
      projectionView: { value: new Matrix4() },
      right: { value: new Vector3() },
      up: { value: new Vector3() },
      forward: { value: new Vector3() },
      eye: { value: new Vector3() },
      depths: { value: new Vector2() },
      window: { value: new Vector2() },
      tangent: { value: 1 },
      showsBacks: { value: false },
      faceAtom: { value: null },
      atoms: { value: null },
      boxAxes: { value: new Matrix3() },
      boxLow: { value: new Vector3() },
      boxHigh: { value: new Vector3() },
    },
  });
}

/**
 * @param {string} fragmentShader
 * @param {Record<string, unknown>} values
 */
function screenMaterial(fragmentShader, values) {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: SCREEN_VERTEX,
    fragmentShader,
    defines: {},
    blending: NoBlending,
    depthTest: false,
    depthWrite: false,
    uniforms: Object.fromEntries(Object.entries(values).map(([name, value]) => [name, { value }])),
  });
}

/** @param {RawShaderMaterial} material */
function screenScene(material) {
  const geometry = new BufferGeometry();
  geometry.setAttribute(
    "position",
    new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3),
  );
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  const scene = new Scene();
  scene.add(mesh);
  return scene;
}

/** Rows that follow each other, from the first to after the last. @param {Iterable<number>} rows */
function runs(rows) {
  /** @type {Array<[first: number, end: number]>} */
  const found = [];
  for (const row of [...rows].sort((a, b) => a - b)) {
    const last = found[found.length - 1];
    if (last && row <= last[1]) last[1] = row + 1;
    else found.push([row, row + 1]);
  }
  return found;
}

/**
 * Numbers to look up by position, `width` of them a texel.
 * @param {Uint32Array | Uint16Array} numbers
 * @param {1 | 4} width
 */
function integerTexture(numbers, width) {
  const nTexels = numbers.length / width;
  const columns = Math.min(TEXTURE_WIDTH, Math.max(1, nTexels));
  const rows = Math.max(1, Math.ceil(nTexels / columns));
  const Kind = /** @type {any} */ (numbers.constructor);
  const padded = new Kind(columns * rows * width);
  padded.set(numbers);
  const isShort = numbers instanceof Uint16Array;
  const texture = new DataTexture(
    padded,
    columns,
    rows,
    width === 1 ? RedIntegerFormat : RGBAIntegerFormat,
    isShort ? UnsignedShortType : UnsignedIntType,
  );
  texture.internalFormat = width === 4 ? "RGBA32UI" : isShort ? "R16UI" : "R32UI";
  return uploaded(texture);
}

/**
 * @param {Uint8Array} bytes
 * @param {number} width
 * @param {number} height
 */
function bytesTexture(bytes, width, height) {
  return uploaded(new DataTexture(bytes, width, height, RGBAFormat, UnsignedByteType));
}

/** @param {DataTexture} texture */
function uploaded(texture) {
  Object.assign(texture, nearest(), { unpackAlignment: 1, needsUpdate: true });
  return texture;
}

function nearest() {
  return { minFilter: NearestFilter, magFilter: NearestFilter, generateMipmaps: false };
}
