// The drawer of what a player sets once: here light or dark; sound is js/play/sound/choice.js.

import { SCHEMES } from "../../paint/theme.js";
import { radiosOf } from "../../util/dom.js";

/** @import { Theme } from "../../paint/theme.js" */

/** @param {Theme} theme */
export function switchScheme(theme) {
  const radios = radiosOf("scheme");
  const show = () => {
    for (const radio of radios) radio.checked = radio.value === theme.scheme;
  };
  for (const radio of radios) {
    radio.addEventListener("change", () => {
      const scheme = SCHEMES.find((one) => one === radio.value);
      if (scheme) theme.choose(scheme);
    });
  }
  theme.onChange(show);
  show();
}
