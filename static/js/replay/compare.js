// Compares a replay with a second drop: their paths, their distance, and when they part. Loaded when it is asked for.

import { showState } from "../board/page.js";
import { Stage } from "../board/stage.js";
import { Chart } from "../instruments/chart.js";
import { partingWords } from "../model/certificate.js";
import { emptyScene } from "../model/scene.js";
import { replayLink } from "../net/drop-address.js";
import { paintPath } from "../paint/marks.js";
import { t as words } from "../texts/text.js";
import { byId, factId, make, onChoice, onClick, radioValue } from "../util/dom.js";
import { bitsOf } from "../util/doubles.js";
import { fixed, multiplier, rounded, seconds } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { figure } from "../util/scale.js";
import { Divergence, FLOOR } from "./divergence.js";
import { readShift, secondDrop } from "./pair.js";
import { prove, Replay } from "./replay.js";
import { Transport } from "./transport.js";

/** @import { Layer } from "../board/stage.js" */
/** @import { Board } from "../model/board.js" */
/** @import { DropAddress } from "../net/drop-address.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Key } from "../texts/text.js" */

const BITS = 12; // last bits shown of a start

/** Both drops. @typedef {{board: Board, one: Replay, two: Replay, drops: [DropAddress, DropAddress]}} Pair */

class Comparison {
  /** @param {Theme} theme @param {Pair} pair */
  constructor(theme, pair) {
    const { board, one, two } = pair;
    this.theme = theme;
    this.pair = pair;
    this.apart = new Divergence(one.motion, two.motion);
    this.loop = new FrameLoop((now) => this.#draw(now));
    const wake = () => this.loop.wake();
    this.stage = new Stage(theme, wake);
    this.stage.setBoard(board);
    const { duration, end } = one.duration > two.duration ? one : two;
    this.transport = new Transport({ duration, end, stops: one.motion.events.map(({ t }) => t) }, wake);
    this.chart = new Chart(byId("distance", HTMLCanvasElement), theme, (x) => {
      this.transport.seek(this.againstHits ? (one.motion.hits[Math.round(x) - 1]?.t ?? 0) : x);
    });
    onClick("prove", () => prove(pair.drops, byId("proven"), "compare.proving", ([first, second]) => (
      ["", partingWords(first, second)])));
    onChoice("against", () => this.#plot());
    this.#plot();
  }

  get againstHits() {
    return radioValue("against") === "hits";
  }

  /** @param {number} now */
  #draw(now) {
    const { pair: { one, two }, apart } = this;
    const t = this.transport.advance(now);
    const scene = emptyScene();
    // The first ball is drawn on top, and hides the second while they coincide.
    two.addTo(scene, t, false);
    one.addTo(scene, t, true);
    this.stage.show(scene, (layer) => this.#paintPaths(layer, t));
    byId("now").textContent = t <= apart.end ? `${figure(apart.at(t))} m` : words("compare.one-landed");
    const hits = one.motion.hits.filter((hit) => hit.t <= t).length;
    this.chart.mark(this.againstHits ? hits : Math.min(t, apart.end));
    this.transport.show();
    return this.transport.playing;
  }

  /** @param {Layer} layer @param {number} t */
  #paintPaths({ ctx, geometry }, t) {
    const { pair: { board, one, two }, theme: { palette } } = this;
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

  #plot() {
    const { pair: { board, one }, apart, againstHits } = this;
    const { radius } = board.ball;
    const points = againstHits ? apart.overHits : apart.overTime;
    const seen = points.map(({ y }) => y).filter((y) => y > 0);
    const least = Math.max(FLOOR, Math.min(radius / 10, ...seen));
    this.chart.set({
      x: againstHits
        ? { from: 0, to: Math.max(1, points.length - 1), unit: words("compare.first-impacts") }
        : { from: 0, to: apart.end, unit: "s" },
      y: { from: least / 3, to: 30 * Math.max(radius, ...seen), unit: "m", log: true },
      series: [{ points, colour: "trayBar", width: 2, dots: againstHits }],
      events: againstHits ? [] : one.motion.hits.map(({ t }) => t),
      limit: { y: radius, text: words("compare.radius") },
    });
    this.loop.wake();
  }
}

/** Fills the table that compares both drops. @param {Pair} pair @param {Divergence} apart */
function showBoth({ board, one, two, drops }, apart) {
  const verdict = verdictOf(board.ball.radius, apart);
  byId("result").textContent = verdict;
  byId("distance").setAttribute("aria-label", words("compare.distance-words", { verdict }));
  const { hash } = window.location; // may contain the board
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
    ["fact.replay", (_, drop) => {
      const href = `${replayLink(hash ? { ...drop, board: "" } : drop)}${hash}`;
      return make("a", { class: "back", href }, words("fact.replay"));
    }],
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

/** @param {number} radius m @param {Divergence} apart @returns {string} says when they part */
function verdictOf(radius, apart) {
  const start = apart.at(0);
  if (start === 0) return words("compare.same-place");
  if (start > radius) return words("compare.start-far", { start: figure(start) });
  const parted = apart.parting(radius);
  if (!parted) return words("compare.stay", { start: figure(start) });
  const growth = apart.growthPerHit(radius);
  const told = words("compare.part", {
    start: figure(start), radius: figure(radius), hits: parted.hits, time: seconds(parted.t),
  });
  return growth ? `${told} ${words("compare.grown", { growth: rounded(growth, 2) })}` : told;
}

/**
 * The last bits of a double, with those marked that differ from another double's.
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

/**
 * The second drop has its own seed, or a shifted start.
 * @param {Theme} theme @param {Board} board @param {DropAddress} drop
 * @param {URLSearchParams} search `with`: the second seed; `shift`: of the second start, without a seed
 */
export async function compare(theme, board, drop, search) {
  const one = await Replay.compute(board, drop);
  const second = secondDrop(board, drop, one.motion.start.x, readShift(search.get("shift")), search.get("with"));
  /** @type {Pair} */
  const pair = { board, one, two: await Replay.compute(board, second), drops: [drop, second] };
  const comparison = new Comparison(theme, pair);
  showBoth(pair, comparison.apart);
  showState("replay", words("page.compare"));
  comparison.transport.begin();
}
