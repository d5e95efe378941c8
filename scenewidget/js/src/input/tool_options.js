/** How the tools are set: the same for all of them on a page, kept while it is open. */

/**
 * @typedef {object} ToolOptions
 * @property {"px" | "cm"} unit  that the brush is measured in
 * @property {{ px: number, cm: number }} radius  of the brush
 * @property {boolean} sticks  whether the brush stays on the surface it began on
 * @property {boolean} takesAway  whether the brush takes faces from the segment it began on
 */

/** @type {ToolOptions} */
export const FIRST_OPTIONS = { unit: "px", radius: { px: 12, cm: 4 }, sticks: true, takesAway: false };
const LARGER = 1.25;
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
    /** Make the brush larger or smaller by a step. @param {1 | -1} way */
    resize: (way) => change({ radius: resized(options, LARGER ** way) }),

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
