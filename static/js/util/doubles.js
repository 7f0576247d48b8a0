// Doubles one bit apart. Pure.

/**
 * The next double above x, towards +infinity: the start that differs in the last bit.
 * @param {number} x finite
 * @returns {number}
 */
export function nextUp(x) {
  if (x === 0) return Number.MIN_VALUE;
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, x);
  // Doubles of one sign are ordered as their bits are.
  view.setBigInt64(0, view.getBigInt64(0) + (x > 0 ? 1n : -1n));
  return view.getFloat64(0);
}

/** @param {number} x finite @returns {number} the next double below x, towards -infinity */
export function nextDown(x) {
  return -nextUp(-x);
}

/** @param {number} x @returns {string} its 64 bits, "sign exponent fraction" */
export function bitsOf(x) {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, x);
  const bits = view.getBigUint64(0).toString(2).padStart(64, "0");
  return `${bits[0]} ${bits.slice(1, 12)} ${bits.slice(12)}`;
}
