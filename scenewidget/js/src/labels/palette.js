/**
 * Colours of parts, of which there may be thousands: far apart for numbers that are near each other.
 *
 * Segments bring their colours from Python, which knows what touches what. Parts get theirs from their
 * number alone: hues a golden angle apart (Oklch; Ottosson, 2020), on four rings of lightness.
 */

const GOLDEN_ANGLE = Math.PI * (3 - Math.sqrt(5));
const RINGS = [
  [0.8, 0.09],
  [0.62, 0.13],
  [0.72, 0.125],
  [0.54, 0.12],
];

/**
 * One number of three bytes, red lowest.
 * @param {number} red
 * @param {number} green
 * @param {number} blue
 */
export function packColor(red, green, blue) {
  return red | (green << 8) | (blue << 16);
}

/**
 * Colour of a part, always the same for the same number.
 * @param {number} number
 */
export function hashedColor(number) {
  const [lightness, chroma] = RINGS[number % RINGS.length];
  const [red, green, blue] = oklch(lightness, chroma, number * GOLDEN_ANGLE);
  return packColor(red, green, blue);
}

/**
 * sRGB bytes of an Oklch colour, cut off where the screen can't show it.
 * @param {number} lightness  0 to 1
 * @param {number} chroma
 * @param {number} hue  radians
 * @returns {[number, number, number]}
 */
export function oklch(lightness, chroma, hue) {
  return oklab(lightness, chroma * Math.cos(hue), chroma * Math.sin(hue));
}

/**
 * sRGB bytes of an Oklab colour, cut off where the screen can't show it.
 * @param {number} lightness  0 to 1
 * @param {number} a
 * @param {number} b
 * @returns {[number, number, number]}
 */
export function oklab(lightness, a, b) {
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    encode(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    encode(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    encode(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

/** @param {number} linear */
function encode(linear) {
  const value = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));
}
