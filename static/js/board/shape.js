// Tells the style sheet the shape of what is drawn, so that cabinet and desk fit the window.

/** @param {number} ratio width over height of the part that scales */
export function announceShape(ratio) {
  const { dataset, style } = document.documentElement;
  style.setProperty("--board-ratio", ratio.toFixed(4));
  dataset.shape = ratio < 1 ? "tall" : "wide";
}
