// Small helpers to find, make, fill and read elements. They throw if the page lacks an element.

import { t } from "../texts/text.js";

/** @import { Key } from "../texts/text.js" */

/**
 * @template {HTMLElement} [T=HTMLElement]
 * @param {string} id
 * @param {new () => T} [type] required class of the element
 * @returns {T}
 */
export function byId(id, type) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element #${id}`);
  if (type && !(element instanceof type)) throw new Error(`element #${id} is not an ${type.name}`);
  return /** @type {T} */ (element);
}

/**
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Record<string, string>} [attributes]
 * @param {...(Node | string)} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** @param {Element} element @returns {HTMLElement} */
export function parentOf(element) {
  const parent = element.parentElement;
  if (!parent) throw new Error(`element #${element.id} has no parent element`);
  return parent;
}

/** @param {string} name @returns {HTMLInputElement[]} the radio buttons of a choice */
export function radiosOf(name) {
  return [...document.querySelectorAll("input")].filter((input) => input.name === name);
}

/** @param {string} name @returns {string} the value of the checked radio button */
export function radioValue(name) {
  const checked = radiosOf(name).find((radio) => radio.checked);
  if (!checked) throw new Error(`no radio button of ${name} is checked`);
  return checked.value;
}

/** Checks the radio button of a choice that has this value. @param {string} name @param {string | number} value */
export function check(name, value) {
  for (const radio of radiosOf(name)) radio.checked = radio.value === String(value);
}

/**
 * A radio button that looks like a chip.
 * @param {string} name @param {string} value @param {string} text on it @param {string} [words] for screen readers
 */
export function chip(name, value, text, words = text) {
  const radio = make("input", { type: "radio", name, value, "aria-label": words });
  return make("label", { class: "chip" }, radio, make("span", {}, text));
}

/** Replaces the submission of a form by an action. @param {string} id of the form @param {() => void} [act] */
export function onSubmit(id, act = () => {}) {
  byId(id, HTMLFormElement).addEventListener("submit", (event) => {
    event.preventDefault();
    act();
  });
}

/** @param {string} name of radio buttons @param {() => void} chosen called when the visitor checks one of them */
export function onChoice(name, chosen) {
  for (const radio of radiosOf(name)) radio.addEventListener("change", chosen);
}

/** @param {string} id of a button @param {() => void} press */
export function onClick(id, press) {
  byId(id).addEventListener("click", press);
}

/**
 * @param {HTMLFormElement} form
 * @param {string} name
 * @returns {HTMLInputElement | HTMLSelectElement | RadioNodeList} the form's control of that name
 */
export function fieldOf(form, name) {
  const found = form.elements.namedItem(name);
  if (found instanceof HTMLInputElement || found instanceof HTMLSelectElement) return found;
  if (found instanceof RadioNodeList) return found;
  throw new Error(`form #${form.id} has no field ${name}`);
}

/** @param {HTMLFormElement} form @param {string} name @returns {HTMLInputElement} */
export function inputOf(form, name) {
  const field = fieldOf(form, name);
  if (!(field instanceof HTMLInputElement)) throw new Error(`field ${name} is not an input`);
  return field;
}

const LONG = 46; // characters of a message that is written smaller, so that it is whole on any screen

/** @param {HTMLElement} line @param {string} text */
export function putMessage(line, text) {
  line.textContent = text;
  line.classList.toggle("long", text.length > LONG);
}

/** @param {HTMLElement} note @param {"" | "good" | "bad"} tone @param {string} text */
export function say(note, tone, text) {
  note.dataset.tone = tone;
  note.textContent = text;
}

/** @param {Event} event @param {string} selector @returns {boolean} whether the event's target is in an element that the selector matches */
export function isWithin(event, selector) {
  return event.target instanceof Element && event.target.closest(selector) !== null;
}

/** @typedef {[Key, string | Node | (string | Node)[]]} Fact name and value */

/**
 * Fills a definition list.
 * @param {HTMLElement} list
 * @param {Fact[]} facts
 */
export function fillFacts(list, facts) {
  list.replaceChildren(...facts.map(([name, value]) => {
    const data = make("dd", {}, ...(Array.isArray(value) ? value : [value]));
    data.dataset.fact = factId(name);
    return make("div", {}, make("dt", {}, t(name)), data);
  }));
}

/** @param {Key} key of a fact's name @returns {string} the value of data-fact, the same in every language */
export function factId(key) {
  return key.replace(/^fact\./, "");
}
