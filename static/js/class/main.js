// Starts the page for a class, with the lesson of its address.

import { openPage, showState } from "../board/page.js";
import { openSolver } from "../solver/solver.js";
import { t } from "../texts/text.js";
import { LessonPage } from "./page.js";

openPage(async (theme) => {
  const page = new LessonPage(theme, await openSolver());
  showState("live", t("play.ready"));
  page.show();
});
