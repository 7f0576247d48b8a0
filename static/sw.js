// The service worker: caches the pages, which work without a server. Its address contains the release, so that each
// release has its own worker and cache, and the language. js/util/offline.js registers it.

// `plinko site` makes it true: then boards are files of the release, and pages in other languages are in folders.
const SITE = false;
const { search } = new URL(self.location.href);
const [RELEASE, LANGUAGE] = search.slice(1).split("-");
const CACHE = `plinko${search}`;
const FOLDER = SITE && LANGUAGE !== "en" ? `${LANGUAGE}/` : "";
const PAGES = ["", "sandbox.html", "replay.html", "editor.html", "today.html", "verify.html", "class.html"].map((page) => FOLDER + page);

// Finds the files that a page or a module refers to.
const PARTS = {
  html: /(?:href|src)="([^":?#]+\.(?:css|js|json|svg))"/g,
  js: /^(?:import|export|\}) [^"\n]*"(\.[^"]+)"|import\("(\.[^"]+)"\)|new URL\("([^"]+)", ?import\.meta\.url\)/gm,
};

/** @param {string} path relative to the pages' folder @returns {string} URL */
const at = (path) => new URL(path, self.registration.scope).href;

/** @param {string} path below /api/v1 @returns {string} URL */
const reply = (path) => at(SITE ? `v-${RELEASE}/api/v1/${path}.json` : `api/v1/${path}`);

/** Caches the pages and every file that they refer to, directly or through others. */
async function keepPages() {
  const cache = await caches.open(CACHE);
  const seen = new Set(PAGES.map(at));
  for (const url of seen) {
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url} could not be loaded: HTTP status ${response.status}`);
    const { pathname } = new URL(url);
    const kind = pathname.endsWith("/") ? "html" : /\.(?:html|js)$/.exec(pathname)?.[0].slice(1);
    if (kind) {
      const text = await response.clone().text();
      for (const [, ...parts] of text.matchAll(PARTS[kind])) {
        seen.add(new URL(parts.find(Boolean) ?? "", url).href);
      }
    }
    await cache.put(url, response);
  }
}

/** Caches the list of boards and the house table's presets with their odds; others once they were opened. */
async function keepBoards() {
  const cache = await caches.open(CACHE);
  const list = await fetch(reply("boards"));
  const { boards } = await list.clone().json();
  await cache.put(reply("boards"), list);
  for (const { world, name } of boards) {
    if (world !== "house") continue;
    await cache.add(reply(`boards/${name}`));
    if (SITE) await cache.add(reply(`boards/${name}/odds`));
  }
}

async function forgetOtherReleases() {
  for (const name of await caches.keys()) if (name !== CACHE) await caches.delete(name);
  await self.clients.claim();
}

/** @param {string} path below the scope @returns {"first" | "last" | null} when the cache is tried, if at all */
function turnOfCache(path) {
  if (/^v-[0-9a-f]{16}\//.test(path)) return "first";
  const kept = PAGES.includes(path) || /^(?:manifest\.json|favicon\.svg)$/.test(path);
  return kept || /^api\/v1\/boards(?:\/[\w-]+)?$/.test(path) ? "last" : null;
}

/** @param {string} url @param {Response} response */
async function keep(url, response) {
  try {
    await (await caches.open(CACHE)).put(url, response);
  } catch {
    // The storage is full or blocked: the page gets its response all the same, and stays as old offline.
  }
}

/** @param {Request} request */
async function fromNetwork(request) {
  const response = await fetch(request);
  if (response.ok) await keep(bare(request), response.clone());
  return response;
}

/** @param {Request} request @returns {string} its URL without the query, which does not change a page */
function bare(request) {
  const { origin, pathname } = new URL(request.url);
  return origin + pathname;
}

/** @param {Request} request @param {"first" | "last"} turn */
async function answer(request, turn) {
  const kept = () => caches.match(bare(request)).catch(() => undefined); // blocked is as good as empty
  if (turn === "first") return (await kept()) ?? fromNetwork(request);
  try {
    return await fromNetwork(request);
  } catch (error) {
    const found = await kept();
    if (found) return found;
    throw error;
  }
}

self.addEventListener("install", (event) => {
  event.waitUntil(keepPages().then(keepBoards).then(() => self.skipWaiting()));
});
self.addEventListener("activate", (event) => event.waitUntil(forgetOtherReleases()));
self.addEventListener("fetch", (event) => {
  const { request } = event;
  const { scope } = self.registration;
  if (request.method !== "GET" || !request.url.startsWith(scope)) return;
  const turn = turnOfCache(bare(request).slice(scope.length));
  if (turn) event.respondWith(answer(request, turn));
});
