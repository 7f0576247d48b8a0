// The compare page: two drops at once, both paths, the distance between them and when they part.

import { emptyScene } from "../board/view.js";
import { Chart } from "../instruments/chart.js";
import {
  distanceAt, distances, distancesAtHits, FLOOR, growthPerHit, parting, together,
} from "./divergence.js";
import { bitsOf } from "../util/doubles.js";
import { byId, make } from "../util/dom.js";
import { dropSearch, readDrop, replayLink } from "../net/drop-address.js";
import { multiplier, seconds } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { upTo } from "../model/motion/drop.js";
import { fillBoards, openPage, showState, tableLink } from "../board/page.js";
import { paintPath } from "../paint/marks.js";
import { boardOf, Replay } from "../replay/replay.js";
import { figure } from "../util/scale.js";
import { readShift, secondStart } from "./second-start.js";
import { MAX_SEED, readSeed } from "../model/seed.js";
import { Stage } from "../board/stage.js";
import { Transport } from "../replay/transport.js";

const PATH_RATE = 120;
const BITS = 12; // shown of a start's 64
// The preset with the most rows: on it a single bit has the most impacts to grow in.
const DEFAULT_BOARD = "galton";
const DEFAULT_SEED = "42";
const TRIES = 40; // seeds looked at for one that parts

class ComparePage {
  /** @param {import("../paint/theme.js").Theme} theme */
  constructor(theme) {
    this.theme = theme;
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.stage = new Stage(theme, () => this.loop.wake());
    this.transport = new Transport(() => this.loop.wake());
    this.chart = new Chart(byId("distance"), theme, (x) => this.#seek(x));
    for (const radio of document.querySelectorAll("input[name=against]")) {
      radio.addEventListener("change", () => this.#plot());
    }
  }

  /** @param {URLSearchParams} search @param {string} hash */
  async open(search, hash) {
    const asked = readDrop(search);
    const { board, address } = await boardOf(asked.board || DEFAULT_BOARD, hash);
    const first = { ...asked, board: address, seed: asked.seed || DEFAULT_SEED };
    const shift = readShift(search.get("shift"));
    const { one, two, second } = await loadBoth(board, first, shift, search.get("with"));
    Object.assign(this, { board, one, two, drops: [first, second] });
    this.end = together(one.motion, two.motion);
    this.rows = distances(one.motion, two.motion);
    this.hits = distancesAtHits(one.motion, two.motion);
    this.paths = [one, two].map(({ motion, duration }) => motion.line(0, duration, PATH_RATE));
    this.stage.setBoard(board);
    this.#plot();
    const longest = one.duration > two.duration ? one : two;
    const stops = one.motion.events.map(({ t }) => t);
    this.transport.load({ duration: longest.duration, end: longest.end, stops });
    this.#showBoth();
    this.#fillForm(first, search);
    await fillBoards(byId("other-board"), { value: address, name: board.name });
    showState("replay", "Compare");
    if (window.matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.transport.seek(longest.duration);
    } else {
      this.transport.play();
    }
  }

  get againstHits() {
    return document.querySelector("input[name=against]:checked").value === "hits";
  }

  #draw(now) {
    if (!this.end) return false;
    const t = this.transport.advance(now);
    const scene = emptyScene();
    // The first ball lies on top: where they are one, it alone is seen.
    this.two.addTo(scene, t, false);
    this.one.addTo(scene, t, true);
    this.stage.draw(scene, (ctx, geometry) => this.#paintPaths(ctx, geometry, t));
    const { one, two } = this;
    byId("now").textContent = t <= this.end
      ? `${figure(distanceAt(one.motion, two.motion, t))} m`
      : "one has landed";
    const hits = one.motion.hits.filter((hit) => hit.t <= t).length;
    this.chart.mark(this.againstHits ? hits : Math.min(t, this.end));
    return this.transport.playing;
  }

  #paintPaths(ctx, geometry, t) {
    const { palette } = this.theme;
    const width = Math.max(2, 0.3 * this.board.ball.radius * geometry.scale);
    const both = [
      [this.two, this.paths[1], palette.other, 1.7 * width],
      [this.one, this.paths[0], palette.ball, 0.8 * width],
    ];
    for (const [replay, path, colour, wide] of both) {
      paintPath(ctx, geometry, path, { colour, width: wide, alpha: 0.22 });
      const past = upTo(path, replay.motion.stateAt(Math.min(t, replay.duration)));
      paintPath(ctx, geometry, past, { colour, width: wide, alpha: 0.95 });
    }
  }

  #seek(x) {
    if (!this.againstHits) this.transport.seek(x);
    else this.transport.seek(Math.round(x) === 0 ? 0 : this.one.motion.hits[Math.round(x) - 1].t);
  }

