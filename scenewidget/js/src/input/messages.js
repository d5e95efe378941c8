/**
 * What is said between the parts of one view.
 *
 * Wishes are what people want, whether by key, button or pointer: one part fulfils each. News are heard by
 * whoever cares. Who says something doesn't know who hears it, so a new button or a new tool is one more
 * kind of message, and nothing else changes.
 */

/** @typedef {import("./gestures.js").Place} Place */
/** @typedef {import("./gestures.js").Tool} Tool */
/** @typedef {import("./keys.js").PartAction} PartAction */
/** @typedef {import("../labels/prediction.js").Edit} Edit */
/** @typedef {import("../scene/camera.js").Vec3} Vec3 */

/**
 * Beside those that have keys:
 *
 * - act: on the segment or part under a face; `place` is where a form may open
 * - act_on_picked, act_on_segment: the same to what is picked, or to a row of the list
 * - edit: show an edit at once and tell Python of it
 * - name: the segment under a face, as was typed
 * - set: a piece of the model's state
 * - cut_ceiling: of the section
 * - let_go: of what is in hand; back: of that or, if there is nothing, of the tool
 * - group: what the brush has gathered
 * - choose_segment: what a click on its row in the list does
 * - option: of a tool is to be set
 * - refine: the picked segment; refine_preview: show what that would change, null = no longer
 * - take_box: what the section shows becomes a segment
 * - answer: a button of a notice was pressed
 * - cancel: the computation
 * - draw: the picture, at a size of its own, for `take` to copy; throws where that can't be
 * @typedef {import("./keys.js").Command
 *   | { kind: "zoom", factor: number, x: number, y: number }
 *   | { kind: "act", what: PartAction, face: number, place: Place | null }
 *   | { kind: "act_on_picked", what: PartAction }
 *   | { kind: "act_on_segment", what: PartAction, segment: number }
 *   | { kind: "edit", edit: Edit }
 *   | { kind: "name", face: number, name: string }
 *   | { kind: "set", name: string, value: unknown }
 *   | { kind: "cut_ceiling" | "let_go" | "back" | "group" | "cancel" }
 *   | { kind: "go_to", n: number }
 *   | { kind: "draw", width: number, height: number, scale: number, take: (canvas: HTMLCanvasElement) => void }
 *   | { kind: "choose_segment", segment: number }
 *   | { kind: "refine", how: import("../labels/prediction.js").Refinement }
 *   | { kind: "refine_preview", how: import("../labels/prediction.js").Refinement | null }
 *   | { kind: "take_box" }
 *   | { kind: "option", changes: Partial<import("./tool_options.js").ToolOptions> }
 *   | { kind: "answer", notice: string, action: string }} Wish
 */

/**
 * - moving, rested: whether what lies under the pointer is known; moved: the camera, by this view's own doing
 * - lost, restored: the graphics context
 * - segments: they are to be read again; state: only what is said about them; hidden: what is drawn
 * - hand: what is in hand, or on what, has changed; tool_taken: another tool; options: of the tools
 * - pointed: the pointer is on another face; twin_pointed: that of a linked view
 * - listed: the list points at a segment; suggested: an edit is, onto −1 = off what it is part of
 * - cut_sought: Python begins or ends to look for a cut
 *
 * To be shown beside the picture: remark (for a moment), hover (of what is pointed at), hint (of what can be
 * done next), line (from what is in hand to the pointer), outline (what a tool draws), boxes (of the segments), ring (the round brush), twin (where a linked view points), cross (where keys
 * act), marked (a row of the list), ask_name (the form).
 * @typedef {{ kind: "moving" | "rested" | "lost" | "restored" | "segments" | "state" | "hidden" | "hand" | "cut_sought" }
 *   | { kind: "moved", camera: import("../scene/camera.js").Camera }
 *   | { kind: "tool_taken", tool: Tool }
 *   | { kind: "options", options: import("./tool_options.js").ToolOptions }
 *   | { kind: "pointed", face: number | null, at: Vec3 | null }
 *   | { kind: "twin_pointed", face: number | null }
 *   | { kind: "listed", segment: number | null }
 *   | { kind: "suggested", edit: { face: number, onto: number } | null }
 *   | { kind: "remark", text: string }
 *   | { kind: "hover", words: { text: string, color: string | null } | null }
 *   | { kind: "hint", text: string | null, of: "part" | "stroke" | "hint" }
 *   | { kind: "line", from: Place | null, to: Place | null, isHeld: boolean }
 *   | { kind: "outline", places: Place[], isClosed: boolean, hasDots: boolean, label: string }
 *   | { kind: "boxes", boxes: import("../scene/boxes.js").BoxLines[] }
 *   | { kind: "ring", place: Place | null, radius: number }
 *   | { kind: "twin", place: Place | null }
 *   | { kind: "cross", isShown: boolean }
 *   | { kind: "marked", segment: number | null }
 *   | { kind: "ask_name", face: number, title: string, name: string, place: Place }} News
 */

/** @typedef {Wish | News} Message */
/** @typedef {(message: Message) => void} Send */
/** @typedef {(handlers: import("../wire/dispatcher.js").Handlers<Message>) => void} On */

/**
 * What most parts of a view work with.
 * @typedef {object} Around
 * @property {import("../wire/wire.js").Model} model
 * @property {import("../scene/viewer.js").Viewer} view
 * @property {import("../labels/shown_segments.js").ShownSegments} segments
 * @property {HTMLElement} root
 * @property {Send} send
 * @property {On} on
 * @property {AbortSignal} signal  ends everything
 */

export {};
