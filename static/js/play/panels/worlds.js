// The choice of the world: a picture for each.

import { HOUSE, WORLDS } from "../../model/presets.js";
import { isOwn, worldWords } from "../../model/worlds.js";
import { makeSprite, paintBall } from "../../paint/ball.js";
import { GROUNDS, paintEnamel } from "../../paint/ground.js";
import { paintPeg } from "../../paint/peg.js";
import { disc, fitted } from "../../util/canvas.js";
import { byId, make } from "../../util/dom.js";
import { pause } from "../../util/frame-loop.js";

/** @import { Look, Theme } from "../../paint/theme.js" */
/** @import { Game } from "../game.js" */

const PEGS = [[0.2, 0.86], [0.5, 0.86], [0.8, 0.86], [0.35, 0.46], [0.65, 0.46]]; // parts of width and height
const PEG = 0.085; // of the width
const BALL = { x: 0.5, y: 0.24, radius: 0.1, angle: 0.7 };

/** Fills the strip below the desk, and the one in the drawer. @param {Game} game @param {Theme} theme */
export function offerWorlds(game, theme) {
  for (const box of ["worlds", "places"]) fill(byId(box), game, theme);
}

/**
 * Radio buttons; a board with a custom gravity or material leaves all unchecked.
 * @param {HTMLElement} box @param {Game} game @param {Theme} theme
 */
function fill(box, game, theme) {
  const cards = WORLDS.map((world) => {
    const words = worldWords(world);
    const radio = make("input", { type: "radio", name: box.id, value: world, "aria-label": words });
    const picture = make("canvas", { "aria-hidden": "true" });
    const label = make("span", { "aria-hidden": "true" }, words);
    box.append(make("label", { class: "place" }, radio, picture, label));
    radio.addEventListener("change", () => game.travel(world));
    return { world, radio, picture };
  });

  const showChoice = () => {
    const choice = game.played;
    for (const { radio, world } of cards) {
      if (game.room.hello && !game.moving) radio.checked = choice?.world === world && isOwn(choice);
      radio.disabled = choice === null || game.locked;
    }
  };
  let turn = 0;
  const paint = async () => {
    const own = (turn += 1);
    for (const { world, picture } of cards) {
      await pause();
      if (own !== turn) return; // the size or the colours have changed meanwhile
      const { clientWidth: width, clientHeight: height } = picture;
      if (!width || !height) return;
      const look = theme.lookOf(world === HOUSE ? null : world);
      paintSample(fitted(picture, { width, height }), { width, height }, window.devicePixelRatio || 1, look);
    }
  };
  // The pictures are painted once the box is visible.
  new ResizeObserver(paint).observe(box);
  theme.onChange(paint);
  for (const kind of /** @type {const} */ (["table", "choice", "run", "room"])) game.on(kind, showChoice);
}

/**
 * A small sample of a table's look: its backdrop, some pegs and a ball.
 * @param {CanvasRenderingContext2D} ctx scaled to CSS pixels
 * @param {{width: number, height: number}} size CSS pixels
 * @param {number} density
 * @param {Look} look
 */
function paintSample(ctx, { width, height }, density, { palette: colours, shapes, ground, grounds }) {
  paintEnamel(ctx, colours, width, height);
  ctx.save();
  GROUNDS[ground](ctx, { x: width / 2, y: 0, width, height, colours, rays: shapes.rays, grounds });
  ctx.restore();
  const { across, down, alpha } = shapes.peg.shadow;
  const r = PEG * width;
  for (const [x, y] of PEGS.map(([part, deep]) => [part * width, deep * height])) {
    ctx.globalAlpha = alpha;
    ctx.fillStyle = colours.shadow;
    disc(ctx, x + across * r, y + down * r, r);
    ctx.globalAlpha = 1;
    paintPeg(ctx, { x, y, r }, colours, shapes.peg);
  }
  const { ball: body, ballDark: dark, ballLight: light, ballBand: band, shadow } = colours;
  const sprite = makeSprite(BALL.radius * width, density, { body, dark, light, band, shadow }, shapes.ball);
  paintBall(ctx, sprite, BALL.x * width, BALL.y * height, BALL.angle);
}
