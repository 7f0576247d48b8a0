// The part of the drawer from which a player asks the server for their last drops.

import { byId } from "../../util/dom.js";

/** @import { Mark } from "./mark.js" */

/** @param {Mark} mark */
export function showRecall(mark) {
  const show = () => {
    const plays = `api/v1/players/${mark.value}/plays`;
    byId("plays-json", HTMLAnchorElement).href = plays;
    byId("plays-csv", HTMLAnchorElement).href = `${plays}?format=csv`;
  };
  byId("mark-renew").addEventListener("click", () => {
    mark.renew();
    show();
  });
  show();
}
