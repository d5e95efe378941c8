/** As much of a page as the front end's modules need to run in Node: a tree of elements, events, focus. */

/** What attributes give to properties, and back. */
const REFLECTED = ["hidden", "type", "min", "max", "step", "value", "id", "disabled", "title"];
const FLAGS = ["hidden", "disabled"];

class PageNode {
  constructor() {
    /** @type {PageElement | null} */
    this.parentElement = null;
  }

  remove() {
    const { parentElement } = this;
    if (parentElement) parentElement.childNodes = parentElement.childNodes.filter((node) => node !== this);
    this.parentElement = null;
  }
}

class PageText extends PageNode {
  /** @param {string} text */
  constructor(text) {
    super();
    this.textContent = text;
  }
}

export class PageElement extends PageNode {
  /** @param {string} tag */
  constructor(tag) {
    super();
    this.localName = tag;
    /** @type {PageNode[]} */
    this.childNodes = [];
    /** @type {Map<string, string>} */
    this.attributes = new Map();
    /** @type {Map<string, Array<(event: any) => void>>} */
    this.listeners = new Map();
    /** @type {Record<string, any>} */
    this.style = {
      setProperty: (/** @type {string} */ name, /** @type {string} */ value) => this.#style(name, value),
    };
    this.dataset = new Proxy(/** @type {Record<string, string>} */ ({}), {
      get: (_, name) => this.attributes.get(`data-${dashed(String(name))}`),
      set: (_, name, value) =>
        this.attributes.set(`data-${dashed(String(name))}`, String(value)) !== undefined,
      deleteProperty: (_, name) => this.attributes.delete(`data-${dashed(String(name))}`) || true,
    });
    this.scrollTop = this.offsetTop = this.offsetHeight = this.offsetWidth = 0;
    this.clientHeight = this.clientWidth = 0;
  }

