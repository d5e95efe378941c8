/**
 * What crosses between Python and the browser: named arrays of a model.
 *
 * An array `x` is two pieces of state, the bytes `_x` and its entry in `_headers`. Hosts deliver bytes as
 * DataView, typed array, ArrayBuffer or base64, and not always in the same instant as the header.
 */

/** @typedef {"float32" | "int8" | "uint8" | "uint16" | "uint32"} Dtype */
/** @typedef {{ dtype: Dtype, shape: number[] }} Header */
/** @typedef {Float32Array | Int8Array | Uint8Array | Uint16Array | Uint32Array} TypedArray */

/**
 * The part of an anywidget model that is used here.
 * @typedef {object} Model
 * @property {(name: string) => any} get
 * @property {(name: string, value: unknown) => void} set
 * @property {() => void} save_changes
 * @property {(content: object) => void} send
 * @property {(event: string, callback: (...args: any[]) => void) => void} on
 * @property {(event: string, callback: (...args: any[]) => void) => void} off
 * @property {any} [widget_manager]  of Jupyter
 */

const ARRAYS = {
  float32: Float32Array,
  int8: Int8Array,
  uint8: Uint8Array,
  uint16: Uint16Array,
  uint32: Uint32Array,
};

/**
 * A typed view of one array sent from Python; copies only if the bytes don't start at a multiple of the item size.
 * @param {Header} header
 * @param {DataView | ArrayBufferView | ArrayBuffer | string} bytes
 * @returns {TypedArray}
 */
export function viewArray({ dtype, shape }, bytes) {
  const Kind = ARRAYS[dtype];
  if (!Kind) throw new TypeError(`unknown dtype ${dtype}`);
  const { buffer, byteOffset, byteLength } = asBytes(bytes);
  const length = lengthOf({ shape });
  if (byteLength !== length * Kind.BYTES_PER_ELEMENT) {
    throw new RangeError(
      `${dtype} array of shape [${shape}] needs ${length * Kind.BYTES_PER_ELEMENT} bytes, got ${byteLength}`,
    );
  }
  if (byteOffset % Kind.BYTES_PER_ELEMENT === 0) return new Kind(buffer, byteOffset, length);
  return new Kind(buffer.slice(byteOffset, byteOffset + byteLength));
}

/** @param {{ shape: number[] }} header */
function lengthOf({ shape }) {
  return shape.reduce((product, n) => product * n, 1);
}

/** The same bytes give the same array, so that arrays can be told apart by identity. @type {WeakMap<object, TypedArray>} */
const views = new WeakMap();

/**
 * An array of the model; null if it is empty, or if bytes and header don't belong together (yet).
 * @param {Model} model
 * @param {string} name
 */
export function readArray(model, name) {
  const header = model.get("_headers")?.[name];
  const bytes = model.get(`_${name}`);
  if (!header || !bytes) return null;
  const known = typeof bytes === "string" ? undefined : views.get(bytes);
  if (
    known &&
    known.constructor === ARRAYS[/** @type {Header} */ (header).dtype] &&
    known.length === lengthOf(header)
  )
    return known;
  try {
    const array = viewArray(header, bytes);
    if (array.length === 0) return null;
    if (typeof bytes !== "string") views.set(bytes, array);
    return array;
  } catch (error) {
    if (error instanceof RangeError) return null;
    throw error;
  }
}

/**
 * Where bytes are, in whatever form a host delivers them.
 * @param {DataView | ArrayBufferView | ArrayBuffer | string} bytes
 * @returns {{ buffer: ArrayBuffer, byteOffset: number, byteLength: number }}
 */
export function asBytes(bytes) {
  if (typeof bytes === "string") {
    const text = atob(bytes);
    const array = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) array[i] = text.charCodeAt(i);
    return array;
  }
  if (bytes instanceof ArrayBuffer) return { buffer: bytes, byteOffset: 0, byteLength: bytes.byteLength };
  return /** @type {any} */ (bytes);
}
