// The doubles next to a double, and its bits. Pure.

/**
 * The smallest double above x.
 * @param {number} x finite
 * @returns {number}
 */
export function nextUp(x) {
  if (x === 0) return Number.MIN_VALUE;
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, x);
  // Doubles of one sign have the order of their bits, read as integers.
  view.setBigInt64(0, view.getBigInt64(0) + (x > 0 ? 1n : -1n));
  return view.getFloat64(0);
}

/** @param {number} x finite @returns {number} the largest double below x */
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