  /** @param {string} name @param {string} value */
  #style(name, value) {
    this.style[name] = value;
  }

  get children() {
    return /** @type {PageElement[]} */ (this.childNodes.filter((node) => node instanceof PageElement));
  }
  get rows() {
    return this.children;
  }
  get options() {
    return this.children;
  }
  /** @returns {PageElement | null} */
  get tHead() {
    return this.children.find(({ localName }) => localName === "thead") ?? null;
  }

  /** @returns {string} */
  get textContent() {
    return this.childNodes.map((node) => /** @type {any} */ (node).textContent).join("");
  }
  set textContent(text) {
    this.replaceChildren(...(text === "" ? [] : [String(text)]));
  }

  get tabIndex() {
    return Number(this.attributes.get("tabindex") ?? 0);
  }
  set tabIndex(index) {
    this.attributes.set("tabindex", String(index));
  }

  get className() {
    return this.attributes.get("class") ?? "";
  }
  get classList() {
    const classes = () => this.className.split(" ").filter(Boolean);
    const set = (/** @type {string[]} */ names) => this.attributes.set("class", names.join(" "));
    return {
      contains: (/** @type {string} */ name) => classes().includes(name),
      add: (/** @type {string} */ name) => set([...new Set([...classes(), name])]),
      remove: (/** @type {string} */ name) => set(classes().filter((other) => other !== name)),
      toggle: (/** @type {string} */ name, /** @type {boolean} */ isOn) =>
        set([...classes().filter((other) => other !== name), ...(isOn ? [name] : [])]),
    };
  }

  /** @param {string} name */
  getAttribute(name) {
    return this.attributes.get(name) ?? null;
  }
  /** @param {string} name @param {string} value */
  setAttribute(name, value) {
    this.attributes.set(name, String(value));
  }
  /** @param {string} name */
  removeAttribute(name) {
    this.attributes.delete(name);
  }

  /** @param {...(PageNode | string)} nodes */
  append(...nodes) {
    for (const node of nodes) this.#insert(node, this.childNodes.length);
  }
  /** @param {...(PageNode | string)} nodes */
  prepend(...nodes) {
    nodes.forEach((node, i) => {
      this.#insert(node, i);
    });
  }
  /** @param {...(PageNode | string)} nodes */
  replaceChildren(...nodes) {
    for (const node of this.childNodes) node.parentElement = null;
    this.childNodes = [];
    this.append(...nodes);
  }
  /** @param {PageNode | string} node @param {number} at */
  #insert(node, at) {
    const child = typeof node === "string" ? new PageText(node) : node;
    child.remove();
    child.parentElement = this;
    this.childNodes.splice(at, 0, child);
  }

  /** @param {unknown} other */
  contains(other) {
    for (let node = /** @type {any} */ (other); node; node = node.parentElement)
      if (node === this) return true;
    return false;
  }
  getRootNode() {
    return globalThis.document;
  }
  getBoundingClientRect() {
    const { clientWidth: width, clientHeight: height } = this;
    return { left: 0, top: 0, width, height };
  }

  /** @param {string} selectors  tags, classes and attributes; no combinations */
  matches(selectors) {
    return selectors.split(",").some((selector) => this.#is(selector.trim()));
  }
  /** @param {string} selector */
  #is(selector) {
    if (selector.startsWith(":")) return globalThis.document.activeElement === /** @type {any} */ (this);
    if (selector.startsWith(".")) return this.classList.contains(selector.slice(1));
    if (selector.startsWith("[")) return this.attributes.has(selector.slice(1, -1));
    return this.localName === selector;
  }
  /** @param {string} selectors @returns {PageElement | null} */
  closest(selectors) {
    return this.matches(selectors) ? this : (this.parentElement?.closest(selectors) ?? null);
  }
  /** @param {string} selectors @returns {PageElement[]} */
  querySelectorAll(selectors) {
    return this.children.flatMap((child) => [
      ...(child.matches(selectors) ? [child] : []),
      ...child.querySelectorAll(selectors),
    ]);
  }
  /** @param {string} selectors */
  querySelector(selectors) {
    return this.querySelectorAll(selectors)[0] ?? null;
  }

  focus() {
    const { document } = /** @type {any} */ (globalThis);
    const before = document.activeElement;
    document.activeElement = this;
    if (before instanceof PageElement && before !== this) fire(before, "focusout");
  }
  select() {}
  setPointerCapture() {}

  /** @param {string} type @param {(event: any) => void} listener @param {{ signal?: AbortSignal }} [options] */
  addEventListener(type, listener, { signal } = {}) {
    this.listeners.set(type, [...(this.listeners.get(type) ?? []), listener]);
    signal?.addEventListener("abort", () => this.removeEventListener(type, listener));
  }
  /** @param {string} type @param {(event: any) => void} listener */
  removeEventListener(type, listener) {
    this.listeners.set(
      type,
      (this.listeners.get(type) ?? []).filter((other) => other !== listener),
    );
  }
  click() {
    if (!(/** @type {any} */ (this).disabled)) fire(this, "click");
  }
}

for (const name of REFLECTED) {
  Object.defineProperty(PageElement.prototype, name, {
    /** @this {PageElement} */
    get() {
      return FLAGS.includes(name) ? this.attributes.has(name) : (this.attributes.get(name) ?? "");
    },
    /** @this {PageElement} @param {unknown} value */
    set(value) {
      if (FLAGS.includes(name) && !value) this.attributes.delete(name);
      else this.attributes.set(name, FLAGS.includes(name) ? "" : String(value));
    },
  });
}

