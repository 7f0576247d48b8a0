// The player's mark: what their drops are found by again on the server, for who knows it.

const KEY = "plinko.mark.1";
const BYTES = 16; // nobody guesses them

/** A mark of this browser's own, the same in all its tabs until another is made. */
export class Mark {
  /** @param {Pick<Storage, "getItem" | "setItem">} storage */
  constructor(storage) {
    this.storage = storage;
  }

  /** @returns {string} hexadecimal */
  get value() {
    return this.storage.getItem(KEY) ?? this.renew();
  }

  /** Makes another; drops under the one before are found by that alone. @returns {string} */
  renew() {
    const bytes = crypto.getRandomValues(new Uint8Array(BYTES));
    const value = Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
    this.storage.setItem(KEY, value);
    return value;
  }
}
