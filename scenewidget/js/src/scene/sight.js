/**
 * What is seen of a scan, down to faces that are smaller than a pixel and so have none of their own.
 *
 * The picture at rest says which face each pixel shows. A face without a pixel is seen if its middle lies in the
 * plane of the face that its pixel shows, within about a pixel, and faces the eye from the same side.
 */

import { widen } from "./area.js";
import { frame, TANGENT } from "./camera.js";

/** @typedef {ReturnType<typeof createSight>} Sight */

/**
 * @param {import("./snapshot.js").Snapshot} snapshot
 * @param {import("./snapshot.js").Size} size
 * @param {import("./geometry.js").Surface} mesh
 */
export function createSight({ numbers, camera, aspect }, size, mesh) {
  const { vertices, faces, areas = null, normals } = mesh;
  const { eye, right, up, forward } = frame(camera);
  const { tangent = TANGENT } = camera;
  const { width, height, bytes } = numbers;
  /** Of the face looked at last: its middle, and where it is seen. */
  const last = {
    face: -1,
    x: 0,
    y: 0,
    depth: 0,
    middle: /** @type {[number, number, number]} */ ([0, 0, 0]),
  };

  /** @param {number} face */
  function look(face) {
    if (last.face === face) return;
    last.face = face;
    const { middle } = last;
    for (let k = 0; k < 3; k++) {
      middle[k] =
        (vertices[3 * faces[3 * face] + k] +
          vertices[3 * faces[3 * face + 1] + k] +
          vertices[3 * faces[3 * face + 2] + k]) /
        3;
    }
    const [x, y, z] = [middle[0] - eye[0], middle[1] - eye[1], middle[2] - eye[2]];
    last.depth = x * forward[0] + y * forward[1] + z * forward[2];
    const half = last.depth * tangent;
    last.x = (0.5 + (x * right[0] + y * right[1] + z * right[2]) / (2 * half * aspect)) * size.width;
    last.y = (0.5 - (x * up[0] + y * up[1] + z * up[2]) / (2 * half)) * size.height;
  }

  /** Normal of a face times twice its area. @param {number} face */
  function normalOf(face) {
    if (areas && normals) return [0, 1, 2].map((k) => (normals[4 * face + k] / 63.5) * areas[face]);
    const [a, b, c] = [3 * faces[3 * face], 3 * faces[3 * face + 1], 3 * faces[3 * face + 2]];
    const [ux, uy, uz] = [
      vertices[b] - vertices[a],
      vertices[b + 1] - vertices[a + 1],
      vertices[b + 2] - vertices[a + 2],
    ];
    const [vx, vy, vz] = [
      vertices[c] - vertices[a],
      vertices[c + 1] - vertices[a + 1],
      vertices[c + 2] - vertices[a + 2],
    ];
    return [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
  }

  /** The face that the pixel of the face looked at last shows, −1 where there is none. */
  function shownThere() {
    const column = Math.floor((last.x / size.width) * width);
    const row = height - 1 - Math.floor((last.y / size.height) * height);
    if (!(last.depth > 0 && column >= 0 && column < width && row >= 0 && row < height)) return -1;
    const i = 4 * (row * width + column);
    return (bytes[i] | (bytes[i + 1] << 8) | (bytes[i + 2] << 16)) - 1;
  }

  return {
    /** Metres that a CSS pixel is wide at some point. @param {ArrayLike<number>} point */
    pixelAt(point) {
      let depth = 0;
      for (let k = 0; k < 3; k++) depth += (point[k] - eye[k]) * forward[k];
      return (2 * Math.max(depth, 0) * tangent) / size.height;
    },

    /** Where the middle of a face would be seen, CSS pixels; behind the eye it isn't a number. @param {number} face */
    placeOf(face) {
      look(face);
      return last.depth > 0 ? { x: last.x, y: last.y } : { x: Number.NaN, y: Number.NaN };
    },

    /**
     * Let an area hold the corners of a face as they would be seen; one behind the eye may be anywhere.
     * @param {import("./area.js").Area} area
     * @param {number} face
     */
    widen(area, face) {
      for (let corner = 3 * face; corner < 3 * face + 3; corner++) {
        const v = 3 * faces[corner];
        const [x, y, z] = [vertices[v] - eye[0], vertices[v + 1] - eye[1], vertices[v + 2] - eye[2]];
        const half = (x * forward[0] + y * forward[1] + z * forward[2]) * tangent;
        if (half > 0) {
          const across = (x * right[0] + y * right[1] + z * right[2]) / (2 * half * aspect);
          const upwards = (x * up[0] + y * up[1] + z * up[2]) / (2 * half);
          widen(area, { x: (0.5 + across) * size.width, y: (0.5 - upwards) * size.height });
        } else {
          widen(area, { x: 0, y: 0 });
          widen(area, { x: size.width, y: size.height });
        }
      }
    },

    /** Square of the distance of a face's middle from a point. @param {number} face @param {ArrayLike<number>} point */
    awayFrom(face, point) {
      look(face);
      const { middle } = last;
      return (middle[0] - point[0]) ** 2 + (middle[1] - point[1]) ** 2 + (middle[2] - point[2]) ** 2;
    },

    /** @param {number} face */
    isSeen(face) {
      look(face);
      const shown = shownThere();
      if (shown < 0 || shown === face) return shown === face;
      const { middle } = last;
      const [own, other] = [normalOf(face), normalOf(shown)];
      const a = 3 * faces[3 * shown];
      let [facesEye, facedEye, away, length] = [0, 0, 0, 0];
      for (let k = 0; k < 3; k++) {
        facesEye += own[k] * (eye[k] - middle[k]);
        facedEye += other[k] * (eye[k] - vertices[a + k]);
        away += other[k] * (middle[k] - vertices[a + k]);
        length += other[k] * other[k];
      }
      if (facesEye * facedEye < 0) return false;
      const pixel = (2 * last.depth * tangent) / height;
      const extent = Math.sqrt(Math.sqrt(own[0] ** 2 + own[1] ** 2 + own[2] ** 2)); // of the face itself
      return Math.abs(away) <= (1.5 * pixel + 0.5 * extent) * Math.sqrt(length);
    },
  };
}
