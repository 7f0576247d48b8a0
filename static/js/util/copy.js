// Copies a text to the clipboard, or shows it selected, ready to copy by keys.

/**
 * @param {HTMLInputElement} field becomes visible with the text
 * @param {string} text
 * @returns {Promise<boolean>} whether it was copied; false without permission or HTTPS
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
