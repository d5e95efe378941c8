/**
 * One picture of one mesh: where the camera is, when what is drawn, and what lies under the pointer.
 *
 * While the camera moves, a slow machine draws a coarse stand-in at a lower resolution; when it stops,
 * everything is drawn fully once and the face numbers are read back, so that pointing costs a look-up.
 */

import { atomTable } from "../labels/atom_table.js";
import { carried } from "../labels/hidden.js";
import { differences } from "../labels/painting.js";
import { NONE } from "../labels/partition.js";
import { joined } from "./area.js";
import {
  add,
  facing,
  firstDirection,
  fit,
  frame,
  fromAbove,
  mainAxis,
  orbit,
  pan,
  project,
  TANGENT,
  zoom,
} from "./camera.js";
import { between, shorterTurn } from "./flight.js";
import { boundingBall, coarse, sample, thinned } from "./geometry.js";
import { SceneRenderer } from "./renderer.js";
import { belowCeiling, boxOf, extentOf, isInside, isWhole, pointsInside, WHOLE } from "./section.js";
import { createSight } from "./sight.js";
import { faceIn, facesAround, pointIn, rayAt } from "./snapshot.js";
import { surveyOf } from "./surveys.js";
import { ownVector } from "./upright.js";
import { dolly, goTo, lookAround, lookTo, standing, standingPlace, walked } from "./walk.js";
import { facesWithin } from "./within.js";

/** @typedef {import("./camera.js").Camera} Camera */
/** @typedef {import("./camera.js").Vec3} Vec3 */
/** @typedef {import("./camera.js").Place} Place */
/** @typedef {import("../labels/atom_table.js").ColorBy} ColorBy */
/** @typedef {import("../labels/partition.js").Partition} Partition */
/** @typedef {import("./renderer.js").MeshArrays} MeshArrays */

/**
 * Of the camera, in pixels of the picture.
 * @typedef {{ kind: "orbit" | "pan", dx: number, dy: number }
 *   | { kind: "zoom", factor: number, x: number, y: number }} Movement
 */

const REST_MS = 140; // without movement for so long, the camera has stopped
const FLIGHT_MS = 280;
const BLINK_MS = 1100;
const SMOOTH_MS = 40; // a full drawing that takes longer is replaced by the coarse one while moving
const SWIFT_MS = 12; // one that takes less can be drawn twice as fine, which smooths its edges
const COARSE_FACES = 60_000; // two pixels each of a drawing while moving
const COARSE_POINTS = 120_000;
const FRAME_FACES = 20_000; // that a segment is framed by
const MOST_SMOOTH = 40e6; // pixels that are drawn twice as fine along each side
const DRAFT = 0.5; // pixels of a drawing while moving, along each side of one on the screen
const ORBIT_SPEED = 0.0075; // radians a pixel

// what has to be done again; each implies those below it
const PICTURE = 1;
const PAINT = 2;
const FACES = 3;

const COLOR_CODES = {
  segments: 0,
  parts: 0,
  confidence: 0,
  scan: 1,
  shaded: 2,
  values: 3,
  errors: 3,
  borders: 3,
  normals: 4,
};

