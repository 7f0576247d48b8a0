// Hands a text to the clipboard, or leaves it marked for the keys.

/**
 * @param {HTMLInputElement} field hidden until it is needed; shows the text
 * @param {string} text
 * @returns {Promise<boolean>} whether it was copied; false without permission, or on a page that came by plain HTTP
 */
export async function copyFrom(field, text) {
  field.hidden = false;
  field.value = text;
  field.select();
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false;
  }
}
