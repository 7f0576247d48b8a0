// Demo credits: what a player has, as a function of which events are known. No event counts twice.

/**
 * Amounts are whole minor units. A staked drop is known by its session and its number there: both are
 * the server's, from its receipt. Whatever is heard of it again, by whichever tab, changes nothing.
 *
 * @typedef {object} Staked a drop that the server has acknowledged
 * @property {number} stake
 * @property {number | null} payout null while it falls
 * @property {number} [ball] what the table calls its ball, while it falls
 * @property {string} [seed] that it started by, while it falls
 *
 * @typedef {object} Stay one session
 * @property {string} room
 * @property {Record<string, Staked>} drops by number
 * @property {number} [total] of its drops, once it is over
 *
 * @typedef {object} Account
 * @property {number} grants times that credits were given
 * @property {Record<string, Stay>} sessions by id, in the order in which they were heard of
 * @property {{staked: number, paid: number}} before of sessions that are put away
 * @property {string[]} away ids of those, the latest last
 *
 * @typedef {{type: "granted", number: number}
 *   | {type: "staked", session: string, drop: number, stake: number, room: string, ball?: number,
 *      seed?: string}
 *   | {type: "settled", session: string, drop: number, payout: number}
 *   | {type: "over", session: string, total: number}} AccountEvent
 */

/**
 * @typedef {{session: string, room: string, drop: number, stake: number, ball?: number,
 *   seed?: string}} OpenDrop
 */

export const GRANT = 100_000; // minor units of demo credits, given at first and by each refill
const REFILL_BELOW = GRANT / 10;
const KEPT = 20; // sessions that are over whose drops are held one by one
const AWAY = 500; // ids of sessions of which no event counts any more

/** @returns {Account} a new player's */
export function newAccount() {
  return { grants: 1, sessions: {}, before: { staked: 0, paid: 0 }, away: [] };
}

/**
 * @param {Account} account
 * @param {AccountEvent} event
 * @returns {Account} the same object where the event was known already
 */
export function applied(account, event) {
  if (event.type === "granted") {
    return event.number === account.grants + 1 ? { ...account, grants: event.number } : account;
  }
  if (account.away.includes(event.session)) return account;
  const stay = account.sessions[event.session];
  if (event.type === "over") {
    if (!stay || stay.total !== undefined) return account;
    return withStay(account, event.session, { ...stay, total: event.total });
  }
  const known = stay?.drops[event.drop];
  if (event.type === "staked") {
    if (known) return account;
    const { stake, ball, seed } = event;
    const drop = { stake, payout: null, ball, seed };
    return withDrop(account, event, stay ?? { room: event.room, drops: {} }, drop);
  }
  if (!known || known.payout !== null) return account;
  return withDrop(account, event, stay, { stake: known.stake, payout: event.payout });
}

/**
 * @param {Account} account
 * @param {{session: string, drop: number}} place
 * @param {Stay} stay
 * @param {Staked} drop
 */
function withDrop(account, { session, drop: number }, stay, drop) {
  return withStay(account, session, { ...stay, drops: { ...stay.drops, [number]: drop } });
}

/** @param {Account} account @param {string} session @param {Stay} stay */
function withStay(account, session, stay) {
  return putAway({ ...account, sessions: { ...account.sessions, [session]: stay } });
}

/**
 * The oldest sessions that are over become a sum, so that an account stays small.
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

/** Whether nothing can be heard of it any more. @param {Stay} stay */
function isDone({ drops, total }) {
  const known = Object.values(drops);
  return known.length === total && known.every(isSettled);
}

/** @param {Stay[]} stays @returns {{staked: number, paid: number}} */
function sums(stays) {
  const drops = stays.flatMap((stay) => Object.values(stay.drops));
  return {
    staked: drops.reduce((sum, { stake }) => sum + stake, 0),
    paid: drops.reduce((sum, { payout }) => sum + (payout ?? 0), 0),
  };
}

/** @param {Account} account @returns {number} credits that are on no drop, minor units */
export function balanceOf(account) {
  const { staked, paid } = sums(Object.values(account.sessions));
  return account.grants * GRANT + account.before.paid + paid - account.before.staked - staked;
}

/** @param {Account} account @returns {AccountEvent | null} null where there is enough to play with */
export function refillOf(account) {
  if (balanceOf(account) >= REFILL_BELOW) return null;
  return { type: "granted", number: account.grants + 1 };
}

/**
 * @param {Account} account
 * @returns {OpenDrop[]} drops whose end has not been heard of
 */
export function openDrops(account) {
  return Object.entries(account.sessions).flatMap(([session, { room, drops }]) =>
    Object.entries(drops)
      .filter(([, drop]) => !isSettled(drop))
      .map(([number, { stake, ball, seed }]) => (
        { session, room, drop: Number(number), stake, ball, seed })));
}

/** @param {Account} account @param {string} session @returns {number} how many drops of it are known */
export function knownDrops(account, session) {
  return Object.keys(account.sessions[session]?.drops ?? {}).length;
}
