// The pictures of balls in a show: an emoji or a small picture for each name, painted over the ball.

import { sheetContext } from "../util/canvas.js";

/** @import { Board } from "../model/board.js" */
/** @import { SceneBall } from "../model/scene.js" */
/** @import { Geometry } from "../paint/geometry.js" */

const SIDE = 96; // pixels of a picture, enough for a ball on a large screen
const LEAST = 11; // CSS pixels: the smallest radius at which a face can be recognised
const RIM = 0.12; // of the radius

/** The faces by name. */
export class Faces {
  /** @type {Map<string, {source: string, picture: ImageBitmap | null}>} null while it is loaded */
  #known = new Map();

  /** @param {Record<string, string>} sources an emoji or a `data:` URL for each name */
  set(sources) {
    const known = new Map(Object.entries(sources).map(([name, source]) => {
      const old = this.#known.get(name);
      return [name, old?.source === source ? old : { source, picture: null }];
    }));
    this.#known = known;
    for (const face of known.values()) face.picture ??= face.source.startsWith("data:") ? null : emoji(face.source);
    for (const face of known.values()) if (!face.picture) void load(face);
  }

  /**
   * @param {CanvasRenderingContext2D} ctx scaled to CSS pixels
   * @param {{board: Board, geometry: Geometry}} painter
   * @param {Iterable<{pose: SceneBall, by?: string}>} balls
   */
  draw(ctx, { board, geometry: { px, py, scale, binTop, width } }, balls) {
    if (!this.#known.size) return;
    const radius = Math.max(LEAST, board.ball.radius * scale);
    ctx.save();
    ctx.beginPath();
    ctx.rect(0, 0, width, binTop + 2);
    ctx.clip();
    for (const { pose, by } of balls) {
      const picture = this.#known.get(by ?? "")?.picture;
      if (!picture) continue;
      ctx.save();
      ctx.translate(px(pose.x), py(pose.y));
      ctx.fillStyle = pose.colour ?? "#fff";
      ctx.beginPath();
      ctx.arc(0, 0, radius, 0, 2 * Math.PI);
      ctx.fill();
      ctx.rotate(pose.angle);
      const inner = radius * (1 - RIM);
      ctx.drawImage(picture, -inner, -inner, 2 * inner, 2 * inner);
      ctx.restore();
    }
    ctx.restore();
  }
}

/** @param {string} text @returns {ImageBitmap} */
function emoji(text) {
  const ctx = sheetContext(SIDE, SIDE);
  Object.assign(ctx, { textAlign: "center", textBaseline: "middle", fillStyle: "#fff" });
  ctx.font = `${Math.floor(0.72 * SIDE)}px system-ui, sans-serif`;
  ctx.fillText(text, SIDE / 2, 0.54 * SIDE, SIDE);
  return ctx.canvas.transferToImageBitmap();
}

/** @param {{source: string, picture: ImageBitmap | null}} face a picture that cannot be read stays a plain ball */
async function load(face) {
  const image = new Image();
  image.src = face.source;
  const read = await image.decode().then(() => true, () => false);
  if (!read) return;
  const ctx = sheetContext(SIDE, SIDE);
  ctx.arc(SIDE / 2, SIDE / 2, SIDE / 2, 0, 2 * Math.PI);
  ctx.clip();
  const side = Math.min(image.naturalWidth, image.naturalHeight) || SIDE;
  const [x, y] = [(image.naturalWidth - side) / 2, (image.naturalHeight - side) / 2];
  ctx.drawImage(image, x, y, side, side, 0, 0, SIDE, SIDE);
  face.picture = ctx.canvas.transferToImageBitmap();
}
