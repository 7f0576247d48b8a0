// Saves a text or bytes as a file on the visitor's disk.

import { make } from "./dom.js";

/** @param {string} name of the file @param {string | Blob} content @param {string} type its media type */
export function saveFile(name, content, type) {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = make("a", { href: url, download: name });
  link.click();
  // By then the browser has begun to read, and no longer needs the URL.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
