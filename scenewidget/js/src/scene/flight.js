/** From one camera to another in a fraction of a second, so that one sees where one goes. */

import { add, subtract, TANGENT } from "./camera.js";

/** @typedef {import("./camera.js").Camera} Camera */

/**
 * The same camera as another, reached by the shorter turn.
 * @param {Camera} from
 * @param {Camera} to
 * @returns {Camera}
 */
export function shorterTurn(from, to) {
  return { ...to, yaw: to.yaw + Math.round((from.yaw - to.yaw) / (2 * Math.PI)) * 2 * Math.PI };
}

/**
 * The camera on its way, slow at both ends; nearer and farther by equal factors in equal times.
 * @param {Camera} from
 * @param {Camera} to
 * @param {number} t  0 to 1
 * @returns {Camera}
 */
export function between(from, to, t) {
  const s = t * t * (3 - 2 * t);
  const mix = (/** @type {number} */ a, /** @type {number} */ b) => a + s * (b - a);
  return {
    target: add(from.target, subtract(to.target, from.target), s),
    yaw: mix(from.yaw, to.yaw),
    pitch: mix(from.pitch, to.pitch),
    distance: from.distance * (to.distance / from.distance) ** s,
    tangent: mix(from.tangent ?? TANGENT, to.tangent ?? TANGENT),
  };
}
