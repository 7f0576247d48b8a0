// Checks whether a fair session was honest: recomputes everything in its export, without the network.
//
// The steps and their names are those of `plinko verify`.

import { BoardError, ParameterError } from "../solver/errors.js";
import { PHYSICS_VERSION } from "../solver/digest.js";
import { t } from "../texts/text.js";
import { canonical } from "./canonical.js";
import { bytesOfHex, bytesOfText, hexOf, isSigned, sha256 } from "./crypto.js";
import { ExportError } from "./export.js";
import { isConsistent, isIncluded } from "./merkle.js";
import { MOST_PAYOUT, mostStake, payoutOf } from "../model/payout.js";
import { commitment, drawn, dropSeed } from "./seeds.js";

/** @import { Solver } from "../solver/solver.js" */
/** @import { Key } from "../texts/text.js" */
/** @import { ExportedDrop, KeyChange, Receipt, SessionExport, Signed, SignedReceipt } from "./export.js" */

/**
 * The result of one check. said: the value in the export; found: the recomputed one.
 * @typedef {object} Step
 * @property {string} name
 * @property {boolean} ok
 * @property {Key} text description for people
 * @property {unknown} said
 * @property {unknown} found
 * @property {number | null} drop number of the drop that was checked, null for the session
 *
 * @typedef {{solver: Solver, kernelDigest: string, key?: string}} Tools key: the server's, if
 *   known from another source
 */

/**
 * Runs all checks, in order.
 * @param {SessionExport} session
 * @param {Tools} tools
 * @returns {AsyncGenerator<Step>} throws an ExportError if the export is malformed
 */
export async function* checkSession(session, tools) {
  try {
    yield* new Check(session, tools).steps();
  } catch (error) {
    const known = error instanceof RangeError || error instanceof BoardError
      || error instanceof ParameterError;
    if (known) throw new ExportError(error.message);
    throw error;
  }
}

/** @param {string} name @param {Key} text @param {unknown} said @param {unknown} found
 *  @param {number | null} [drop] @returns {Step} */
function same(name, text, said, found, drop = null) {
  return { name, ok: canonical(said ?? null) === canonical(found ?? null), text, said, found, drop };
}

class Check {
  #session;
  #tools;
  #said;
  #head;
  /** The server's keys, the latest first. */
  #keys;
  #root;

  /** @param {SessionExport} session @param {Tools} tools */
  constructor(session, tools) {
    this.#session = session;
    this.#tools = tools;
    this.#said = /** @type {Record<string, string>} */ (session.session.statement);
    this.#head = /** @type {{size: number, root: string, log?: string}} */ (session.head.statement);
    const formers = (session.keys ?? []).map(({ statement }) => statement.former);
    this.#keys = [session.key, ...formers].map((key) => bytesOfHex(key, "key"));
    this.#root = bytesOfHex(this.#head.root, "head.root");
  }

