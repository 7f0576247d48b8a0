// Makes the browser keep the pages that work offline, by a service worker.

import { language } from "../texts/text.js";

const RELEASE = /\/v-([0-9a-f]{16})\//;
const WORKER = new URL("../../../sw.js", import.meta.url); // next to the release

/**
 * Registers this release's service worker after the page has loaded; browsers allow it only over HTTPS.
 * A page in another site's frame registers none.
 */
export function keepOffline() {
  if (window.top !== window) return;
  const [, release = "none"] = RELEASE.exec(import.meta.url) ?? [];
  const register = () => {
    // If the registration fails, as where storage is blocked, the pages work as before while the server is reachable.
    navigator.serviceWorker?.register(`${WORKER}?${release}-${language}`).catch(() => {});
  };
  if (document.readyState === "complete") register();
  else window.addEventListener("load", register, { once: true });
}
