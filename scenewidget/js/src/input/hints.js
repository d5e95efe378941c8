/** What can be done next with what is in hand, in words. */

import { counted, segmentTitle } from "../labels/description.js";

/** @typedef {import("./gestures.js").Hit} Hit */

const PAINT = "Paint: drag inside a segment to draw a new one, or out of it to add to it";

/**
 * @param {object} hand
 * @param {import("./gestures.js").Gesture} hand.gesture
 * @param {import("./gestures.js").Tool} hand.tool
 * @param {string | null} [hand.drawingHint]  of a tool that draws
 * @param {object} segments
 * @param {(hit: Hit) => string} segments.titleOf
 * @param {Record<string, string>} segments.names
 * @param {Record<string, number>} segments.groups
 * @param {{ nFaces: number } | null} segments.offcut  that a click would divide off
 * @param {string} segments.noun  what faces are called
 * @param {boolean} isSought  whether Python looks for a cut
 * @returns {{ text: string | null, of: "part" | "stroke" | "hint", isGrouped?: boolean }}  of a part or a whole
 */
export function hintOf({ gesture, tool, drawingHint = null }, segments, isSought) {
  const { picked, stroke } = gesture;
  if (stroke) {
    const n = stroke.gathered.length;
    const what = n === 0 ? "gather parts for" : `${n} ${n === 1 ? "part" : "parts"} onto`;
    return { text: `Brush: ${what} ${segments.titleOf(stroke.onto)}`, of: "stroke" };
  }
  if (drawingHint !== null) return { text: drawingHint, of: "hint" };
  if (tool === "cut") return { text: cutHint(picked, segments, isSought), of: "hint" };
  if (tool === "paint") return { text: PAINT, of: "hint" };
  if (tool === "brush") return { text: "Brush: drag over parts to gather them onto the first", of: "hint" };
  const text = picked && `${segments.titleOf(picked)}: click what to merge it with`;
  const { groups } = segments;
  const isGrouped =
    picked !== null && (picked.segment in groups || Object.values(groups).includes(picked.segment));
  return { text, of: "part", isGrouped };
}

/**
 * @param {Hit | null} picked  the first point
 * @param {{ names: Record<string, string>, offcut: { nFaces: number } | null, noun: string }} segments
 * @param {boolean} isSought
 */
function cutHint(picked, { names, offcut, noun }, isSought) {
  if (!picked) return "Cut: click or drag from one side of a segment to the other";
  const title = segmentTitle(picked.segment, names);
  if (isSought) return `${title}: looking for the cut…`;
  if (offcut) return `${title}: a click here cuts ${counted(offcut.nFaces, noun)} off`;
  return `${title}: click the other side of the cut`;
}