  /** @returns {AsyncGenerator<Step>} */
  async* steps() {
    const { key, keys = [], drops, heard = [], heard_session: given } = this.#session;
    const { key: known } = this.#tools;
    if (known) yield same("key", "step.key", (await this.#leadsHere(known)) ? known : key, known);
    for (const [i, change] of keys.entries()) yield this.#changed(i, change);
    yield this.#signed("session", "step.session", this.#session.session);
    yield this.#signed("head", "step.head", this.#session.head);
    if (given) yield this.#heardSession(given);
    yield* this.#secrets();
    yield* this.#played();
    yield this.#counter();
    yield* this.#end();
    for (const drop of drops) {
      yield* this.#logged(drop);
      yield* this.#drop(drop);
    }
    for (const receipt of heard) yield this.#heard(receipt);
  }

  /** @param {number} i of the key @param {Record<string, unknown>} statement @param {string} signature */
  #isSignedBy(i, statement, signature) {
    return isSigned(this.#keys[i], bytesOfHex(signature, "signature", 64), bytesOfText(canonical(statement)));
  }

  /** Checks that the later key vouches for the earlier one. @param {number} i @param {KeyChange} change
   *  @returns {Promise<Step>} */
  async #changed(i, { statement, signature }) {
    const ok = statement.key === hexOf(this.#keys[i]) && await this.#isSignedBy(i, statement, signature);
    return { name: "keys", ok, text: "step.keys", said: statement.former, found: ok ? "valid" : "invalid", drop: null };
  }

  /** Whether this key is the server's, or has signed its successors up to that. @param {string} known */
  async #leadsHere(known) {
    let at = this.#session.key;
    for (const [i, { statement, former_signature: given }] of (this.#session.keys ?? []).entries()) {
      if (at === known || given === null || !await this.#isSignedBy(i + 1, statement, given)) break;
      at = String(statement.former);
    }
    return at === known;
  }

  /** @param {string} name @param {Key} text @param {Signed} signed @param {number | null} [drop]
   *  @returns {Promise<Step>} */
  async #signed(name, text, { statement, signature }, drop = null) {
    let ok = false;
    for (let i = 0; i < this.#keys.length && !ok; i++) ok = await this.#isSignedBy(i, statement, signature);
    return { name, ok, text, said: signature, found: ok ? "valid" : "invalid", drop };
  }

  /**
   * Compares the statement that the player received before revealing the client seed. Only this statement
   * proves that the server chose its seed first.
   * @param {Signed} heard
   * @returns {Promise<Step>}
   */
  async #heardSession(heard) {
    const signed = await this.#signed("heard-session", "step.heard-session", heard);
    if (!signed.ok) return signed;
    return same("heard-session", "step.heard-same", heard.statement, this.#session.session.statement);
  }

  /** @returns {AsyncGenerator<Step>} */
  async* #secrets() {
    const { client_seed: client, server_seed: server } = this.#session;
    const { client_commitment: clients, server_commitment: servers } = this.#said;
    for (const [name, secret, committed, closed, text] of /** @type {const} */ ([
      ["client-seed", client, clients, "step.client-closed", "step.client-same"],
      ["server-seed", server, servers, "step.server-closed", "step.server-same"],
    ])) {
      if (secret === null) {
        yield { name: `${name}-open`, ok: false, text: closed, said: null,
          found: t("step.found-secret"), drop: null };
        continue;
      }
      const found = hexOf(await commitment(bytesOfHex(secret, name)));
      yield same(name, text, committed, found);
    }
  }

  /** @returns {AsyncGenerator<Step>} */
  async* #played() {
    const { board } = this.#session;
    const said = this.#said;
    const { boardDigest } = this.#tools.solver.drop(board, { seed: 0 });
    yield same("board", "step.board", said.board_digest, boardDigest);
    const { multipliers } = /** @type {{multipliers: number[]}} */ (board.bins);
    const payouts = hexOf(await sha256(bytesOfText(canonical(multipliers))));
    yield same("payouts", "step.payouts", said.payouts_digest, payouts);
    yield same("physics", "step.physics", said.physics_version, PHYSICS_VERSION);
    yield same("kernel", "step.kernel", said.kernel_digest, this.#tools.kernelDigest);
    yield* this.#draw(boardDigest);
  }

  /** @param {string} board its digest @returns {AsyncGenerator<Step>} */
  async* #draw(board) {
    const { draw } = this.#session;
    const said = this.#said.draw_digest;
    if (said === undefined && draw === undefined) return;
    const found = draw && [hexOf(await sha256(bytesOfText(canonical(draw)))), draw.board_digest];
    yield same("draw", "step.draw", [said ?? null, board], found);
  }

  /** @returns {Step} */
  #counter() {
    const numbers = this.#session.drops.map(({ receipt }) => receipt.drop);
    const gap = numbers.findIndex((number, i) => number !== i);
    const text = "step.counter";
    if (gap < 0) return same("counter", text, numbers.length, numbers.length);
    return same("counter", text, numbers[gap], gap, gap);
  }

  /** @returns {AsyncGenerator<Step>} */
  async* #end() {
    const { end, server_seed: seed, drops } = this.#session;
    const text = "step.end";
    if (end === null) {
      yield { name: "end", ok: false, text, said: null, found: t("step.found-end"), drop: null };
      return;
    }
    yield this.#signed("end", text, end);
    const { statement } = end;
    yield same("end-session", "step.end-session", statement.session, this.#said.session);
    yield same("end-seed", "step.end-seed", statement.server_seed, seed);
    yield same("truncated", "step.truncated", statement.drops,
      drops.length);
    if (statement.void !== undefined) yield same("void", "step.void", statement.void, statement.void);
  }

