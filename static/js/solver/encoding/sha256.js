// SHA-256 (FIPS 180-4), synchronous: the browser's own is asynchronous, and exists only over HTTPS.

const WORDS = 64;
const BLOCK = 64; // bytes

/** The first 32 bits of the fractional parts of square roots and of cube roots of the first primes. */
const [FIRST, CONSTANTS] = tables();

function tables() {
  /** @type {number[]} */
  const primes = [];
  for (let n = 2; primes.length < WORDS; n += 1) {
    if (primes.every((prime) => n % prime !== 0)) primes.push(n);
  }
  // In integers, because Math.pow differs between browsers.
  return [
    Uint32Array.from(primes.slice(0, 8), (prime) => fraction(prime, 2n)),
    Uint32Array.from(primes, (prime) => fraction(prime, 3n)),
  ];
}

/** @param {number} prime @param {bigint} degree of the root @returns {number} */
function fraction(prime, degree) {
  const target = BigInt(prime) << (32n * degree);
  let [low, high] = [0n, 1n << 40n]; // floor of the root times 2^32
  while (high - low > 1n) {
    const middle = (low + high) >> 1n;
    if (middle ** degree <= target) low = middle;
    else high = middle;
  }
  return Number(low & 0xffffffffn);
}

const schedule = new Uint32Array(WORDS);

/** @param {Uint8Array} data @returns {string} 64 hexadecimal digits */
export function sha256(data) {
  const state = FIRST.slice();
  const whole = data.length - (data.length % BLOCK);
  const view = new DataView(data.buffer, data.byteOffset, data.length);
  for (let at = 0; at < whole; at += BLOCK) mix(state, view, at);
  const rest = data.length - whole;
  const last = new Uint8Array(rest + 9 > BLOCK ? 2 * BLOCK : BLOCK);
  last.set(data.subarray(whole));
  last[rest] = 0x80;
  const end = new DataView(last.buffer);
  end.setUint32(last.length - 8, Math.floor(data.length / 2 ** 29));
  end.setUint32(last.length - 4, (data.length * 8) >>> 0);
  for (let at = 0; at < last.length; at += BLOCK) mix(state, end, at);
  return Array.from(state, (word) => word.toString(16).padStart(8, "0")).join("");
}

/** @param {Uint32Array} state updated @param {DataView} view @param {number} at where the block begins */
function mix(state, view, at) {
  const w = schedule;
  for (let i = 0; i < 16; i += 1) w[i] = view.getUint32(at + 4 * i);
  for (let i = 16; i < WORDS; i += 1) {
    const [x, y] = [w[i - 15], w[i - 2]];
    const s0 = ((x >>> 7) | (x << 25)) ^ ((x >>> 18) | (x << 14)) ^ (x >>> 3);
    const s1 = ((y >>> 17) | (y << 15)) ^ ((y >>> 19) | (y << 13)) ^ (y >>> 10);
    w[i] = w[i - 16] + s0 + w[i - 7] + s1;
  }
  let [a, b, c, d, e, f, g, h] = state;
  for (let i = 0; i < WORDS; i += 1) {
    const s1 = ((e >>> 6) | (e << 26)) ^ ((e >>> 11) | (e << 21)) ^ ((e >>> 25) | (e << 7));
    const t1 = (h + s1 + ((e & f) ^ (~e & g)) + CONSTANTS[i] + w[i]) | 0;
    const s0 = ((a >>> 2) | (a << 30)) ^ ((a >>> 13) | (a << 19)) ^ ((a >>> 22) | (a << 10));
    const t2 = (s0 + ((a & b) ^ (a & c) ^ (b & c))) | 0;
    h = g;
    g = f;
    f = e;
    e = (d + t1) | 0;
    d = c;
    c = b;
    b = a;
    a = (t1 + t2) | 0;
  }
  [a, b, c, d, e, f, g, h].forEach((value, i) => { state[i] += value; });
}
