// The compare page: two drops at once, both paths, the distance between them and when they part.

import { DEFAULT_BOARD, DEFAULT_SEED, fillBoards, holdSeeds, linkPages, openPage, showState } from "../board/page.js";
import { Stage } from "../board/stage.js";
import { Chart } from "../instruments/chart.js";
import { partingWords } from "../model/certificate.js";
import { emptyScene } from "../model/scene.js";
import { MAX_SEED } from "../model/seed.js";
import { ApiError } from "../net/api.js";
import { dropSearch, readDrop, replayLink } from "../net/drop-address.js";
import { paintPath } from "../paint/marks.js";
import { boardOf, certificateOf, Replay } from "../replay/replay.js";
import { Transport } from "../replay/transport.js";
import { t as words } from "../texts/text.js";
import { byId, factId, fieldOf, inputOf, make, radiosOf, radioValue } from "../util/dom.js";
import { bitsOf } from "../util/doubles.js";
import { fixed, multiplier, rounded, seconds } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { figure } from "../util/scale.js";
import {
  distanceAt, distances, distancesAtHits, FLOOR, growthPerHit, parting, together,
} from "./divergence.js";
import { openingPair } from "./opening-pair.js";
import { readShift, secondDrop } from "./second-start.js";

/** @import { Layer } from "../board/stage.js" */
/** @import { Board } from "../model/board.js" */
/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Key } from "../texts/text.js" */

const BITS = 12; // shown of a start's 64
const TRIES = 40; // seeds looked at for one that parts

/**
 * Both drops and what is measured of them.
 * @typedef {object} Pair
 * @property {Board} board
 * @property {Replay} one
 * @property {Replay} two
 * @property {[DropAddress, DropAddress]} drops
 * @property {number} end seconds until one has landed
 * @property {ReturnType<typeof distances>} rows
 * @property {ReturnType<typeof distancesAtHits>} hits
 */

class ComparePage {
  /** @type {Pair | null} */
  #pair = null;

