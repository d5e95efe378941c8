/** Faces within an outline in the picture. */

/** @typedef {import("./camera.js").Place} Place */

/**
 * Whether a place lies within an outline; where the outline crosses itself, even and odd parts alternate.
 * @param {Place[]} outline
 * @param {number} x
 * @param {number} y
 */
export function isWithin(outline, x, y) {
  let isIn = false;
  for (let i = 0, j = outline.length - 1; i < outline.length; j = i++) {
    const a = outline[i];
    const b = outline[j];
    if (a.y > y !== b.y > y && x < a.x + ((y - a.y) / (b.y - a.y)) * (b.x - a.x)) isIn = !isIn;
  }
  return isIn;
}

/**
 * Faces that have a pixel within an outline.
 * @param {import("./snapshot.js").Snapshot} snapshot
 * @param {Place[]} outline
 * @param {import("./snapshot.js").Size} size
 * @returns {Set<number>}
 */
export function facesWithin({ numbers: { width, height, bytes } }, outline, size) {
  const [toX, toY] = [width / size.width, height / size.height];
  /** @type {Set<number>} */
  const faces = new Set();
  const ys = outline.map(({ y }) => y * toY);
  const last = Math.min(height - 1, Math.floor(Math.max(...ys)));
  for (let line = Math.max(0, Math.floor(Math.min(...ys))); line <= last; line++) {
    const ends = crossings(outline, (line + 0.5) / toY);
    for (let k = 0; k + 1 < ends.length; k += 2) {
      const end = Math.min(width - 1, Math.ceil(ends[k + 1] * toX - 0.5) - 1);
      for (let column = Math.max(0, Math.ceil(ends[k] * toX - 0.5)); column <= end; column++) {
        const i = 4 * ((height - 1 - line) * width + column);
        const number = bytes[i] | (bytes[i + 1] << 8) | (bytes[i + 2] << 16);
        if (number > 0) faces.add(number - 1);
      }
    }
  }
  return faces;
}

/** Where an outline crosses a horizontal line, from left to right. @param {Place[]} outline @param {number} y */
function crossings(outline, y) {
  const xs = [];
  for (let i = 0, j = outline.length - 1; i < outline.length; j = i++) {
    const [a, b] = [outline[i], outline[j]];
    if (a.y > y !== b.y > y) xs.push(a.x + ((y - a.y) / (b.y - a.y)) * (b.x - a.x));
  }
  return xs.sort((a, b) => a - b);
}