export class Viewer {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {object} events
   * @param {() => void} events.onFirstFrame
   * @param {(error: unknown) => void} events.onFailure  nothing more will be drawn
   * @param {() => void} events.onMove  what lies under the pointer is not known for now
   * @param {() => void} events.onRest  it is known again, and may have changed
   * @param {(camera: Camera) => void} [events.onCamera]  it has been moved, by other means than `follow`
   */
  constructor(canvas, { onFirstFrame, onFailure, onMove, onRest, onCamera }) {
    this.canvas = canvas;
    this.onFirstFrame = onFirstFrame;
    this.onFailure = onFailure;
    this.onMove = onMove;
    this.onRest = onRest;
    this.onCamera = onCamera;
    this.renderer = new SceneRenderer(canvas);
    /** @type {Camera} */
    this.camera = { target: [0, 0, 0], yaw: -1, pitch: 0.7, distance: 1 };
    /** @type {Camera} */
    this.start = this.camera;
    /** Where to look from first, instead of where everything is seen best. @type {Camera | null} */
    this.first = null;
    /** @type {MeshArrays | null} */
    this.mesh = null;
    /** @type {Partition | null} */
    this.partition = null;
    /** What to keep of the scan, along the walls and upwards. */
    this.section = WHOLE;
    /** Extent of the scan along its walls and upwards. @type {import("./section.js").Box | null} */
    this.extent = null;
    /** Where one looked from before going inside. @type {Camera | null} */
    this.outside = null;
    /** What is left of the scan; null = all. @type {import("./section.js").Box | null} */
    this.box = null;
    this.size = { width: 0, height: 0 };
    /** @type {{ snapshot: import("./snapshot.js").Snapshot, sight: import("./sight.js").Sight } | null} */
    this.seen = null;
    /** @type {import("./snapshot.js").Snapshot | null} */
    this.snapshot = null;
    this.look = {
      /** @type {ColorBy} */
      colorBy: "shaded",
      mixing: 1,
      outlines: true,
      backFaces: false,
      isDark: false,
      hovered: NONE,
      picked: NONE,
      target: NONE,
    };
    /** 1 for each atom that isn't drawn. @type {Uint8Array | null} */
    this.hidden = null;
    /** What was hidden over the atoms of then, for when a preview ends. @type {{ faceAtom: Uint32Array, hidden: Uint8Array | null } | null} */
    this.chosen = null;
    this.isStill = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.needs = 0;
    /** All that is drawn by the next frame; null = the whole picture. @type {import("./area.js").Area | null} */
    this.area = null;
    this.isMoving = false;
    this.isPlaced = false;
    this.hasDrawn = false;
    this.isLost = false;
    this.isDisposed = false;
    /** Milliseconds of a full drawing; unknown until measured. @type {number | null} */
    this.cost = null;
    this.isSwift = false;
    this.drawing = 0;
    this.request = 0;
    /** What is to be done before the next frame is drawn. @type {Set<() => void>} */
    this.before = new Set();
    this.restTimer = 0;
    this.blinkTimer = 0;
    this.coarseTimer = 0;
    /** @type {{ from: Camera, to: Camera, began: number } | null} */
    this.flight = null;
    /** @type {{ place: Place, point: Vec3 } | null} */
    this.anchor = null;
  }

  /** Whether faces are points. */
  get isCloud() {
    return this.mesh?.areas != null;
  }

  /** @param {MeshArrays} mesh */
  setMesh(mesh) {
    const isOther = this.mesh !== null;
    this.mesh = mesh;
    this.sample = sample(mesh);
    this.extent = extentOf(this.sample);
    this.#send(mesh);
    this.#cut();
    if (isOther) this.isPlaced = false;
    this.#draw();
  }

