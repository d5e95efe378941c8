/** The legend as part of a picture that is saved. */

/** @typedef {import("./legend.js").Legend} Legend */

const MARGIN = 10;
const [PAD, LINE, BAR_WIDTH, BAR_HEIGHT, SWATCH] = [8, 17, 160, 8, 10];
const COLUMNS = 3;
const FONT = "12px system-ui, sans-serif";
const INK = { light: "#2b2e33", dark: "#e6e8eb" };
const PAPER = { light: "rgb(255 255 255 / 88%)", dark: "rgb(34 37 43 / 88%)" };

/**
 * Into the lower right corner.
 * @param {CanvasRenderingContext2D} context
 * @param {Legend} legend
 * @param {{ width: number, height: number, scale: number }} size
 * @param {"light" | "dark"} theme
 */
export function drawLegend(context, legend, { width, height, scale }, theme) {
  const { title, colors, ends, samples = [] } = legend;
  context.save();
  context.scale(scale, scale);
  context.font = FONT;
  context.textBaseline = "middle";
  const column = SWATCH + 16 + Math.max(0, ...samples.map(([, name]) => context.measureText(name).width));
  const columns = Math.min(COLUMNS, samples.length);
  const inner = Math.max(context.measureText(title).width, colors ? BAR_WIDTH : columns * column);
  const rows = 1 + (colors ? 2 : Math.ceil(samples.length / COLUMNS));
  const [w, h] = [inner + 2 * PAD, rows * LINE + 2 * PAD - 4];
  context.translate(width - MARGIN - w, height - MARGIN - h);
  context.fillStyle = PAPER[theme];
  context.fillRect(0, 0, w, h);
  const text = (/** @type {string} */ words, /** @type {number} */ x, /** @type {number} */ row) => {
    context.fillStyle = INK[theme];
    context.fillText(words, x, PAD + (row + 0.4) * LINE);
  };
  text(title, PAD, 0);
  if (colors) {
    const gradient = context.createLinearGradient(PAD, 0, PAD + inner, 0);
    colors.forEach((color, i) => {
      gradient.addColorStop(i / Math.max(1, colors.length - 1), color);
    });
    context.fillStyle = gradient;
    context.fillRect(PAD, PAD + LINE + 2, inner, BAR_HEIGHT);
    const [low, high] = ends ?? ["", ""];
    text(low, PAD, 2);
    text(high, PAD + inner - context.measureText(high).width, 2);
  }
  samples.forEach(([color, name], i) => {
    const x = PAD + (i % COLUMNS) * column;
    const row = 1 + Math.floor(i / COLUMNS);
    context.fillStyle = color;
    context.fillRect(x, PAD + (row + 0.4) * LINE - SWATCH / 2, SWATCH, SWATCH);
    text(name, x + SWATCH + 6, row);
  });
  context.restore();
}
