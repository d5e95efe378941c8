/** The pieces of a model's state that a view shows, by what has to be taken anew when they change. */

const GEOMETRY = ["vertices", "faces", "vertex_colors", "areas", "normals", "up"];
const PARTITION = ["face_atom", "atom_part", "atom_segment", "segment_colors", "atom_confidence"];
const VALUES = ["face_value", "colormap", "face_error", "face_border"];
const BOXES = ["segment_box"];
const PREVIEW = [
  ...["face_item", "preview_segment", "preview_colors", "is_preview"],
  ...["face_piece", "family_merges", "family_colors"],
];

export const GROUPS = {
  geometry: arrays(GEOMETRY),
  partition: [
    ...arrays(PARTITION),
    ...arrays(PREVIEW),
    "levels",
    "level",
    "segment_names",
    "segment_groups",
    "_answers",
  ],
  values: arrays(VALUES),
  boxes: ["boxes", ...arrays(BOXES)],
  state: [
    ...["color_by", "color_mix", "errors_title", "values_legend", "outlines", "back_faces", "section"],
    ...["offers_borders", "_asks_up", "columns", "column"],
    ...["height", "segment_list", "mode", "editable", "vocabulary", "quick_names"],
    ...["busy", "progress", "status", "error", "save_state", "save_note", "notices"],
    ...["undo_title", "redo_title", "history_shown", "history", "n_done"],
  ],
};

/** @param {string[]} names */
function arrays(names) {
  return names.map((name) => `_${name}`);
}

/** What the smallest pieces of a scan are called. @param {import("./wire.js").Model} model */
export function nounOf(model) {
  return model.get("_headers")?.areas ? "point" : "face"; // only clouds say areas
}
