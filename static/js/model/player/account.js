// A player's account (balance, statistics, history), computed from a set of events.
// An event that arrives twice counts once. All panels show `viewOf` the account.

import { isRecord, parseStored } from "../../util/stored.js";
import { Mean } from "../mean.js";

/**
 * Amounts are whole minor units. A staked drop is identified by its session and its number there, which
 * the server assigns in the receipt. So an event that another tab has already added changes nothing.
 *
 * @typedef {object} Staked a staked drop that the server has acknowledged
 * @property {number} stake
 * @property {number | null} payout null while the ball falls
 * @property {number} [ball] the ball's number at the table, while it falls
 * @property {string} [seed] while it falls
 * @property {number | null} [aim] m, while it falls, if the player aimed
 *
 * @typedef {object} Stay one fair session
 * @property {string} room
 * @property {Record<string, Staked>} drops by number: the latest, and those that fall
 * @property {{count: number, staked: number, paid: number}} [folded] its first drops, which have all landed
 * @property {number} [total] number of its drops, after it has ended
 *
 * @typedef {object} Tally since the player last reset the statistics
 * @property {number} settled stakes of the drops that have landed
 * @property {number} paid
 * @property {number} wins drops that paid more than their stake
 * @property {number} losses drops that paid less
 * @property {number} best the highest multiplier
 * @property {number[]} curve profit, after each of `every` drops
 * @property {number} every
 * @property {{count: number, mean: number, square: number}} scores payout / stake of each drop, as a Mean
 *
 * @typedef {{session: string, drop: number}} FairPlace a session, and a drop's number there
 *
 * @typedef {object} Played one of the player's drops that has landed
 * @property {string} board a preset's name or a digest, as REST accepts it
 * @property {string} name the board's name
 * @property {string} seed decimal
 * @property {number | null} x explicit start in metres, null if the seed drew it
 * @property {number | null} [aim] metres, if the player aimed
 * @property {number | null} bin null if the ball did not land
 * @property {number} score payout / stake
 * @property {boolean} [knocked] whether other balls may have touched this one, so that its path does not
 *   follow from its seed
 * @property {number} stake credits, 0 in practice
 * @property {number} paid credits
 * @property {string | null} [digest] the drop's, or its first digits, as the table sent it
 * @property {string} [boardDigest]
 * @property {FairPlace} [fair] of a staked drop
 * @property {boolean} [practice] whether it was dropped without a stake
 * @property {string} [by] the player's name
 * @property {string} [ref] of this page's drop message
 *
 * @typedef {object} Account
 * @property {number} grants how many times credits were granted
 * @property {number} [granted] their sum
 * @property {Tally} tally
 * @property {Played[]} last drops, the newest first
 * @property {Record<string, Stay>} sessions by id, oldest first
 * @property {{staked: number, paid: number}} before sums of the archived sessions
 * @property {string[]} away ids of archived sessions, the latest last
 *
 * @typedef {{type: "granted", number: number, amount: number}
 *   | {type: "practised", played: Played} | {type: "reset"}
 *   | {type: "staked", session: string, drop: number, stake: number, room: string, ball?: number,
 *      seed?: string, aim?: number | null}
 *   | {type: "settled", session: string, drop: number, payout: number, played?: Played}
 *   | {type: "corrected", session: string, drop: number, payout: number}
 *   | {type: "over", session: string, total: number, room?: string}} AccountEvent
 */

/**
 * @typedef {{session: string, room: string, drop: number, stake: number, ball?: number,
 *   seed?: string, aim?: number | null}} OpenDrop
 */

export const MINOR_UNITS = 100; // of a credit: the server counts stakes in hundredths
export const GRANT = 1000 * MINOR_UNITS; // a new player's credits
const LAST = 30; // drops in the history
const CURVE = 240; // points of the profit curve
const KEPT = 5; // ended sessions that are kept apart
const UNFOLDED = 50; // landed drops of a session that are kept one by one: the account is stored at each event
const AWAY = 500; // ids kept of archived sessions, whose late events are ignored

/** @returns {Account} */
export function newAccount() {
  return { grants: 1, sessions: {}, before: { staked: 0, paid: 0 }, away: [], tally: newTally(), last: [] };
}

/** @returns {Tally} */
function newTally() {
  return {
    settled: 0, paid: 0, wins: 0, losses: 0, best: 0, curve: [], every: 1, scores: { ...new Mean() },
  };
}

/**
 * @param {Account} account
 * @param {AccountEvent} event
 * @returns {Account} the same object if the event changes nothing
 */
