// Names of a drop's events in exported files: English in every language of the page. Pure.

import { CONTACT_BEGIN, CONTACT_CHANGE, CONTACT_END, PEG, WALL } from "./kinds.js";

/** @param {number} kind @param {number} index @returns {string} */
export function describe(kind, index) {
  const surface = index >= 0 ? `peg ${index}` : `wall ${-1 - index}`;
  switch (kind) {
    case PEG: return `peg ${index}`;
    case WALL: return `wall ${index}`;
    case CONTACT_BEGIN: return `rides ${surface}`;
    case CONTACT_CHANGE: return `slips or grips, ${surface}`;
    case CONTACT_END: return `leaves ${surface}`;
    default: return `lands in bin ${index}`;
  }
}
