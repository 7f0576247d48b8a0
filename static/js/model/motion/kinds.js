// The kinds of a drop's events, as in its record. Pure.

export const PEG = 0;
export const WALL = 1;
export const CONTACT_BEGIN = 2;
export const CONTACT_CHANGE = 3;
export const CONTACT_END = 4;
export const LANDING = 5;
