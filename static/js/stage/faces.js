// The pictures of balls in a show: an emoji or a small picture for each name, painted over the ball.

import { sheetContext } from "../util/canvas.js";

/** @import { Board } from "../model/board.js" */
/** @import { SceneBall } from "../model/scene.js" */
/** @import { Geometry } from "../paint/geometry.js" */

const SIDE = 96; // pixels of a picture, enough for a ball on a large screen
const LEAST = 11; // CSS pixels: the smallest radius at which a face can be recognised
const RIM = 0.12; // of the radius

/** @typedef {{source: string, picture: ImageBitmap | null}} Face null: not yet loaded, or unreadable */

/** The faces by name. */
export class Faces {
  /** @type {Map<string, Face>} */
  #known = new Map();

  /** @param {Record<string, string>} sources an emoji or a `data:` URL for each name */
  set(sources) {
    const old = this.#known;
    this.#known = new Map();
    for (const [name, source] of Object.entries(sources)) {
      const known = old.get(name);
      const face = known?.source === source ? known : { source, picture: null };
      this.#known.set(name, face);
      if (face !== known) void paint(face);
    }
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

/** Paints a face's picture; a ball whose picture cannot be read stays plain. @param {Face} face */
async function paint(face) {
  const ctx = sheetContext(SIDE, SIDE);
  if (face.source.startsWith("data:")) {
    const image = new Image();
    image.src = face.source;
    const read = await image.decode().then(() => true, () => false);
    if (!read) return;
    ctx.arc(SIDE / 2, SIDE / 2, SIDE / 2, 0, 2 * Math.PI);
    ctx.clip();
    const side = Math.min(image.naturalWidth, image.naturalHeight) || SIDE;
    const [x, y] = [(image.naturalWidth - side) / 2, (image.naturalHeight - side) / 2];
    ctx.drawImage(image, x, y, side, side, 0, 0, SIDE, SIDE);
  } else {
    Object.assign(ctx, { textAlign: "center", textBaseline: "middle", fillStyle: "#fff" });
    ctx.font = `${Math.floor(0.72 * SIDE)}px system-ui, sans-serif`;
    ctx.fillText(face.source, SIDE / 2, 0.54 * SIDE, SIDE);
  }
  face.picture = ctx.canvas.transferToImageBitmap();
}
