// The record of a player's guesses at the balls of the day. Pure.

import { isRecord } from "../util/stored.js";

const BOARD = "triangle-9"; // each of its bins is as wide as a finger on the narrowest phone
const DAY_MS = 24 * 3600 * 1000;
const MARKS = 5;

/**
 * @typedef {object} Book
 * @property {string} day the last one played, as yyyymmdd
 * @property {number} guess the bin guessed on it
 * @property {number | null} bin where its ball landed; null if it did not
 * @property {number} streak days played in a row until then
 * @property {number} best the longest streak
 * @property {number} right days on which the guess was right
 * @property {number} played days
 */

/**
 * The ball of the day, the same for everybody: its seed is the date in UTC.
 * @param {number} nowMs
 * @returns {{board: string, seed: string}}
 */
export function ballOfDay(nowMs) {
  return { board: BOARD, seed: new Date(nowMs).toISOString().slice(0, 10).replaceAll("-", "") };
}

/** @param {number} nowMs @returns {number} ms until the next ball */
export const untilNext = (nowMs) => DAY_MS - (nowMs % DAY_MS);

/** @param {unknown} value @returns {value is Book} */
export function isBook(value) {
  return isRecord(value) && typeof value.day === "string" && (value.bin === null || Number.isInteger(value.bin))
    && ["guess", "streak", "best", "right", "played"].every((name) => Number.isInteger(value[name]));
}

/**
 * @param {Book | null} book @param {number} nowMs @returns {number} days in a row, until today or until yesterday
 */
export function streakAt(book, nowMs) {
  const days = [nowMs, nowMs - DAY_MS].map((ms) => ballOfDay(ms).seed);
  return book && days.includes(book.day) ? book.streak : 0;
}

/**
 * @param {Book | null} book before today's guess
 * @param {number} nowMs
 * @param {number} guess
 * @param {number | null} bin
 * @returns {Book}
 */
export function withGuess(book, nowMs, guess, bin) {
  const streak = streakAt(book, nowMs) + 1;
  return {
    day: ballOfDay(nowMs).seed, guess, bin, streak, best: Math.max(streak, book?.best ?? 0),
    right: (book?.right ?? 0) + Number(guess === bin), played: (book?.played ?? 0) + 1,
  };
}

/** @param {Pick<Book, "guess" | "bin">} book @returns {string} how close the guess was, without telling where the ball lands */
export function marksOf({ guess, bin }) {
  const off = bin === null ? MARKS : Math.min(MARKS, Math.abs(guess - bin));
  return off === 0 ? "🎯" : "🟡".repeat(MARKS - off) + "⚪".repeat(off);
}