export function applied(account, event) {
  if (event.type === "granted") {
    if (event.number !== account.grants + 1) return account;
    return { ...account, grants: event.number, granted: grantedOf(account) + event.amount };
  }
  if (event.type === "reset") return { ...account, tally: newTally(), last: [] };
  if (event.type === "practised") return { ...account, last: [event.played, ...account.last].slice(0, LAST) };
  if (account.away.includes(event.session)) return account;
  const stay = account.sessions[event.session];
  if (event.type === "over") {
    // Of a session whose receipts never arrived the account knows only that it has drops.
    const left = stay ?? (event.room !== undefined && event.total > 0 ? { room: event.room, drops: {} } : null);
    if (!left || left.total !== undefined) return account;
    return withStay(account, event.session, { ...left, total: event.total });
  }
  if (event.drop < foldedOf(stay).count) return account;
  const known = stay?.drops[event.drop];
  if (event.type === "staked") {
    if (known) return account;
    const { stake, ball, seed, aim } = event;
    const drop = { stake, payout: null, ball, seed, ...(aim && { aim }) };
    return withDrop(account, event, stay ?? { room: event.room, drops: {} }, drop);
  }
  if (!known || (known.payout === null) !== (event.type === "settled")) return account;
  const { payout } = event;
  if (payout === known.payout) return account;
  const landed = { stake: known.stake, payout };
  if (event.type === "corrected") {
    const tally = { ...account.tally, paid: account.tally.paid + payout - (known.payout ?? 0) };
    return withDrop({ ...account, tally }, event, stay, landed);
  }
  const last = event.played ? [event.played, ...account.last].slice(0, LAST) : account.last;
  return withDrop({ ...account, tally: counted(account.tally, landed), last }, event, stay, landed);
}

/** @param {Tally} tally @param {{stake: number, payout: number}} landed @returns {Tally} */
function counted(tally, { stake, payout }) {
  const scores = new Mean(tally.scores);
  scores.add(payout / stake);
  const [settled, paid] = [tally.settled + stake, tally.paid + payout];
  let { curve, every } = tally;
  if (scores.count % every === 0) curve = [...curve, paid - settled];
  if (curve.length > CURVE) [curve, every] = [curve.filter((_, i) => i % 2), 2 * every];
  return {
    ...tally, settled, paid, curve, every, scores: { ...scores },
    wins: tally.wins + Number(payout > stake), losses: tally.losses + Number(payout < stake),
    best: Math.max(tally.best, payout / stake),
  };
}

/**
 * @param {Account} account
 * @param {{session: string, drop: number}} place
 * @param {Stay} stay
 * @param {Staked} drop
 */
function withDrop(account, { session, drop: number }, stay, drop) {
  return withStay(account, session, fold({ ...stay, drops: { ...stay.drops, [number]: drop } }));
}

/** @param {Stay} [stay] */
const foldedOf = (stay) => stay?.folded ?? { count: 0, staked: 0, paid: 0 };

/** Replaces a session's oldest drop by its sums, if it has landed and many came after it. @param {Stay} stay @returns {Stay} */
function fold(stay) {
  const folded = foldedOf(stay);
  const { [folded.count]: first, ...drops } = stay.drops;
  if (!first || first.payout === null || Object.keys(drops).length < UNFOLDED) return stay;
  const { count, staked, paid } = folded;
  return fold({ ...stay, drops, folded: { count: count + 1, staked: staked + first.stake, paid: paid + first.payout } });
}

/** @param {Account} account @param {string} session @param {Stay} stay */
function withStay(account, session, stay) {
  return putAway({ ...account, sessions: { ...account.sessions, [session]: stay } });
}

/**
 * Archives the oldest ended sessions as a sum, so that an account stays small.
 * @param {Account} account
 */
function putAway(account) {
  const entries = Object.entries(account.sessions);
  const over = entries.filter(([, stay]) => isDone(stay));
  const old = over.slice(0, Math.max(0, over.length - KEPT));
  if (old.length === 0) return account;
  const ids = old.map(([id]) => id);
  const { staked, paid } = sums(old.map(([, stay]) => stay));
  return {
    ...account,
    sessions: Object.fromEntries(entries.filter(([id]) => !ids.includes(id))),
    before: { staked: account.before.staked + staked, paid: account.before.paid + paid },
    away: [...account.away, ...ids].slice(-AWAY),
  };
}

/** @param {Staked} drop */
const isSettled = ({ payout }) => payout !== null;

/** Whether every drop of an ended session is known and settled. @param {Stay} stay */
function isDone(stay) {
  return countOf(stay) === stay.total && Object.values(stay.drops).every(isSettled);
}

/** @param {Stay} stay @returns {number} how many of its drops are known */
const countOf = (stay) => foldedOf(stay).count + Object.keys(stay.drops).length;

