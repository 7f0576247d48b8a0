// Parses JSON strictly: refuses text that two readers could understand differently. The rules and the messages are
// those of the engine, so that `plinko verify` and the page accept the same files.
//
// Refused are: duplicate keys, of which readers keep different ones; numbers beyond float64, which would become
// infinite; lone surrogates, which cannot be encoded as UTF-8; and more than DEEPEST levels. Pure.

const DEEPEST = 64; // levels of nested brackets
const LONGEST_PLACE = 100; // characters of a path in an error

const SPACE = /[ \t\n\r]*/y;
const STRING = /"(?:[^"\\\u0000-\u001f]|\\(?:["\\/bfnrt]|u[0-9a-fA-F]{4}))*"/y;
const NUMBER = /-?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?/y;
const HALF_PAIR = /\p{Surrogate}/u; // alone: the flag u reads pairs as one character
const WORD = /true|false|null|NaN|-?Infinity/y;
const WORDS = new Map([["true", true], ["false", false], ["null", null]]);

/** A text is not JSON, or contains a value that is refused, whose path the message names. */
export class JsonError extends SyntaxError {
  /** @param {string} message @param {string} [field] path of a refused value, such as `pegs[0].radius` */
  constructor(message, field = "") {
    super(message);
    this.name = new.target.name;
    this.field = field;
  }
}

/**
 * Parses JSON text.
 * @param {string} text
 * @param {boolean} [exact] whether a whole number that a double would round becomes a BigInt
 * @returns {unknown} throws a JsonError
 */
export function readJson(text, exact = true) {
  return new Reader(text, exact).whole();
}

/** @param {unknown} value as `readJson` returns it @returns {string} for an error: a BigInt is shown in quotes */
export function shownJson(value) {
  return JSON.stringify(value, (_, part) => (typeof part === "bigint" ? String(part) : part)) ?? String(value);
}

/**
 * Reads a file that a person gives: UTF-8, or UTF-16 as PowerShell writes it.
 * @param {{arrayBuffer: () => Promise<ArrayBuffer>}} file
 * @returns {Promise<string>} rejects with a JsonError
 */
export async function textOfFile(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const encoding = encodingOf(bytes);
  try {
    return new TextDecoder(encoding, { fatal: true }).decode(bytes);
  } catch {
    throw new JsonError(`not JSON: not ${encoding.toUpperCase()}`);
  }
}

/** @param {Uint8Array} bytes @returns {string} The first character of JSON is ASCII. */
function encodingOf([first, second]) {
  if ((first === 0xff && second === 0xfe) || second === 0) return "utf-16le";
  if ((first === 0xfe && second === 0xff) || first === 0) return "utf-16be";
  return "utf-8";
}

class Reader {
  #text;
  #exact;
  #at = 0;
  #depth = 0;

  /** @param {string} text @param {boolean} exact */
  constructor(text, exact) {
    this.#text = text;
    this.#exact = exact;
  }

  /** @returns {unknown} the value that is the whole text */
  whole() {
    this.#skip();
    const value = this.#value("");
    if (this.#at < this.#text.length) throw this.#unexpected("the end");
    return value;
  }

  /** Reads a value and the spaces after it. @param {string} place its path @returns {unknown} */
  #value(place) {
    const first = this.#text[this.#at];
    if (first === "{" || first === "[") {
      if (this.#depth === DEEPEST) throw new JsonError(`JSON nested too deeply: more than ${DEEPEST} levels`);
      this.#depth += 1;
      const value = first === "{" ? this.#object(place) : this.#list(place);
      this.#depth -= 1;
      return value;
    }
    if (first === '"') return this.#string(place, "");
    const word = this.#token(WORD);
    if (word !== null) {
      const value = WORDS.get(word);
      if (value === undefined) throw refused(place, `${word} is not a JSON number`);
      return value;
    }
    const digits = this.#token(NUMBER);
    if (digits === null) throw this.#unexpected("a value");
    return number(digits, place, this.#exact);
  }

  /** @param {string} place */
  #object(place) {
    /** @type {Map<string, unknown>} */
    const members = new Map();
    this.#items("}", () => {
      if (this.#text[this.#at] !== '"') throw this.#unexpected("a key in double quotes");
      const key = this.#string(place, "the key ");
      const inner = (place ? `${place}.${key}` : key).slice(0, LONGEST_PLACE);
      if (members.has(key)) throw refused(inner, "the key is given twice");
      if (!this.#takes(":")) throw this.#unexpected('":"');
      members.set(key, this.#value(inner));
    });
    return Object.fromEntries(members); // unlike an assignment, this makes `__proto__` a member like any other
  }

  /** @param {string} place */
  #list(place) {
    /** @type {unknown[]} */
    const items = [];
    this.#items("]", () => items.push(this.#value(`${place}[${items.length}]`)));
    return items;
  }

  /** Reads what is between brackets. @param {string} end @param {() => void} read reads one item */
  #items(end, read) {
    this.#at += 1;
    this.#skip();
    if (this.#takes(end)) return;
    do read(); while (this.#takes(","));
    if (!this.#takes(end)) throw this.#unexpected(`"," or "${end}"`);
  }

  /** @param {string} place @param {string} what before the error's text @returns {string} */
  #string(place, what) {
    const token = this.#token(STRING);
    if (token === null) throw this.#unexpected("a string");
    const text = JSON.parse(token);
    if (HALF_PAIR.test(text)) throw refused(place, `${what}${token.slice(0, 40)} has a lone surrogate, which is not a character`);
    return text;
  }

  /** @param {RegExp} pattern sticky @returns {string | null} what it matches here; then skips spaces */
  #token(pattern) {
    pattern.lastIndex = this.#at;
    const [token = null] = pattern.exec(this.#text) ?? [];
    if (token !== null) {
      this.#at = pattern.lastIndex;
      this.#skip();
    }
    return token;
  }

  /** @param {string} sign @returns {boolean} whether it is here; then skips it and spaces */
  #takes(sign) {
    if (this.#text[this.#at] !== sign) return false;
    this.#at += 1;
    this.#skip();
    return true;
  }

  #skip() {
    SPACE.lastIndex = this.#at;
    SPACE.test(this.#text);
    this.#at = SPACE.lastIndex;
  }

  /** @param {string} expected */
  #unexpected(expected) {
    const before = this.#text.slice(0, this.#at).split("\n");
    const found = this.#at < this.#text.length ? JSON.stringify(this.#text[this.#at]) : "the end";
    return new JsonError(`not JSON: line ${before.length} column ${before[before.length - 1].length + 1}: `
      + `${expected} expected, found ${found}`);
  }
}

/** @param {string} digits @param {string} place @param {boolean} exact @returns {number | bigint} */
function number(digits, place, exact) {
  const value = Number(digits);
  const whole = /^-?\d+$/.test(digits);
  if (!Number.isFinite(value)) {
    const shown = digits.length > 40 ? `${digits.slice(0, 37)}...` : digits;
    const what = whole ? `a number of ${digits.replace("-", "").length} digits` : shown;
    throw refused(place, `${what} is out of range`);
  }
  return exact && whole && !Number.isSafeInteger(value) ? BigInt(digits) : value;
}

/** @param {string} place @param {string} why */
function refused(place, why) {
  return new JsonError(`${place || "the value"}: ${why}`, place);
}
