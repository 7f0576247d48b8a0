// The sandbox page: opens the room that the address names, or the public one.

import { openPage } from "../board/page.js";
import { SandboxPage } from "./page.js";

const PUBLIC_ROOM = "sandbox";

openPage((theme) => {
  const asked = new URLSearchParams(window.location.search);
  new SandboxPage(theme, asked.get("room") || PUBLIC_ROOM);
});
