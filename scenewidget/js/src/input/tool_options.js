/** How the tools are set: the same for all of them on a page, kept while it is open. */

/**
 * @typedef {object} ToolOptions
 * @property {"px" | "cm"} unit  that the brush is measured in
 * @property {{ px: number, cm: number }} radius  of the brush
 * @property {boolean} sticks  whether the brush stays on the surface it began on
 * @property {boolean} takesAway  whether the brush takes faces from the segment it began on
 * @property {boolean} isThrough  whether the lasso takes what is behind as well
 * @property {boolean} isOfOne  whether it takes faces of one segment alone
 * @property {"points" | "wall"} plane  what says where a slice goes
 * @property {number} offset  of a slice in front of the wall, centimetres
 */

/** @type {ToolOptions} */
export const FIRST_OPTIONS = {
  ...{ unit: "px", radius: { px: 12, cm: 4 }, sticks: true, takesAway: false },
  ...{ isThrough: false, isOfOne: false, plane: "points", offset: 2 },
};
const LARGER = 1.25;
const OFFSET = 0.5; // centimetres
/** Smallest and largest radius. */
const LIMITS = { px: [2, 200], cm: [0.2, 200] };

/** @typedef {ReturnType<typeof createToolOptions>} Options */

/**
 * @param {object} around
 * @param {(news: { kind: "options", options: ToolOptions }) => void} around.send
 * @param {(handlers: { option: (wish: { changes: Partial<ToolOptions> }) => void }) => void} around.on
 */
export function createToolOptions({ send, on }) {
  let options = FIRST_OPTIONS;

  /** @param {Partial<ToolOptions>} changes */
  function change(changes) {
    options = { ...options, ...changes };
    send({ kind: "options", options });
  }

  on({
    option: ({ changes }) => change(changes),
  });

  return {
    /**
     * Make the brush larger or smaller by a step, or move a slice by one.
     * @param {string} tool
     * @param {1 | -1} way
     */
    resize(tool, way) {
      if (tool === "paint") change({ radius: resized(options, LARGER ** way) });
      else if (tool === "slice" && options.plane === "wall")
        change({ offset: Number((options.offset + OFFSET * way).toFixed(1)) });
    },

    get current() {
      return options;
    },
  };
}

/**
 * The radius so many times as large, in round numbers, as far as it may be.
 * @param {Pick<ToolOptions, "unit" | "radius">} options
 * @param {number} factor
 */
export function resized({ unit, radius }, factor) {
  const [least, most] = LIMITS[unit];
  const wanted = radius[unit] * factor;
  const step = wanted < 10 ? 0.1 : 1;
  const rounded = unit === "px" ? Math.round(wanted) : Number((Math.round(wanted / step) * step).toFixed(1));
  const moved = unit === "px" && rounded === radius.px ? rounded + Math.sign(factor - 1) : rounded;
  return { ...radius, [unit]: Math.min(most, Math.max(least, moved)) };
}