  #plot() {
    if (!this.rows) return;
    const { radius } = this.board.ball;
    const points = this.againstHits
      ? this.hits.map(({ hit, distance }) => ({ x: hit, y: distance }))
      : this.rows.map(({ t, distance }) => ({ x: t, y: distance }));
    const seen = points.map(({ y }) => y).filter((y) => y > 0);
    const least = Math.max(FLOOR, Math.min(radius / 10, ...seen));
    this.chart.set({
      x: this.againstHits
        ? { from: 0, to: Math.max(1, this.hits.length - 1), unit: "impacts of the first" }
        : { from: 0, to: this.end, unit: "s" },
      y: { from: least / 3, to: 30 * Math.max(radius, ...seen), unit: "m", log: true },
      series: [{ points, colour: "trayBar", width: 2, dots: this.againstHits }],
      events: this.againstHits ? [] : this.one.motion.hits.map(({ t }) => t),
      limit: { y: radius, text: "a ball's radius" },
    });
    byId("distance").setAttribute("aria-label", `Distance of the two balls. ${this.#verdict()}`);
    this.loop.wake();
  }

  /** When they parted, in words. */
  #verdict() {
    const { radius } = this.board.ball;
    const [one, two] = [this.one.motion, this.two.motion];
    const start = distanceAt(one, two, 0);
    if (start === 0) return "Both start at the same place, so they never part.";
    if (start > radius) return `They start ${figure(start)} m apart, more than a ball's radius.`;
    const parted = parting(one, two, radius);
    const from = `They start ${figure(start)} m apart`;
    if (!parted) return `${from} and stay within a ball's radius until one lands.`;
    const growth = growthPerHit(one, two, radius);
    const grown = growth ? ` On average each impact multiplied that by ${growth.toPrecision(2)}.` : "";
    return (
      `${from} and are parted by more than a ball's radius (${figure(radius)} m) after impact ` +
      `${parted.hits}, at ${seconds(parted.t)}.${grown}`
    );
  }

  #showBoth() {
    const { one, two } = this;
    byId("result").textContent = this.#verdict();
    document.title = `${one.record.seed} beside ${two.record.seed} on ${this.board.name} – Plinko`;
    const bin = ({ record }) => (record.bin === null ? "none" : String(record.bin));
    const rows = [
      ["Seed", ({ record }) => record.seed],
      ["Start", ({ motion }) => `${motion.start.x} m`],
      ["Its bits", ({ motion }) => bits(motion.start.x, one.motion.start.x)],
      ["Bin", bin],
      ["Score", ({ record }) => multiplier(record.score)],
      ["Duration", ({ record }) => `${record.duration.toFixed(4)} s`],
      ["Impacts", ({ motion }) => String(motion.hits.length)],
      ["End", ({ record }) => `${record.x_end.toFixed(6)} m`],
      ["Digest", ({ record }) => `${record.digest.slice(0, 12)}…`],
      ["Replay", (_, drop) => make("a", { class: "back", href: this.#link(drop) }, "Replay")],
    ];
    byId("both").replaceChildren(...rows.map(([name, value]) => {
      const cells = [one, two].map((replay, i) => {
        const cell = make("td", {}, value(replay, this.drops[i]));
        cell.dataset.fact = `${name.toLowerCase()}-${i + 1}`;
        return cell;
      });
      return make("tr", {}, make("th", { scope: "row" }, name), ...cells);
    }));
  }

  #link(drop) {
    const { hash } = window.location;
    return hash ? `${replayLink({ ...drop, board: "" })}${hash}` : replayLink(drop);
  }

  #fillForm(first, search) {
    const { hash } = window.location;
    byId("to-table").href = tableLink(first.board);
    byId("back").href = tableLink(first.board);
    byId("to-replay").href = this.#link(first);
    byId("to-editor").href = hash ? `editor.html${hash}` : `editor.html?board=${first.board}`;
    const form = byId("other");
    const { elements } = form;
    elements.seed.value = first.seed;
    elements.x.value = first.x ?? "";
    elements.with.value = search.get("with") ?? "";
    elements.shift.value = search.get("with") ? "seed" : readShift(search.get("shift"));
    const show = () => {
      byId("second").hidden = elements.shift.value !== "seed";
    };
    form.addEventListener("change", show);
    show();
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#submit(elements, first);
    });
    byId("find").addEventListener("click", () => this.#find(first, readShift(elements.shift.value)));
  }

  /** Goes to the next seed whose two balls part; says so when none of many does. */
  async #find(first, shift) {
    const note = byId("found");
    const { radius } = this.board.ball;
    for (let i = 1; i <= TRIES; i += 1) {
      const seed = String((BigInt(first.seed) + BigInt(i)) % (MAX_SEED + 1n));
      note.textContent = `Looking at seed ${seed}…`;
      const drop = { ...first, seed, x: null };
      const { one, two } = await loadBoth(this.board, drop, shift, null);
      if (!parting(one.motion, two.motion, radius)) continue;
      const { hash } = window.location;
      const search = dropSearch({ ...drop, board: hash ? "" : drop.board });
      search.set("shift", shift);
      window.location.assign(`compare.html?${search}${hash}`);
      return;
    }
    note.textContent = `None of the next ${TRIES} seeds parts on this board: ask for a larger difference.`;
  }

  #submit({ board, seed, x, shift, with: other }, { solver, dt, substeps }) {
    const wanted = shift.value === "seed" ? [seed, other] : [seed];
    const note = byId("other-note");
    note.hidden = true;
    for (const field of wanted) {
      const reading = readSeed(field.value);
      const good = reading.ok && reading.seed !== null;
      field.setAttribute("aria-invalid", String(!good));
      if (good) continue;
      note.hidden = false;
      note.dataset.tone = "bad";
      note.textContent = reading.message ?? "A drop needs a seed.";
      field.focus();
      return;
    }
    const drop = { board: board.value, seed: seed.value.trim(), x: x.value.trim(), solver, dt, substeps };
    const search = dropSearch(drop);
    if (shift.value === "seed") search.set("with", other.value.trim());
    else search.set("shift", shift.value);
    window.location.assign(`compare.html?${search}`);
  }
}

/** Both drops of a comparison: the second by a seed of its own, or by a shifted start. */
async function loadBoth(board, first, shift, withSeed) {
  const one = await Replay.load(board, first);
  const second = withSeed
    ? { ...first, seed: withSeed, x: null }
    : { ...first, x: secondStart(board, one.motion.start.x, shift) };
  return { one, two: await Replay.load(board, second), second };
}

/** The last bits of a double, those that differ from another one's marked. */
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