  /** Give what is drawn to the context. @param {MeshArrays} mesh */
  #send(mesh) {
    this.renderer.setMesh(mesh);
    clearTimeout(this.coarseTimer);
    this.work = undefined;
  }

  /** Cut the scan open. @param {import("./section.js").Range[]} ranges  see section.js */
  setSection(ranges) {
    if (JSON.stringify(ranges) === JSON.stringify(this.section)) return;
    this.section = ranges;
    this.#cut();
    this.#changed();
  }

  #cut() {
    const box = this.extent && boxOf(this.extent, this.section);
    this.box = box;
    const { points } = this.sample ?? { points: new Float32Array(0) };
    this.points = box ? pointsInside(points, box) : points;
    this.renderer.setSection(box);
  }

  /** The section without the ceiling. */
  get openedAbove() {
    if (!this.sample || !this.extent) return WHOLE;
    const [length, width, [low]] = this.section;
    const high = belowCeiling(this.extent, this.sample);
    return [length, width, /** @type {import("./section.js").Range} */ ([Math.min(low, high - 0.1), high])];
  }

  get isCut() {
    return !isWhole(this.section);
  }

  /** Metres of the whole scan, along the walls and upwards. */
  get lengths() {
    const { low, high } = this.extent ?? { low: [0, 0, 0], high: [0, 0, 0] };
    return low.map((from, k) => high[k] - from);
  }

  /**
   * @param {Partition | null} partition
   * @param {import("./area.js").Area | null} [area]  what alone looks different; null = anything may
   */
  setPartition(partition, area = null) {
    const [before, after] = [this.partition?.faceAtom, partition?.faceAtom];
    const changed = before && after ? differences(before, after) : null;
    if (after && changed) this.renderer.changeFaceAtoms(after, changed);
    else if (before !== after) this.renderer.setFaceAtoms(after ?? null);
    const hadHidden = this.hidden !== null;
    this.hidden =
      partition && partition.faceAtom === this.chosen?.faceAtom
        ? this.chosen.hidden
        : carried(this.hidden, this.partition, partition);
    this.partition = partition;
    this.#setTable();
    if (hadHidden && !this.hidden) this.#draw(FACES);
    else this.#draw(PAINT, area);
  }

  /**
   * Leave out some atoms; null shows everything.
   * @param {((atom: number) => boolean) | null} isHidden
   */
  hide(isHidden) {
    if (!this.partition) return;
    const { atomSegment, faceAtom } = this.partition;
    const n = atomSegment.length;
    this.hidden = isHidden ? Uint8Array.from({ length: n }, (_, atom) => Number(isHidden(atom))) : null;
    this.chosen = { faceAtom, hidden: this.hidden };
    this.#setTable();
    this.#draw(FACES);
  }

  #setTable() {
    this.renderer.setHidden(this.hidden !== null);
    if (this.partition) this.renderer.setAtomTable(atomTable(this.partition, this.look.colorBy, this.hidden));
  }

  /** @param {Uint16Array} values @param {Uint8Array} colormap */
  setValues(values, colormap) {
    this.renderer.setValues(values, colormap);
    this.#draw(PAINT);
  }

  /** @param {Partial<Viewer["look"]>} changes */
  setLook(changes) {
    const before = this.look;
    this.look = { ...before, ...changes };
    if (this.look.colorBy !== before.colorBy) this.#setTable();
    if (this.look.hovered !== before.hovered || this.look.target !== before.target) this.#blink();
    const isNew = (/** @type {keyof Viewer["look"]} */ name) => this.look[name] !== before[name];
    const hasNormals = this.look.colorBy === "normals";
    if (hasNormals !== (before.colorBy === "normals")) {
      this.renderer.setNormals(hasNormals);
      this.#draw(FACES);
    } else if (isNew("backFaces")) this.#draw(FACES);
    else if (isNew("colorBy") || isNew("mixing") || isNew("isDark")) this.#draw(PAINT);
    else if (isNew("outlines") || isNew("hovered") || isNew("picked") || isNew("target")) this.#draw(PICTURE);
  }

  /** @param {number} width @param {number} height  CSS pixels */
  resize(width, height) {
    this.size = { width, height };
    this.snapshot = null; // its places were others
    if (width < 1 || height < 1) return;
    this.renderer.resize(width, height, Math.min(2, devicePixelRatio || 1));
    if (this.mesh && this.sample && !this.isPlaced) {
      this.isPlaced = true;
      this.start = this.#fitted({ ...this.camera, ...firstDirection(this.sample.normals) });
      this.camera = this.first ?? this.start;
    }
    this.#draw();
  }

  /**
   * Draw at a size of its own and without what lights up; the page shows what it did.
   * @param {{ width: number, height: number, scale: number }} size  CSS pixels, and how many pixels each is
   * @param {(canvas: HTMLCanvasElement) => void} take  has the picture until it returns
   */
  drawAt({ width, height, scale }, take) {
    if (!this.mesh || !this.isPlaced || this.isLost) throw new Error("There is no picture yet.");
    const longest = scale * Math.max(width, height);
    const most = this.renderer.mostPixels;
    if (longest > most) {
      throw new RangeError(`A picture may have ${most} pixels along a side here, not ${longest}.`);
    }
    const isSmooth = 2 * longest <= most && 4 * scale ** 2 * width * height <= MOST_SMOOTH;
    this.renderer.resize(width, height, scale);
    const { backFaces } = this.look;
    this.renderer.drawFaces(this.camera, { scale: isSmooth ? 2 : 1, isCoarse: false, backFaces });
    const look = { ...this.#currentLook(), hovered: NONE, picked: NONE, target: NONE };
    this.renderer.paint(look);
    this.renderer.drawPicture(look);
    try {
      take(this.canvas);
    } finally {
      this.renderer.resize(this.size.width, this.size.height, Math.min(2, devicePixelRatio || 1));
      this.#draw();
    }
  }

  /** Whether one stands in the room. */
  get isInside() {
    return (this.flight?.to ?? this.camera).tangent !== undefined;
  }

  /** 1 in a room in metres. */
  get #scale() {
    const height = this.lengths[2];
    return height > 1 && height < 10 ? 1 : height / 2.5;
  }

  /** Stand in the room, or go back to where one came from. @param {boolean} isInside */
  goInside(isInside) {
    if (!this.sample || !this.extent || isInside === this.isInside) return;
    if (!isInside) {
      this.#fly(this.outside ?? this.start);
      return;
    }
    this.outside = this.flight?.to ?? this.camera;
    this.#fly(standing(standingPlace(this.extent, this.sample), this.outside.yaw, 1.5 * this.#scale));
  }

  /** Go on while standing in the room. @param {Iterable<import("./walk.js").Way>} ways @param {number} seconds */
  walk(ways, seconds) {
    if (this.isInside) this.#move(walked(this.flight?.to ?? this.camera, ways, seconds, this.#scale));
  }

  /** @param {"here" | "above" | "start" | "inside"} from */
  lookFrom(from) {
    if (!this.sample) return;
    if (from === "inside") {
      this.goInside(true);
      return;
    }
    if (this.isInside) this.camera = { ...this.camera, tangent: undefined };
    if (from === "start") this.start = this.#fitted({ ...this.start });
    const camera = {
      here: this.camera,
      above: fromAbove(this.camera, mainAxis(this.sample.normals)),
      start: this.start,
    };
    this.#fly(from === "start" ? this.start : this.#fitted(camera[from]));
  }

  /** Bring the segment of a face into the middle, as large as it fits. @param {number} face */
  lookAt(face) {
    if (!this.partition || !this.mesh) return;
    const { faceAtom, atomSegment } = this.partition;
    const segment = atomSegment[faceAtom[face]];
    if (segment === NONE) return;
    const { width, height } = this.size;
    const { points } = this.#sampleOf((atom) => atomSegment[atom] === segment);
    const framed = fit(this.camera, points, width / Math.max(1, height), 0.3);
    this.#fly(this.isInside ? lookTo(this.camera, framed.target) : framed);
  }

  /** Bring the part of a face into the middle, its front to the eye, with what is around it. @param {number} face */
  lookAround(face) {
    if (!this.partition || !this.mesh) return;
    const { atomPart } = this.partition;
    const part = this.partOf(face);
    if (part === NONE) return;
    const { points, normals } = this.#sampleOf((atom) => atomPart[atom] === part);
    const { middle, radius } = boundingBall(points);
    if (this.isInside) {
      this.#fly(lookTo(this.camera, middle));
      return;
    }
    const shown = Math.min(Math.max(this.#scale, 2 * radius), this.mesh.bounds.radius);
    const aspect = this.size.width / Math.max(1, this.size.height);
    const turned = facing(this.camera, sum(normals));
    this.#fly({ ...turned, target: middle, distance: shown / (TANGENT * Math.min(1, aspect)) });
  }

  /** Some of the faces of atoms. @param {(atom: number) => boolean} isIn */
  #sampleOf(isIn) {
    const { faceAtom } = /** @type {Partition} */ (this.partition);
    const inside = [];
    for (let f = 0; f < faceAtom.length; f++) if (isIn(faceAtom[f])) inside.push(f);
    return sample(/** @type {MeshArrays} */ (this.mesh), FRAME_FACES, inside);
  }

  /** @param {Movement} action */
  apply(action) {
    const { width, height } = this.size;
    switch (action.kind) {
      case "orbit":
        if (this.isInside) {
          const angle = (2 * Math.atan(this.camera.tangent ?? TANGENT)) / Math.max(1, height);
          return this.#move(lookAround(this.camera, action.dx * angle, action.dy * angle));
        }
        return this.#move(orbit(this.camera, -action.dx * ORBIT_SPEED, action.dy * ORBIT_SPEED));
      case "pan":
        return this.#move(pan(this.camera, action.dx / height, action.dy / height));
      case "zoom": {
        if (this.isInside)
          return this.#move(dolly(this.camera, -1.5 * this.#scale * Math.log(action.factor)));
        const point = this.#anchorAt({ x: action.x ?? width / 2, y: action.y ?? height / 2 });
        const nearest = 0.01 * (this.mesh?.bounds.radius ?? 1);
        return this.#move(zoom(this.camera, action.factor, point, nearest));
      }
    }
  }

  /** Make the point at a place the one to turn around. @param {Place} place */
  recentre(place) {
    const point = this.pointAt(place);
    if (point)
      this.#fly(
        this.isInside ? goTo(this.camera, point, 0.6 * this.#scale) : { ...this.camera, target: point },
      );
  }

  /**
   * Face drawn at a place of the picture at rest; null on the background, outside, and while moving.
   * @param {Place} place  CSS pixels from the upper left
   */
  faceAt(place) {
    if (!this.snapshot || this.isMoving) return null;
    return faceIn(this.snapshot, place, this.size);
  }

  /**
   * Faces that are seen within so many pixels of a place; none while the picture moves.
   * @param {Place} place
   * @param {number} radius  CSS pixels
   */
  facesAround(place, radius) {
    if (!this.snapshot || this.isMoving) return /** @type {Set<number>} */ (new Set());
    return facesAround(this.snapshot, place, radius, this.size);
  }

  /**
   * Faces that have a pixel within an outline; none while the picture moves.
   * @param {Place[]} outline
   */
  facesWithin(outline) {
    if (!this.snapshot || this.isMoving) return /** @type {Set<number>} */ (new Set());
    return facesWithin(this.snapshot, outline, this.size);
  }

  /** Whether a face is neither hidden nor cut away. @param {number} face */
  isDrawn(face) {
    const { hidden, partition, mesh, box } = this;
    if (!mesh || (partition && hidden?.[partition.faceAtom[face]])) return false;
    return !box || isInside(mesh, face, box);
  }

  /** Faces that are neither hidden nor cut away. @returns {Generator<number>} */
  *drawnFaces() {
    const n = (this.mesh?.faces.length ?? 0) / 3;
    for (let face = 0; face < n; face++) if (this.isDrawn(face)) yield face;
  }

  /** A point or a direction in the scan's own axes. @param {Vec3} vector @returns {Vec3} */
  ownVector(vector) {
    return this.mesh ? ownVector(vector, this.mesh.axes) : vector;
  }

  /** What is seen of the scan, as it last stood still; null while it moves. */
  get sight() {
    const { snapshot, mesh, size } = this;
    if (!snapshot || !mesh || this.isMoving) return null;
    if (this.seen?.snapshot !== snapshot) this.seen = { snapshot, sight: createSight(snapshot, size, mesh) };
    return this.seen.sight;
  }

  /** Begin to look at what touches what, for tools that are about to need it. */
  prepareSurface() {
    if (this.mesh && !this.isCloud) surveyOf(this.mesh).begin();
  }

  /** What touches what on the scan. */
  get surface() {
    return this.mesh && !this.isCloud ? surveyOf(this.mesh).surface() : null;
  }

  /**
   * Face and part at a place; null where there is no part.
   * @param {Place} place
   * @returns {import("../labels/partition.js").Hit | null}
   */
  hitAt(place) {
    const face = this.faceAt(place);
    if (face === null || !this.partition) return null;
    const part = this.partition.atomPart[this.partition.faceAtom[face]];
    return part === NONE ? null : { face, part, segment: this.segmentOf(face) };
  }

  /** @param {number} face */
  partOf(face) {
    return this.partition ? this.partition.atomPart[this.partition.faceAtom[face]] : NONE;
  }

  /** A face of a segment, in its largest atom; null if it has none. @param {number} segment */
  faceOf(segment) {
    if (!this.partition) return null;
    const { faceAtom, atomSegment, atomFaces } = this.partition;
    let largest = -1;
    for (let atom = 0; atom < atomSegment.length; atom++) {
      if (atomSegment[atom] === segment && !(atomFaces[atom] <= atomFaces[largest])) largest = atom;
    }
    return largest < 0 ? null : faceAtom.indexOf(largest);
  }

  /** @param {number} face */
  segmentOf(face) {
    return this.partition ? this.partition.atomSegment[this.partition.faceAtom[face]] : NONE;
  }

  /**
   * Where a point of the surface is seen now.
   * @param {Vec3} point
   * @returns {Place | null}
   */
  placeOf(point) {
    const { width, height } = this.size;
    const seen = project(this.camera, point, width / Math.max(1, height));
    return seen && { x: ((1 + seen[0]) / 2) * width, y: ((1 - seen[1]) / 2) * height };
  }

  /** A point in the mesh's own axes as the upright picture has it. @param {Vec3} point @returns {Vec3} */
  fromOwn([x, y, z]) {
    const axes = this.mesh?.axes;
    return axes ? /** @type {Vec3} */ (axes.map(([a, b, c]) => a * x + b * y + c * z)) : [x, y, z];
  }

  /**
   * Point of the surface at a place, as the picture was when it last stood still.
   * @param {Place} place
   * @returns {Vec3 | null}
   */
  pointAt(place) {
    if (!this.snapshot || !this.mesh) return null;
    return pointIn(this.snapshot, place, this.size, this.mesh);
  }

  /**
   * Point of the surface at a place or, on the background, as far away as what the picture is about.
   * @param {Place} place
   * @returns {Vec3}
   */
  pointBefore(place) {
    const { width, height } = this.size;
    const direction = rayAt(this.camera, place, this.size, width / Math.max(1, height));
    return this.pointAt(place) ?? add(frame(this.camera).eye, direction, this.camera.distance);
  }

  /** The context is gone for now, and all that had been sent to it. */
  lose() {
    this.isLost = true;
    this.snapshot = null;
  }

  restore() {
    this.isLost = false;
    if (this.mesh) this.#send(this.mesh);
    this.renderer.setFaceAtoms(this.partition?.faceAtom ?? null);
    this.#draw();
  }

  dispose() {
    this.isDisposed = true;
    cancelAnimationFrame(this.request);
    for (const timer of [this.restTimer, this.blinkTimer, this.coarseTimer]) clearTimeout(timer);
    this.renderer.dispose();
  }

  /** @param {Camera} camera */
  #fitted(camera) {
    const { width, height } = this.size;
    return fit(camera, this.points ?? new Float32Array(0), width / Math.max(1, height));
  }

  /** Look as another view does. @param {Camera} camera */
  follow(camera) {
    this.flight = null;
    this.camera = camera;
    this.#changed();
  }

  /** @param {Camera} camera */
  #move(camera) {
    this.flight = null;
    this.camera = camera;
    this.#moved();
  }

  #moved() {
    this.onCamera?.(this.camera);
    this.#changed();
  }

  #changed() {
    this.isMoving = true;
    this.#awaitRest();
    this.#draw();
  }

  #awaitRest() {
    clearTimeout(this.restTimer);
    this.restTimer = window.setTimeout(() => {
      this.isMoving = false;
      this.anchor = null;
      this.#draw();
    }, REST_MS);
  }

  /** @param {Camera} to */
  #fly(to) {
    if (this.isStill || !this.hasDrawn) return this.#move(to);
    this.flight = { from: this.camera, to: shorterTurn(this.camera, to), began: performance.now() };
    this.#moved();
  }

  #advanceFlight() {
    if (!this.flight) return;
    const { from, to, began } = this.flight;
    const t = Math.min(1, (performance.now() - began) / FLIGHT_MS);
    this.camera = between(from, to, t);
    if (t >= 1) [this.camera, this.flight] = [to, null];
    this.#moved();
  }

  /** The point that a zoom leaves in place: kept while the pointer stays. @param {Place} place */
  #anchorAt(place) {
    const { width, height } = this.size;
    if (!this.anchor || Math.hypot(place.x - this.anchor.place.x, place.y - this.anchor.place.y) > 3) {
      const onTarget = add(
        frame(this.camera).eye,
        rayAt(this.camera, place, this.size, width / height),
        this.camera.distance,
      );
      this.anchor = { place, point: (!this.isMoving && this.pointAt(place)) || onTarget };
    }
    return this.anchor.point;
  }

  /** @param {number} [needs] @param {import("./area.js").Area | null} [area] */
  #draw(needs = FACES, area = null) {
    if (needs === FACES) this.onMove();
    this.area = this.needs === 0 ? area : joined(this.area, area);
    this.needs = Math.max(this.needs, needs);
    this.#awaitFrame();
  }

  /** Do something once, right before the next frame is drawn: what it changes is seen in that frame. @param {() => void} work */
  prepare(work) {
    this.before.add(work);
    this.#awaitFrame();
  }

  /** Don't do it any more. @param {() => void} work */
  forget(work) {
    this.before.delete(work);
  }

  #awaitFrame() {
    if (this.request) return;
    this.request = requestAnimationFrame(() => {
      try {
        this.#frame();
      } catch (error) {
        this.onFailure(error);
        throw error;
      }
    });
  }

  #frame() {
    for (const work of this.before) work();
    this.before.clear();
    this.request = 0;
    if (this.needs === 0) return;
    if (this.isDisposed || this.isLost || !this.mesh || !this.isPlaced || this.size.width < 1) return;
    this.#advanceFlight();
    const { needs, area } = this;
    this.needs = 0;
    const nFaces = this.mesh.faces.length / 3;
    const isSlow = this.cost === null ? nFaces > 6 * COARSE_FACES : this.cost > SMOOTH_MS;
    const isDraft = this.isMoving && isSlow;
    const began = performance.now();
    if (needs === FACES) {
      this.snapshot = null;
      this.drawing++;
      const { backFaces } = this.look;
      const scale = isDraft ? DRAFT : this.isSwift ? 2 : 1;
      this.renderer.drawFaces(this.camera, { scale, isCoarse: isDraft, backFaces });
    }
    const look = this.#currentLook();
    if (needs >= PAINT) this.renderer.paint(look, area);
    this.renderer.drawPicture(look, area);
    if (needs === FACES && this.isMoving) this.#awaitRest(); // a slow frame is no rest
    if (needs === FACES && !this.isMoving) this.#readNumbers(began);
    if (!this.hasDrawn) {
      this.hasDrawn = true;
      requestAnimationFrame(() => this.onFirstFrame());
    }
  }

  /** @param {number} began */
  async #readNumbers(began) {
    const [drawing, camera, aspect] = [this.drawing, this.camera, this.size.width / this.size.height];
    const isFirst = this.cost === null;
    const numbers = await this.renderer.readNumbers();
    const isOld = drawing !== this.drawing || this.needs === FACES; // drawn anew meanwhile, or about to be
    if (!numbers || this.isDisposed || this.isLost || isOld) return;
    this.snapshot = { numbers, camera, aspect };
    const cost = performance.now() - began;
    this.cost = isFirst ? Math.min(cost, SMOOTH_MS + 1) : cost; // the first time includes the transfer to the GPU
    this.onRest();
    if (this.cost > SMOOTH_MS) this.#prepareCoarse();
    if (!this.isSwift && !isFirst && cost < SWIFT_MS && (devicePixelRatio || 1) < 1.5) {
      this.isSwift = true;
      this.#draw();
    }
  }

  #prepareCoarse() {
    if (!this.mesh || this.work || this.mesh.faces.length / 3 < 2 * COARSE_FACES) return;
    if (this.mesh.areas) {
      if (!this.renderer.coarse)
        this.renderer.setCoarsePoints(thinned(this.mesh.areas.length, COARSE_POINTS));
      return;
    }
    const work = coarse(this.mesh.vertices, this.mesh.faces, COARSE_FACES);
    this.work = work;
    const proceed = () => {
      const { done, value } = work.next();
      if (done) this.renderer.setCoarse(value.faces, value.numbers);
      else this.coarseTimer = window.setTimeout(proceed, 30);
    };
    this.coarseTimer = window.setTimeout(proceed, 200);
  }

  #blink() {
    clearTimeout(this.blinkTimer);
    this.blinkBegan = performance.now();
    if (this.isStill || (this.look.hovered === NONE && this.look.target === NONE)) return;
    const tick = () => {
      this.#draw(PICTURE);
      this.blinkTimer = window.setTimeout(tick, (this.cost ?? 0) > SMOOTH_MS ? 90 : 40);
    };
    this.blinkTimer = window.setTimeout(tick, 40);
  }

  #currentLook() {
    const { colorBy, mixing, outlines, isDark, hovered, picked, target } = this.look;
    const phase = (performance.now() - (this.blinkBegan ?? 0)) / BLINK_MS;
    return {
      colorBy: /** @type {0 | 1 | 2 | 3 | 4} */ (
        colorBy === "scan" && !this.mesh?.colors ? 2 : COLOR_CODES[colorBy]
      ),
      mixing,
      outlines: outlines && ["segments", "parts", "confidence", "errors", "borders"].includes(colorBy),
      outlinesParts: colorBy === "parts",
      hovered: this.isMoving ? NONE : hovered,
      picked,
      target: this.isMoving ? NONE : target,
      pulse: this.isStill ? 0.6 : 0.5 + 0.5 * Math.cos(2 * Math.PI * phase),
      isDark,
    };
  }
}

/** Sum of vectors one after another. @param {Float32Array} vectors @returns {Vec3} */
function sum(vectors) {
  /** @type {Vec3} */
  const total = [0, 0, 0];
  for (let i = 0; i < vectors.length; i++) total[i % 3] += vectors[i];
  return total;
}
