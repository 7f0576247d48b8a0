// Which short texts are plain enough to show to other players: the rules of engine/plain_text.py. Pure.

const SHOWN = /^(?:[^\p{C}\p{Z}]| )*$/u;

// Invisible characters whose Unicode category is letter or mark.
const UNSEEN = new RegExp("\\u034f|\\u115f|\\u1160|\\u17b4|\\u17b5|[\\u180b-\\u180f]|\\u2800|\\u3164"
  + "|[\\ufe00-\\ufe0f]|\\uffa0|[\\u{e0100}-\\u{e01ef}]", "u");

// The blocks with emoji, of which each version of Unicode adds some.
const PICTURE = "[\\xa9\\xae\\u203c\\u2049\\u2122\\u2139\\u2190-\\u21ff\\u2300-\\u23ff\\u24c2\\u25a0-\\u27bf"
  + "\\u2900-\\u297f\\u2b00-\\u2bff\\u3030\\u303d\\u3297\\u3299\\u{1f000}-\\u{1faff}]";
const EMOJI = `${PICTURE}[\\ufe0e\\ufe0f]?[\\u{1f3fb}-\\u{1f3ff}]?`;
// The flags of England, Scotland and Wales, spelled with tags.
const FLAGS = ["gbeng", "gbsct", "gbwls"].map((part) => {
  const tags = Array.from(part, (letter) => `\\u{e00${letter.charCodeAt(0).toString(16)}}`);
  return `\\u{1f3f4}${tags.join("")}\\u{e007f}`;
}).join("|");
const EMOJIS = new RegExp(`${FLAGS}|${EMOJI}(?:\\u200d${EMOJI})*|[0-9#*]\\ufe0f?\\u20e3`, "gu");

// Marks that take a letter's vowel away or join letters (combining class 9) in living scripts.
const VIRAMAS = "\\u094d|\\u09cd|\\u0a4d|\\u0acd|\\u0b4d|\\u0bcd|\\u0c4d|\\u0ccd|\\u0d3b|\\u0d3c"
  + "|\\u0d4d|\\u0dca|\\u0e3a|\\u0eba|\\u0f84|\\u1039|\\u103a|\\u1714|\\u1715|\\u1734"
  + "|\\u17d2|\\u1a60|\\u1b44|\\u1baa|\\u1bab|\\u1bf2|\\u1bf3|\\u2d7f|\\ua806|\\ua82c"
  + "|\\ua8c4|\\ua953|\\ua9c0|\\uaaf6|\\uabed|\\u{11133}|\\u{11134}";
// Letters and marks, not punctuation.
const ARABIC = "[\\u0610-\\u061a\\u0620-\\u065f\\u066e-\\u06d3\\u06d5-\\u06dc]|[\\u06df-\\u06e8]"
  + "|[\\u06ea-\\u06ef\\u06fa-\\u06ff\\u0710-\\u074a\\u0750-\\u077f\\u08a0-\\u08e1]"
  + "|[\\u08e3-\\u08ff\\ufb50-\\ufdfb\\ufe70-\\ufefc]";
// Each with the character before it, which stays.
const JOINERS = new RegExp(`(${VIRAMAS})[\\u200c\\u200d]`
  + `|([^ \\u200c\\u200d])\\u200d(?=${VIRAMAS})`
  + `|(${ARABIC})\\u200c(?=${ARABIC})`
  + "|([\\u3400-\\u4dbf\\u4e00-\\u9fff\\uf900-\\ufaff\\u{20000}-\\u{3ffff}])[\\u{e0100}-\\u{e01ef}]"
  + "|([\\u1820-\\u1878\\u1880-\\u18aa])[\\u180b-\\u180f]", "gu");

const MARKS = 4; // most marks on a letter: Burmese, Tibetan and pointed Hebrew need as many
const PILED = new RegExp(`(?:^| )\\p{M}|[\\p{Mn}\\p{Me}]{${MARKS + 1}}|([\\p{Mn}\\p{Me}])\\1`
  // Marks of no script, as Latin letters have them; after NFC no orthography needs three.
  + "|(?:[\\u0300-\\u036f]|[\\u1ab0-\\u1aff]|[\\u1dc0-\\u1dff]|[\\u20d0-\\u20ff]|[\\ufe20-\\ufe2f]){3}", "u");

/**
 * Whether every character can be seen, or joins others where it should; spaces are plain.
 * @param {string} text
 */
export function isPrintable(text) {
  return SHOWN.test(withoutJoiners(text));
}

/**
 * @param {string} text in Unicode's form NFC
 * @param {number} most characters
 * @returns {string | null} what a valid text would be, or null if this one is valid
 */
export function textFault(text, most) {
  if (text === "" || [...text].length > most) return `a text of 1 to ${most} characters`;
  const seen = withoutJoiners(text);
  if (!SHOWN.test(seen) || UNSEEN.test(seen)) return "plain text: letters, marks, figures, signs, spaces";
  if (/^ | $| {2}/.test(seen)) return "a text without spaces at its ends or two in a row";
  if (PILED.test(seen)) return `a text with at most ${MARKS} marks on a letter, and none twice`;
  return null;
}

/**
 * The text without invisible characters where they belong; an emoji becomes one plain one.
 * @param {string} text
 */
function withoutJoiners(text) {
  return text.replace(EMOJIS, "\u263a").replace(JOINERS, "$1$2$3$4$5");
}
