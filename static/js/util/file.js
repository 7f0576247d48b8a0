// Lets the visitor keep a text, or bytes, as a file.

import { make } from "./dom.js";

/** @param {string} name of the file @param {string | Blob} content @param {string} type its media type */
export function saveFile(name, content, type) {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = make("a", { href: url, download: name });
  link.click();
  // The browser has begun to read it; the address is not needed again.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