/** @param {Stay[]} stays @returns {{staked: number, paid: number}} */
function sums(stays) {
  const drops = stays.flatMap((stay) => Object.values(stay.drops));
  const folded = stays.map(foldedOf);
  return {
    staked: drops.reduce((sum, { stake }) => sum + stake, folded.reduce((sum, { staked }) => sum + staked, 0)),
    paid: drops.reduce((sum, { payout }) => sum + (payout ?? 0), folded.reduce((sum, { paid }) => sum + paid, 0)),
  };
}

/** @param {Account} account @returns {number} minor units, without the stakes of balls in flight */
export function balanceOf(account) {
  const { staked, paid } = sums(Object.values(account.sessions));
  return grantedOf(account) + account.before.paid + paid - account.before.staked - staked;
}

/** @param {Account} account */
const grantedOf = ({ grants, granted }) => granted ?? grants * GRANT;

/** @param {Account} account @returns {AccountEvent} grants what the balance lacks of GRANT; a whole GRANT if nothing */
export function refillOf(account) {
  const missing = GRANT - balanceOf(account);
  return { type: "granted", number: account.grants + 1, amount: missing > 0 ? missing : GRANT };
}

/**
 * The figures that panels show, in credits: all but the balance are of drops that have landed.
 * @param {Account} account
 * @param {number} held credits staked on drops that the server has not acknowledged yet
 */
export function viewOf(account, held) {
  const { settled, paid, curve, every, wins, losses, best, scores } = account.tally;
  const credits = (/** @type {number} */ minor) => minor / MINOR_UNITS;
  return {
    balance: credits(balanceOf(account) - Math.round(held * MINOR_UNITS)),
    staked: credits(settled),
    returned: credits(paid),
    profit: credits(paid - settled),
    balls: scores.count, wins, losses, best, scores: new Mean(scores),
    curve: [0, ...curve, paid - settled].map(credits), // after each of `every` balls, and after all
    every,
    last: account.last,
  };
}

/**
 * @param {Account} account
 * @returns {OpenDrop[]} drops whose payout is not known yet
 */
export function openDrops(account) {
  return Object.entries(account.sessions).flatMap(([session, { room, drops }]) =>
    Object.entries(drops)
      .filter(([, drop]) => !isSettled(drop))
      .map(([number, { stake, ball, seed, aim }]) => (
        { session, room, drop: Number(number), stake, ball, seed, ...(aim && { aim }) })));
}

/** @param {Account} account @param {string} session @returns {number} how many drops of the session are known */
export function knownDrops(account, session) {
  const stay = account.sessions[session];
  return stay ? countOf(stay) : 0;
}

/** @param {Account} account @returns {string[]} ended sessions of which some drops are not known */
export function incompleteSessions(account) {
  const sessions = Object.entries(account.sessions);
  return sessions.filter(([id, { total = 0 }]) => knownDrops(account, id) < total).map(([id]) => id);
}

/** @param {string} text as stored @returns {Account | null} null if it is damaged */
export function readAccount(text) {
  const kept = parseStored(text, isRecord);
  const account = { ...newAccount(), ...kept };
  return kept && isAccount(account) ? account : null;
}

/** @param {unknown} value a whole number, 0 or more */
const isCount = (value) => Number.isSafeInteger(value) && Number(value) >= 0;

/** @param {unknown} value @returns {value is Record<string, any>[]} */
const isRecords = (value) => Array.isArray(value) && value.every(isRecord);

/** @param {Record<string, any>} value @returns {value is Account} */
function isAccount({ grants, granted, sessions, before, away, tally, last }) {
  return isCount(grants) && (granted === undefined || isCount(granted)) && isRecord(sessions)
    && Object.values(sessions).every(isStay) && isRecord(before) && isCount(before.staked) && isCount(before.paid)
    && Array.isArray(away) && isTally(tally) && isRecords(last)
    && last.every(({ seed, score, stake }) => typeof seed === "string" && Number.isFinite(score) && Number.isFinite(stake));
}

/** @param {unknown} stay */
function isStay(stay) {
  return isRecord(stay) && typeof stay.room === "string" && (stay.folded === undefined || (isRecord(stay.folded)
    && [stay.folded.count, stay.folded.staked, stay.folded.paid].every(isCount))) && (stay.total === undefined || isCount(stay.total))
    && isRecord(stay.drops) && Object.values(stay.drops).every((drop) =>
      isRecord(drop) && isCount(drop.stake) && (drop.payout === null || isCount(drop.payout)));
}

/** @param {unknown} tally */
function isTally(tally) {
  return isRecord(tally) && [tally.settled, tally.paid, tally.wins, tally.losses, tally.every].every(isCount)
    && Number.isFinite(tally.best) && Array.isArray(tally.curve) && tally.curve.every(Number.isFinite)
    && isRecord(tally.scores) && Object.values(tally.scores).every(Number.isFinite);
}
