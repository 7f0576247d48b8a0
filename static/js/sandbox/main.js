// Starts the sandbox page: a private box, or the room that the address names.

import { openPage } from "../board/page.js";
import { hasServer } from "../net/ask.js";
import { loadMachine } from "../solver/touching/machine.js";
import { SandboxPage } from "./page.js";

const PUBLIC_ROOM = "sandbox";

openPage(async (theme) => {
  const room = hasServer ? new URLSearchParams(window.location.search).get("room") : null;
  const machine = room || (hasServer && typeof WebAssembly === "undefined") ? null : await loadMachine();
  new SandboxPage(theme, machine ?? room ?? PUBLIC_ROOM);
});