  /** @param {Theme} theme */
  constructor(theme) {
    this.theme = theme;
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.stage = new Stage(theme, () => this.loop.wake());
    this.transport = new Transport(() => this.loop.wake());
    this.chart = new Chart(byId("distance", HTMLCanvasElement), theme, (x) => this.#seek(x));
    byId("certify").addEventListener("click", () => this.#certify());
    for (const radio of radiosOf("against")) {
      radio.addEventListener("change", () => this.#plot());
    }
  }

  /** @param {URLSearchParams} search @param {string} hash */
  async open(search, hash) {
    const asked = readDrop(search);
    const { board, address } = await boardOf(asked.board || DEFAULT_BOARD, hash);
    const { seed, shift } = pairAsked(search, asked);
    const first = { ...asked, board: address, seed };
    const { one, two, second } = await loadBoth(board, first, shift, search.get("with"));
    /** @type {Pair} */
    const pair = {
      board, one, two, drops: [first, second],
      end: together(one.motion, two.motion),
      rows: distances(one.motion, two.motion),
      hits: distancesAtHits(one.motion, two.motion),
    };
    this.#pair = pair;
    this.stage.setBoard(board);
    this.#plot();
    const longest = one.duration > two.duration ? one : two;
    const stops = one.motion.events.map(({ t }) => t);
    this.transport.load({ duration: longest.duration, end: longest.end, stops });
    this.#showBoth(pair);
    this.#fillForm(board, first, search, shift);
    await fillBoards(byId("other-board", HTMLSelectElement), { value: address, name: board.name });
    showState("replay", words("page.compare"));
    this.transport.begin();
  }

  /** Asks for proofs of both drops, and shows where they part. */
  async #certify() {
    if (!this.#pair) return;
    const note = byId("proven");
    note.textContent = words("compare.proving");
    try {
      const [one, two] = await Promise.all(this.#pair.drops.map(certificateOf));
      note.textContent = partingWords(one, two);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      note.textContent = error.message;
    }
  }

  get againstHits() {
    return radioValue("against") === "hits";
  }

  /** @param {number} now */
  #draw(now) {
    const pair = this.#pair;
    if (!pair) return false;
    const { one, two, end } = pair;
    const t = this.transport.advance(now);
    const scene = emptyScene();
    // The first ball lies on top: where they are one, it alone is seen.
    two.addTo(scene, t, false);
    one.addTo(scene, t, true);
    this.stage.draw(scene, (layer) => this.#paintPaths(layer, pair, t));
    byId("now").textContent = t <= end
      ? `${figure(distanceAt(one.motion, two.motion, t))} m`
      : words("compare.one-landed");
    const hits = one.motion.hits.filter((hit) => hit.t <= t).length;
    this.chart.mark(this.againstHits ? hits : Math.min(t, end));
    return this.transport.playing;
  }

  /** @param {Layer} layer @param {Pair} pair @param {number} t */
  #paintPaths({ ctx, geometry }, { board, one, two }, t) {
    const { palette } = this.theme;
    const width = Math.max(2, 0.3 * board.ball.radius * geometry.scale);
    const both = [
      { replay: two, colour: palette.other, wide: 1.7 * width },
      { replay: one, colour: palette.ball, wide: 0.8 * width },
    ];
    for (const { replay, colour, wide } of both) {
      paintPath(ctx, geometry, replay.path, { colour, width: wide, alpha: 0.22 });
      paintPath(ctx, geometry, replay.pathTo(t), { colour, width: wide, alpha: 0.95 });
    }
  }

  /** @param {number} x */
  #seek(x) {
    const hit = Math.round(x);
    if (!this.againstHits) this.transport.seek(x);
    else this.transport.seek(hit === 0 ? 0 : (this.#pair?.one.motion.hits[hit - 1].t ?? 0));
  }

  #plot() {
    if (!this.#pair) return;
    const { board, one, rows, hits, end } = this.#pair;
    const { radius } = board.ball;
    const points = this.againstHits
      ? hits.map(({ hit, distance }) => ({ x: hit, y: distance }))
      : rows.map(({ t, distance }) => ({ x: t, y: distance }));
    const seen = points.map(({ y }) => y).filter((y) => y > 0);
    const least = Math.max(FLOOR, Math.min(radius / 10, ...seen));
    this.chart.set({
      x: this.againstHits
        ? { from: 0, to: Math.max(1, hits.length - 1), unit: words("compare.first-impacts") }
        : { from: 0, to: end, unit: "s" },
      y: { from: least / 3, to: 30 * Math.max(radius, ...seen), unit: "m", log: true },
      series: [{ points, colour: "trayBar", width: 2, dots: this.againstHits }],
      events: this.againstHits ? [] : one.motion.hits.map(({ t }) => t),
      limit: { y: radius, text: words("compare.radius") },
    });
    byId("distance").setAttribute("aria-label", words("compare.distance-words", { verdict: verdictOf(this.#pair) }));
    this.loop.wake();
  }

  /** @param {Pair} pair */
  #showBoth(pair) {
    const { board, one, two, drops } = pair;
    byId("result").textContent = verdictOf(pair);
    document.title = words("compare.title-seeds", { one: one.record.seed, two: two.record.seed, board: board.name });
    /** @type {[Key, (replay: Replay, drop: DropAddress) => Node | string][]} */
    const rows = [
      ["fact.seed", ({ record }) => record.seed],
      ["fact.start", ({ motion }) => `${motion.start.x} m`],
      ["fact.its-bits", ({ motion }) => bits(motion.start.x, one.motion.start.x)],
      ["fact.bin", ({ record }) => (record.bin === null ? words("word.none") : String(record.bin))],
      ["fact.score", ({ record }) => multiplier(record.score)],
      ["fact.duration", ({ record }) => `${fixed(record.duration, 4)} s`],
      ["fact.impacts", ({ motion }) => String(motion.hits.length)],
      ["fact.end", ({ record }) => `${fixed(record.x_end, 6)} m`],
      ["fact.digest", ({ record }) => `${record.digest.slice(0, 12)}…`],
      ["fact.replay", (_, drop) => make("a", { class: "back", href: this.#link(drop) }, words("fact.replay"))],
    ];
    byId("both").replaceChildren(...rows.map(([name, value]) => {
      const cells = [one, two].map((replay, i) => {
        const cell = make("td", {}, value(replay, drops[i]));
        cell.dataset.fact = `${factId(name)}-${i + 1}`;
        return cell;
      });
      return make("tr", {}, make("th", { scope: "row" }, words(name)), ...cells);
    }));
  }

  /** @param {DropAddress} drop */
  #link(drop) {
    const { hash } = window.location;
    return hash ? `${replayLink({ ...drop, board: "" })}${hash}` : replayLink(drop);
  }

  /**
   * @param {Board} board
   * @param {DropAddress} first
   * @param {URLSearchParams} search
   * @param {string} by which the second start differs
   */
  #fillForm(board, first, search, by) {
    linkPages(first);
    const form = byId("other", HTMLFormElement);
    const shift = fieldOf(form, "shift");
    inputOf(form, "seed").value = first.seed;
    inputOf(form, "x").value = String(first.x ?? "");
    inputOf(form, "with").value = search.get("with") ?? "";
    shift.value = search.get("with") ? "seed" : by;
    const show = () => {
      byId("second").hidden = shift.value !== "seed";
    };
    form.addEventListener("change", show);
    show();
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#submit(form, first);
    });
    byId("find").addEventListener("click", () => this.#find(board, first, readShift(shift.value)));
  }

  /**
   * Goes to the next seed whose two balls part; says so when none of many does.
   * @param {Board} board
   * @param {DropAddress} first
   * @param {string} shift
   */
  async #find(board, first, shift) {
    const note = byId("found");
    const { radius } = board.ball;
    for (let i = 1; i <= TRIES; i += 1) {
      const seed = String((BigInt(first.seed) + BigInt(i)) % (MAX_SEED + 1n));
      note.textContent = words("compare.looking", { seed });
      const drop = { ...first, seed, x: null };
      const { one, two } = await loadBoth(board, drop, shift, null);
      if (!parting(one.motion, two.motion, radius)) continue;
      const { hash } = window.location;
      const search = dropSearch({ ...drop, board: hash ? "" : drop.board });
      search.set("shift", shift);
      window.location.assign(`compare.html?${search}${hash}`);
      return;
    }
    note.textContent = words("compare.not-found", { n: TRIES });
  }

  /** @param {HTMLFormElement} form @param {DropAddress} first */
  #submit(form, first) {
    const [seed, x, other] = [inputOf(form, "seed"), inputOf(form, "x"), inputOf(form, "with")];
    const [board, shift] = [fieldOf(form, "board"), fieldOf(form, "shift")];
    const wanted = shift.value === "seed" ? [seed, other] : [seed];
    if (!holdSeeds(wanted, words("compare.needs-seed"))) return;
    // Another board's middle is elsewhere, and a start of one's own has none.
    const aim = x.value.trim() || board.value !== first.board ? null : first.aim;
    const drop = { ...first, board: board.value, seed: seed.value, x: x.value.trim(), aim };
    const search = dropSearch(drop);
    if (shift.value === "seed") search.set("with", other.value);
    else search.set("shift", shift.value);
    window.location.assign(`compare.html?${search}`);
  }
}

/**
 * What a link leaves open is filled in: of two balls it says nothing about, with a pair that parts.
 * @param {URLSearchParams} search
 * @param {DropAddress} asked
 */
function pairAsked(search, asked) {
  const open = !asked.seed && !asked.x && !search.get("shift") && !search.get("with");
  const found = open ? openingPair(asked.board || DEFAULT_BOARD) : null;
  return found ?? { seed: asked.seed || DEFAULT_SEED, shift: readShift(search.get("shift")) };
}

/** @param {Pair} pair @returns {string} when they parted */
function verdictOf({ board, ...replays }) {
  const { radius } = board.ball;
  const [one, two] = [replays.one.motion, replays.two.motion];
  const start = distanceAt(one, two, 0);
  if (start === 0) return words("compare.same-place");
  if (start > radius) return words("compare.start-far", { start: figure(start) });
  const parted = parting(one, two, radius);
  if (!parted) return words("compare.stay", { start: figure(start) });
  const growth = growthPerHit(one, two, radius);
  const told = words("compare.part", {
    start: figure(start), radius: figure(radius), hits: parted.hits, time: seconds(parted.t),
  });
  return growth ? `${told} ${words("compare.grown", { growth: rounded(growth, 2) })}` : told;
}

/**
 * Both drops of a comparison: the second by a seed of its own, or by a shifted start.
 * @param {Board} board
 * @param {DropAddress} first
 * @param {string} shift
 * @param {string | null} withSeed
 */
async function loadBoth(board, first, shift, withSeed) {
  const one = await Replay.compute(board, first);
  const second = secondDrop(board, first, one.motion.start.x, shift, withSeed);
  return { one, two: await Replay.compute(board, second), second };
}

/**
 * The last bits of a double, those that differ from another one's marked.
 * @param {number} x
 * @param {number} from
 */
function bits(x, from) {
  const [mine, theirs] = [bitsOf(x).slice(-BITS), bitsOf(from).slice(-BITS)];
  const found = [...mine].findIndex((bit, i) => bit !== theirs[i]);
  const at = found < 0 ? mine.length : found;
  const tail = make("mark", {}, mine.slice(at));
  return make("span", { class: "bits" }, `…${mine.slice(0, at)}`, ...(at < mine.length ? [tail] : []));
}

openPage(async (theme) => {
  const page = new ComparePage(theme);
  await page.open(new URLSearchParams(window.location.search), window.location.hash);
  window.addEventListener("hashchange", () => window.location.reload());
});
