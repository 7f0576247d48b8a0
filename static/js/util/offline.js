// Has the browser keep the pages that need no server, for when there is none.

import { language } from "../texts/text.js";

const RELEASE = /\/v-([0-9a-f]{16})\//;

/**
 * Registers this release's worker once the page itself is there; browsers allow it over HTTPS alone.
 * A page in another site's frame leaves nothing behind.
 */
export function keepOffline() {
  if (window.top !== window) return;
  const [, release = "none"] = RELEASE.exec(import.meta.url) ?? [];
  const register = () => {
    const url = new URL(`sw.js?${release}-${language}`, document.baseURI);
    // Where it is not allowed, or the server is gone already, the pages work as they are.
    navigator.serviceWorker?.register(url).catch(() => {});
  };
  if (document.readyState === "complete") register();
  else window.addEventListener("load", register, { once: true });
}
