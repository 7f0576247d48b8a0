// Computes the tones of an impact, from its speed and place, and of a payout. Pure.

import { HOME } from "./timbres.js";

/** @import { Timbre } from "./timbres.js" */

const SILENT = 0.12; // m/s: slower impacts make no sound
const LOUD = 6; // m/s: faster impacts are not louder
const WALL = 1;
const WALL_DECAY = 0.8; // relative to a peg's decay

/**
 * @typedef {object} Tone
 * @property {number} frequency Hz
 * @property {number} gain 0 … 1
 * @property {number} decay s until the tone has 1/1000 of its gain
 * @property {number} pan -1 … 1
 * @property {OscillatorType} wave
 * @property {number} bend the initial frequency relative to `frequency`
 */

/**
 * A peg rings like a small bar: the harder the impact, the louder, higher and longer the tone. Loudness is perceived
 * on a compressed scale, so the gain grows more slowly than the speed.
 * @param {{kind: number, speed: number, x: number}} impact
 * @param {{left: number, right: number}} sides of the board, m
 * @param {Timbre} [timbre]
 * @returns {Tone | null} null for an impact that is too soft
 */
export function toneOf({ kind, speed, x }, { left, right }, timbre = HOME) {
  if (!(speed > SILENT)) return null;
  const force = Math.min(1, speed / LOUD);
  const across = Math.max(0, Math.min(1, (x - left) / (right - left)));
  const [low, span] = timbre.peg;
  const [short, more] = timbre.decay;
  const base = kind === WALL ? timbre.wall : low + span * across;
  const decay = short + more * force;
  return {
    frequency: base * (1 + timbre.rise * force),
    gain: 0.5 * force ** 0.8,
    decay: kind === WALL ? WALL_DECAY * decay : decay,
    pan: 1.4 * (across - 0.5),
    wave: timbre.wave,
    bend: timbre.bend,
  };
}

/** @param {Tone} tone @param {Timbre} timbre @returns {Tone[]} the tone and its overtones */
export function withOvertones(tone, { overtones }) {
  return [tone, ...overtones.map(({ ratio, gain, decay }) => ({
    ...tone, frequency: ratio * tone.frequency, gain: gain * tone.gain, decay: decay * tone.decay,
  }))];
}

/**
 * @param {number} score
 * @param {number} place 0 … 1 from left to right
 * @param {Timbre} [timbre]
 * @returns {Tone[]} a soft tick for less than the stake, else a rising chord
 */
export function chimeOf(score, place, { root, wave } = HOME) {
  const steps = score < 1 ? 1 : Math.min(4, 2 + Math.floor(Math.log10(score)));
  const base = score < 1 ? root / 1.78 : root;
  return [1, 1.25, 1.5, 2].slice(0, steps).map((ratio) => ({
    frequency: base * ratio, gain: score < 1 ? 0.14 : 0.22, decay: score < 1 ? 0.16 : 0.35, pan: 1.4 * (place - 0.5),
    wave, bend: 1.5,
  }));
}

/** The loudest tones, at most as many as there are free voices. @param {Tone[]} tones @param {number} free */
export function chosen(tones, free) {
  if (tones.length <= free) return tones;
  return [...tones].sort((one, two) => two.gain - one.gain).slice(0, Math.max(0, free));
}
