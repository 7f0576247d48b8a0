// The timbres of each world's pegs. Pitches were chosen by ear; a comment at each says what it imitates.

/**
 * @typedef {object} Timbre
 * @property {[number, number]} peg Hz: pitch of a soft touch on the left, and how much higher on the right
 * @property {number} wall Hz
 * @property {number} rise how much higher the hardest impact sounds, relative
 * @property {[number, number]} decay s until a peg's tone has fallen to 1/1000: for a soft impact, and how much
 *   longer for a hard one
 * @property {OscillatorType} wave
 * @property {number} bend the initial frequency relative to the tone's
 * @property {{ratio: number, gain: number, decay: number}[]} overtones relative to the tone
 * @property {number} root Hz of a bin's chord
 */

/** Brass pins in wood. @type {Timbre} */
export const HOME = {
  peg: [1250, 500], wall: 420, rise: 0.35, decay: [0.05, 0.06], wave: "triangle", bend: 1.5,
  overtones: [], root: 392,
};

/** @type {Record<string, Timbre>} by the name of the world */
export const TIMBRES = {
  // A light ball on wooden pegs.
  earth: {
    peg: [980, 380], wall: 340, rise: 0.3, decay: [0.04, 0.04], wave: "triangle", bend: 1.7,
    overtones: [], root: 349,
  },
  // There is no air, so sound travels only through the ground: soft and long.
  moon: {
    peg: [520, 260], wall: 210, rise: 0.2, decay: [0.18, 0.3], wave: "sine", bend: 1.08,
    overtones: [{ ratio: 1.5, gain: 0.3, decay: 1.6 }], root: 330,
  },
  // Dry stone.
  mars: {
    peg: [700, 240], wall: 300, rise: 0.5, decay: [0.03, 0.05], wave: "triangle", bend: 2.1,
    overtones: [{ ratio: 2.6, gain: 0.3, decay: 0.5 }], root: 294,
  },
  // Dense air: deep tones.
  jupiter: {
    peg: [150, 90], wall: 90, rise: 0.4, decay: [0.14, 0.22], wave: "sine", bend: 2.4,
    overtones: [{ ratio: 2, gain: 0.4, decay: 0.7 }], root: 147,
  },
  // A struck glass: slow decay, and the partials of a shell.
  glass: {
    peg: [2200, 900], wall: 1400, rise: 0.06, decay: [0.25, 0.35], wave: "sine", bend: 1,
    overtones: [{ ratio: 2.32, gain: 0.35, decay: 0.6 }, { ratio: 4.25, gain: 0.14, decay: 0.35 }], root: 523,
  },
  // The partials of a free bar: 1, 2.76, 5.40.
  steel: {
    peg: [880, 320], wall: 500, rise: 0.12, decay: [0.2, 0.25], wave: "triangle", bend: 1,
    overtones: [{ ratio: 2.76, gain: 0.5, decay: 0.7 }, { ratio: 5.4, gain: 0.2, decay: 0.4 }], root: 370,
  },
  // A bounced ball: its pitch falls as it springs back.
  rubber: {
    peg: [190, 110], wall: 130, rise: 0.8, decay: [0.06, 0.07], wave: "sine", bend: 2.8,
    overtones: [], root: 220,
  },
};
