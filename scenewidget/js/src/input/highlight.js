/** What lights up in the picture, out of what is pointed at and what is in hand. */

import { NONE } from "../labels/partition.js";

/** @typedef {import("./gestures.js").Gesture} Gesture */
/** @typedef {import("./gestures.js").Hit} Hit */

/**
 * @typedef {object} Situation
 * @property {Gesture} gesture
 * @property {import("./gestures.js").Tool} tool
 * @property {number | null} face  that is pointed at, here or in a linked view
 * @property {number | null} listed  segment that the list points at
 * @property {{ face: number, onto: number } | null} suggested
 * @property {number | null} offcut  segment that a cut would divide off
 */

/**
 * @typedef {object} Surface
 * @property {(face: number) => number} partOf
 * @property {(face: number) => number} segmentOf
 * @property {(face: number, onto: number) => boolean} isTarget  whether a merge would do anything
 */

/** What the next place is chosen for. @param {Gesture} gesture @returns {Hit | null} */
export function heldOf({ phase, from, picked, stroke }) {
  return phase === "link" ? from : (stroke?.onto ?? picked);
}

/** Whether a first point of a cut is in hand. @param {Pick<Situation, "gesture" | "tool">} situation */
export function isCutting({ gesture, tool }) {
  return tool === "cut" && !gesture.stroke && heldOf(gesture) !== null;
}

/**
 * Parts and segments to light up, NONE where there is nothing.
 * @param {Situation} situation
 * @param {Surface} surface
 * @returns {{ hovered: number, picked: number, target: number, joined: number }}  joined: the segment that a
 *   release here would merge with
 */
export function highlightOf(
  { gesture, tool, face, listed, suggested, offcut },
  { partOf, segmentOf, isTarget },
) {
  const held = heldOf(gesture);
  const isMerge = held && face !== null && tool === "merge" && !gesture.stroke;
  const joined = isMerge && isTarget(held.face, face) ? segmentOf(face) : NONE;
  const isCut = isCutting({ gesture, tool });
  const divided = isCut && held ? (offcut ?? held.segment) : joined;
  const lit = face === null && listed !== null ? listed : divided;
  const offered = suggested && !held ? partOf(suggested.face) : NONE;
  const goal = suggested && !held && suggested.onto >= 0 ? segmentOf(suggested.onto) : NONE;
  return {
    hovered: held || face === null || gesture.phase === "paint" ? NONE : partOf(face), // what is painted is seen
    picked: isCut ? NONE : held ? held.part : offered,
    target: lit === NONE ? goal : lit,
    joined,
  };
}
