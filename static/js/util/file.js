// Lets the visitor keep a text as a file.

import { make } from "./dom.js";

/** @param {string} name of the file @param {string} text @param {string} type its media type */
export function saveFile(name, text, type) {
  const url = URL.createObjectURL(new Blob([text], { type }));
  const link = make("a", { href: url, download: name });
  link.click();
  // The browser has begun to read it; the address is not needed again.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