/** @param {string} name */
function dashed(name) {
  return name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`);
}

/**
 * Let something happen to an element and those it is in.
 * @param {unknown} target
 * @param {string} type
 * @param {Record<string, unknown>} [details]
 */
export function fire(target, type, details = {}) {
  let [isStopped, isPrevented] = [false, false];
  const event = {
    ...{ ctrlKey: false, metaKey: false, altKey: false, shiftKey: false, button: 0 },
    ...details,
    ...{ target, type },
    stopPropagation: () => {
      isStopped = true;
    },
    stopImmediatePropagation: () => {
      isStopped = true;
    },
    preventDefault: () => {
      isPrevented = true;
    },
    composedPath: () => [target],
  };
  for (let node = /** @type {any} */ (target); node && !isStopped; node = node.parentElement) {
    node[`on${type}`]?.(event);
    for (const listener of node.listeners.get(type) ?? []) listener(event);
  }
  return { isStopped, isPrevented };
}

/** Make the page; every test file that needs one calls it first. */
export function openPage() {
  const body = new PageElement("body");
  const page = /** @type {any} */ (globalThis);
  page.document = {
    body,
    documentElement: new PageElement("html"),
    activeElement: body,
    createElement: (/** @type {string} */ tag) => new PageElement(tag),
    createElementNS: (/** @type {string} */ _, /** @type {string} */ tag) => new PageElement(tag),
    elementFromPoint: () => page.document.under,
  };
  page.window ??= page;
  page.Element = page.HTMLElement = PageElement;
  page.Node = PageNode;
  page.ShadowRoot = class {};
  page.requestAnimationFrame ??= (/** @type {(now: number) => void} */ callback) =>
    setTimeout(() => callback(performance.now()));
  page.cancelAnimationFrame ??= clearTimeout;
  page.ResizeObserver ??= class {
    observe() {}
    disconnect() {}
  };
  return body;
}

/**
 * A control inside an element, by the name that people read or hear.
 * @param {any} root
 * @param {string} name
 * @returns {any}
 */
export function control(root, name) {
  const found = root
    .querySelectorAll("button, input, select")
    .filter(
      (/** @type {PageElement} */ node) => (node.getAttribute("aria-label") ?? node.textContent) === name,
    );
  if (found.length !== 1) throw new Error(`${found.length} controls are called ${name}`);
  return found[0];
}

/**
 * A model that holds state, and remembers what it was told to send.
 * @param {Record<string, unknown>} state
 */
export function fakeModel(state) {
  const values = { ...state };
  /** @type {Map<string, Array<(...args: any[]) => void>>} */
  const listeners = new Map();
  /** @type {any[]} */
  const sent = [];
  const model = {
    sent,
    saves: 0,
    get: (/** @type {string} */ name) => values[name],
    set(/** @type {string} */ name, /** @type {unknown} */ value) {
      values[name] = value;
      model.emit(`change:${name}`);
    },
    save_changes: () => {
      model.saves++;
    },
    send: (/** @type {object} */ message) => {
      sent.push(message);
    },
    on(/** @type {string} */ event, /** @type {any} */ callback) {
      listeners.set(event, [...(listeners.get(event) ?? []), callback]);
    },
    off(/** @type {string} */ event, /** @type {any} */ callback) {
      listeners.set(
        event,
        (listeners.get(event) ?? []).filter((other) => other !== callback),
      );
    },
    emit(/** @type {string} */ event, /** @type {any[]} */ ...args) {
      for (const callback of listeners.get(event) ?? []) callback(...args);
    },
  };
  return model;
}

/** A dispatcher that remembers what was said. */
export function fakeDispatcher() {
  /** @type {any[]} */
  const said = [];
  /** @type {Record<string, any>} */
  const handlers = {};
  return {
    said,
    handlers,
    send: (/** @type {any} */ message) => {
      said.push(message);
      handlers[message.kind]?.(message);
    },
    on(/** @type {Record<string, any>} */ more) {
      for (const [kind, handle] of Object.entries(more)) {
        const before = handlers[kind];
        handlers[kind] = (/** @type {any} */ message) => {
          before?.(message);
          handle(message);
        };
      }
    },
    /** What was said since last asked, of some kinds. @param {...string} kinds */
    take: (...kinds) => said.splice(0).filter(({ kind }) => kinds.length === 0 || kinds.includes(kind)),
  };
}
