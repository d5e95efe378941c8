/** What the parts of one view say to each other, so that none has to know another. */

/**
 * The messages of a kind.
 * @template Message
 * @template Kind
 * @typedef {Message extends { kind: infer Kinds } ? Kind extends Kinds ? Message : never : never} OfKind
 */

/**
 * What to do with messages, by kind.
 * @template {{ kind: string }} Message
 * @typedef {{ [Kind in Message["kind"]]?: (message: OfKind<Message, Kind>) => void }} Handlers
 */

/**
 * @template {{ kind: string }} Message
 * @returns {{ on: (handlers: Handlers<Message>) => void, send: (message: Message) => void }}
 */
export function createDispatcher() {
  /** @type {Map<string, Array<(message: any) => void>>} */
  const listeners = new Map();
  return {
    /** Hear messages of some kinds. */
    on(handlers) {
      for (const [kind, handler] of Object.entries(handlers))
        listeners.set(kind, [...(listeners.get(kind) ?? []), /** @type {any} */ (handler)]);
    },

    /** Say something to all who hear it, in the order in which they began to; done when it returns. */
    send(message) {
      for (const listener of listeners.get(message.kind) ?? []) listener(message);
    },
  };
}
