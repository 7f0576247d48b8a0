// What an impact sounds like, from how hard and where it was; what a bin's pay sounds like. Pure.

const SILENT = 0.12; // m/s: softer touches make no sound
const LOUD = 6; // m/s: harder ones are not louder
const WALL = 1;

/**
 * @typedef {object} Tone
 * @property {number} frequency Hz
 * @property {number} gain 0 … 1
 * @property {number} decay s until it is a thousandth
 * @property {number} pan -1 … 1
 */

/**
 * A peg rings like a small bar: the harder it is hit, the louder and a little brighter. The energy
 * that is heard goes with the square of the speed; ears hear that as steps, hence the root.
 * @param {{kind: number, speed: number, x: number}} impact
 * @param {{left: number, right: number}} sides of the board, metres
 * @returns {Tone | null} null for a touch too soft to be heard
 */
export function toneOf({ kind, speed, x }, { left, right }) {
  if (!(speed > SILENT)) return null;
  const force = Math.min(1, speed / LOUD);
  const across = Math.max(0, Math.min(1, (x - left) / (right - left)));
  const base = kind === WALL ? 420 : 1250 + 500 * across;
  return {
    frequency: base * (1 + 0.35 * force),
    gain: 0.5 * force ** 0.8,
    decay: kind === WALL ? 0.09 : 0.05 + 0.06 * force,
    pan: 1.4 * (across - 0.5),
  };
}

/** @param {number} score @param {number} place 0 … 1 across @returns {Tone[]} a rising chord */
export function chimeOf(score, place) {
  const steps = score < 1 ? 1 : Math.min(4, 2 + Math.floor(Math.log10(score)));
  const root = score < 1 ? 220 : 392;
  return [1, 1.25, 1.5, 2].slice(0, steps).map((ratio) => ({
    frequency: root * ratio, gain: 0.22, decay: 0.35, pan: 1.4 * (place - 0.5),
  }));
}

/** The loudest first; no more than there are voices. @param {Tone[]} tones @param {number} free */
export function chosen(tones, free) {
  if (tones.length <= free) return tones;
  return [...tones].sort((one, two) => two.gain - one.gain).slice(0, Math.max(0, free));
}
