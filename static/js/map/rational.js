// Starts as exact fractions, because the map zooms far below the resolution of float64. Pure.

/** @typedef {{top: bigint, bottom: bigint}} Rational bottom > 0 */

/** @param {string} text a fraction such as `3/8`, or a whole number @returns {Rational} */
export function readRational(text) {
  const [top, bottom = "1"] = text.split("/");
  return { top: BigInt(top), bottom: BigInt(bottom) };
}

/** @param {Rational} value @returns {string} the reduced fraction */
export function rationalText({ top, bottom }) {
  const common = divisor(top < 0n ? -top : top, bottom);
  return common === bottom ? String(top / common) : `${top / common}/${bottom / common}`;
}

/**
 * The middle of a pixel of a strip.
 * @param {Rational} x the strip's middle
 * @param {Rational} width the strip's width
 * @param {number} pixel
 * @param {number} pixels the strip's number of pixels
 * @returns {Rational}
 */
export function pixelMiddle(x, width, pixel, pixels) {
  const share = BigInt(2 * pixel + 1 - pixels);
  const parts = BigInt(2 * pixels);
  return {
    top: x.top * width.bottom * parts + width.top * share * x.bottom,
    bottom: x.bottom * width.bottom * parts,
  };
}

/** @param {bigint} a @param {bigint} b @returns {bigint} the greatest common divisor, at least 1 */
function divisor(a, b) {
  return b === 0n ? (a || 1n) : divisor(b, a % b);
}
