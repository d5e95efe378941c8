/** Where one looks from and what is hidden, remembered in the model for pages that open or are saved later. */

import { facesOf } from "../labels/hidden.js";

/**
 * @param {object} around
 * @param {import("../wire/wire.js").Model} around.model
 * @param {import("./viewer.js").Viewer} around.view
 * @param {(message: { kind: "set", name: string, value: unknown }) => void} around.send
 */
export function createKeptLooks({ model, view, send }) {
  const set = (/** @type {string} */ name, /** @type {unknown} */ value) =>
    send({ kind: "set", name, value });
  /** What is hidden, as far as the model knows it. @type {Uint8Array | null | undefined} */
  let told;
  return {
    keepCamera() {
      const isKept = JSON.stringify(view.camera) === JSON.stringify(model.get("_camera"));
      if (view.camera !== view.start && !isKept) set("_camera", view.camera);
    },

    /** Hide what was hidden last, then remember what is. */
    keepHidden() {
      const { partition } = view;
      if (!partition) return;
      if (told === undefined) {
        const faces = /** @type {number[]} */ (model.get("_hidden") ?? []);
        const atoms = new Set(faces.map((face) => partition.faceAtom[face]));
        if (atoms.size > 0) view.hide((atom) => atoms.has(atom));
      } else if (told !== view.hidden) set("_hidden", facesOf(view.hidden, partition.faceAtom));
      told = view.hidden;
    },
  };
}
