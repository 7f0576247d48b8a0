// Saves a drop's film as a file. Requested by a script, not a link, so that a page can show why a server makes none.

import { saveFile } from "../util/file.js";
import { request } from "./api.js";
import { dropPath } from "./drop-address.js";

/** @import { DropAddress } from "./drop-address.js" */

const WIDTH = "480"; // pixels

/** Rejects with an ApiError if the server cannot make it. @param {DropAddress} drop */
export async function saveVideo(drop) {
  const reply = await request(dropPath(drop, ".mp4", new URLSearchParams({ width: WIDTH })));
  saveFile(`plinko-${drop.seed}.mp4`, await reply.blob(), "video/mp4");
}
