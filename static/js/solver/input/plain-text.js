// Which short texts are plain enough to show to other players: the rules of engine/plain_text.py. Pure.

const SHOWN = /^(?:[^\p{C}\p{Z}]| )+$/u;
// Invisible characters whose Unicode category is letter or mark.
const UNSEEN = /\u034f|\u115f|\u1160|\u17b4|\u17b5|\u2800|\u3164|[\ufe00-\ufe0f]|\uffa0/u;
const MARKED = /^\p{M}|\p{M}{3}/u; // after NFC no language needs three marks on a letter

/**
 * @param {string} text in Unicode's form NFC
 * @param {number} most characters
 * @returns {string | null} what a valid text would be, or null if this one is valid
 */
export function textFault(text, most) {
  if (text === "" || [...text].length > most) return `a text of 1 to ${most} characters`;
  if (!SHOWN.test(text) || UNSEEN.test(text)) return "plain text: letters, marks, figures, signs, spaces";
  if (/^ | $| {2}/.test(text)) return "a text without spaces at its ends or two in a row";
  if (MARKED.test(text)) return "a text with at most 2 marks on a letter";
  return null;
}
