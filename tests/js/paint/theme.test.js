// Colours: those of scores, the same names in light and dark, and enough contrast for every text.

import assert from "node:assert/strict";
import { test } from "node:test";

import { COLOURS } from "../../../static/js/model/player/colour.js";
import { WORLDS } from "../../../static/js/model/presets.js";
import { placeOf, transported } from "../../../static/js/model/worlds.js";
import { GROUNDS as PRINTS, SURROUNDINGS } from "../../../static/js/paint/ground.js";
import { lookOf, payoutColour } from "../../../static/js/paint/theme.js";
import { json, triangle } from "../support.js";

const THEME = json("static/theme.json");

test("a score takes the colour of its step", () => {
  for (const [score, step] of [[0, 0], [0.3, 0], [0.5, 0.45], [1, 1], [1.4, 1], [110, 80], [1000, 80]]) {
    assert.equal(payoutColour(THEME.payout, score).from, step);
  }
  assert.deepEqual(Object.keys(THEME.light), Object.keys(THEME.dark));
});

/** WCAG 2 contrast ratio of two colours in hex sRGB. */
function contrast(one, two) {
  const luminance = (colour) => {
    const [red, green, blue] = [1, 3, 5].map((at) => {
      const part = parseInt(colour.slice(at, at + 2), 16) / 255;
      return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  };
  const [low, high] = [luminance(one), luminance(two)].sort((a, b) => a - b);
  return (high + 0.05) / (low + 0.05);
}

const BENEATH = ["page", "pageDeep", "case", "caseShade", "field"];
const GROUNDS = {
  ink: BENEATH,
  inkSoft: BENEATH,
  link: BENEATH,
  good: BENEATH, // "It can be played" had contrasts of only 3.4 and 4.2
  bad: BENEATH,
  accentInk: ["accent"],
  counterInk: ["counter"],
  trayInk: ["tray"],
};

for (const name of ["light", "dark"]) {
  test(`all text has enough contrast: ${name}`, () => {
    const colours = THEME[name];
    assert.equal(contrast("#000000", "#ffffff"), 21);
    for (const [text, grounds] of Object.entries(GROUNDS)) {
      for (const ground of grounds) {
        const ratio = contrast(colours[text], colours[ground]);
        assert.ok(ratio >= 4.5, `${text} on ${ground} is ${ratio.toFixed(2)}`);
      }
    }
    // The borders of fields and buttons need less contrast than text.
    assert.ok(contrast(colours.line, colours.page) >= 3);
    assert.ok(contrast(colours.focus, colours.page) >= 3);
  });
}

test("each place has its own backdrop and palette, by board name", () => {
  const [, ...away] = WORLDS;
  for (const home of ["triangle-16-high", "classic", "moon-7", "moonshine", "triangle-16 · Clay (putty)"]) {
    assert.equal(placeOf(home), null, home);
  }
  assert.deepEqual(away.map((world) => placeOf(`${world}-8-low`)), Object.keys(THEME.places));
  const both = { gravity: "Moon", material: "Glass on glass" };
  assert.equal(placeOf(transported(triangle(), both).name), "moon");
  assert.equal(placeOf("triangle-16 · Rubber on concrete"), "rubber");
  for (const [name, { ground, palette }] of Object.entries(THEME.places)) {
    assert.ok(ground in PRINTS && ground in SURROUNDINGS, name);
    for (const colour of Object.keys(palette)) assert.ok(colour in THEME.light, `${name}: ${colour}`);
  }
});

for (const place of [null, ...Object.keys(THEME.places)]) {
  test(`balls, words and trays have contrast on: ${place ?? "home"}`, () => {
    for (const scheme of [THEME.light, THEME.dark]) {
      const { palette } = lookOf(THEME, scheme, place);
      assert.ok(contrast(palette.trayInk, palette.tray) >= 4.5);
      assert.ok(contrast(palette.flash, palette.railShade) >= 4.5);
      assert.ok(contrast(palette.trayBar, palette.tray) >= 3);
      assert.ok(contrast(palette.trayMark, palette.tray) >= 3);
      // On the default board only a ball's light band has enough contrast, elsewhere its body too.
      const own = place ? ["ball", "ballBand", "peg"] : ["ballBand", "peg"];
      for (const name of own) {
        for (const ground of ["board", "boardDeep"]) {
          const ratio = contrast(palette[name], palette[ground]);
          assert.ok(ratio >= 3, `${name} on ${ground} is ${ratio.toFixed(2)}`);
        }
      }
      for (const ground of [palette.board, palette.boardDeep]) {
        const dim = Math.min(...[...COLOURS, palette.other].map((colour) => contrast(colour, ground)));
        assert.ok(dim >= 2.4, `another player's ball on ${ground}: ${dim.toFixed(2)}`);
      }
    }
  });
}

test("every multiplier has enough contrast on its bin", () => {
  for (const { fill, ink, from } of THEME.payout) assert.ok(contrast(fill, ink) >= 4.5, `${from}`);
});
