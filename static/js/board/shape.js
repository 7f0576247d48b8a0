// Gives the style sheet the board's proportions, so that cabinet and desk fit the window.

/** @param {number} ratio width over height, without the headroom */
export function announceShape(ratio) {
  const { dataset, style } = document.documentElement;
  style.setProperty("--board-ratio", ratio.toFixed(4));
  dataset.shape = ratio < 1 ? "tall" : "wide";
}