  /** @param {ExportedDrop} drop @returns {AsyncGenerator<Step>} */
  async* #logged({ receipt, index, root, signature, inclusion, consistency }) {
    const number = receipt.drop;
    yield same("receipt-session", "step.receipt-session", receipt.session,
      this.#said.session, number);
    yield same("receipt-board", "step.receipt-board", receipt.board_digest,
      this.#said.board_digest, number);
    yield this.#entrySigned("receipt", { receipt, index, root, signature });
    const head = { size: this.#head.size, root: this.#root };
    const leaf = bytesOfText(canonical(receipt));
    const included = await isIncluded(leaf, { index, ...head }, hashes(inclusion));
    yield { name: "inclusion", ok: included, text: "step.inclusion", said: index,
      found: this.#head.root, drop: number };
    const then = { size: index + 1, root: bytesOfHex(root, "root") };
    const grew = await isConsistent(then, head, hashes(consistency));
    yield { name: "consistency", ok: grew, text: "step.consistency", said: root,
      found: this.#head.root, drop: number };
  }

  /** @param {string} name @param {SignedReceipt} entry */
  #entrySigned(name, { receipt, index, root, signature }) {
    const { log } = this.#head;
    const named = log === undefined ? {} : { log };
    const statement = { kind: "plinko log entry", version: 1, receipt, index, root, ...named };
    const text = "step.receipt";
    return this.#signed(name, text, { statement, signature }, receipt.drop);
  }

  /** @param {ExportedDrop} drop @returns {AsyncGenerator<Step>} */
  async* #drop({ receipt, result }) {
    const number = receipt.drop;
    const found = this.#tools.solver.drop(this.#session.board, { seed: receipt.seed, aim: receipt.aim });
    yield* this.#start(receipt, found);
    const { multipliers } = /** @type {{multipliers: number[]}} */ (this.#session.board.bins);
    const most = mostStake(multipliers);
    if (receipt.stake > most) {
      throw new ExportError(`stake ${receipt.stake} could pay more than ${MOST_PAYOUT} minor units, which not every `
        + `reader of JSON keeps exactly: with this board's multipliers a stake is at most ${most}`);
    }
    const payout = payoutOf(receipt.stake, found.score);
    if (result === null) {
      const owed = { bin: found.bin, payout };
      yield same("result", "step.result", null, owed, number);
      return;
    }
    yield same("trajectory", "step.trajectory", result.digest, found.digest, number);
    yield same("outcome", "step.outcome", endOf(result), endOf({
      bin: found.bin, score: found.score, t: found.duration, x_end: found.xEnd,
      unsettled: found.unsettled,
    }), number);
    yield same("payout", "step.payout", result.payout, payout, number);
  }

  /** @param {Receipt} receipt @param {{boardDigest: string, bin: number | null}} landed @returns {AsyncGenerator<Step>} */
  async* #start({ drop, seed, aim }, { boardDigest, bin }) {
    const picked = await this.#pick(drop, boardDigest);
    if (picked === null) return;
    if (picked.bin === null) {
      yield same("start", "step.start", seed, picked.seed, drop);
      return;
    }
    yield same("start", "step.drawn", [seed, aim], [picked.seed, null], drop);
    yield same("drawn-bin", "step.drawn-bin", bin, picked.bin, drop);
  }

  /**
   * @param {number} drop @param {string} boardDigest
   * @returns {Promise<{seed: string, bin: number | null} | null>} bin: in a draw; null while a secret is closed
   */
  async #pick(drop, boardDigest) {
    const { server_seed: server, client_seed: client, draw } = this.#session;
    if (server === null || client === null) return null;
    const known = {
      server: bytesOfHex(server, "server-seed"),
      client: bytesOfHex(client, "client-seed"),
      board: bytesOfHex(boardDigest, "board"),
    };
    return draw === undefined ? { seed: await dropSeed(known, drop), bin: null } : drawn(draw, known, drop);
  }

  /** Checks that a receipt the player received is in the export. @param {SignedReceipt} heard @returns {Promise<Step>} */
  async #heard(heard) {
    const { receipt, index, root } = heard;
    const number = receipt.drop;
    const { ok } = await this.#entrySigned("heard", heard);
    if (!ok || receipt.session !== this.#said.session) {
      return { name: "heard", ok: false, text: "step.heard-receipt", said: index,
        found: null, drop: number };
    }
    const { drops, end, board } = this.#session;
    const there = drops[number];
    // A drop that a restore lost is not there, but its seed can be computed.
    const lost = !there && end?.statement.void !== undefined
      ? await this.#pick(number, this.#tools.solver.drop(board, { seed: 0 }).boardDigest) : null;
    if (lost) return same("heard", "step.heard-void", receipt.seed, lost.seed, number);
    return same("heard", "step.heard", [receipt, index, root],
      there ? [there.receipt, there.index, there.root] : null, number);
  }
}

/** @param {{bin: number | null, score: number, t: number, x_end: number, unsettled: string | null}} end */
const endOf = ({ bin, score, t, x_end: x, unsettled }) => [bin, score, t, x, unsettled];

/** @param {string[]} proof */
const hashes = (proof) => proof.map((node) => bytesOfHex(node, "proof"));
