// The numbers of the lesson, and its four views: bins, rows, the average over time, the means of samples.

import { Chart } from "../instruments/chart.js";
import { binomialChances, fitTest } from "../model/statistics.js";
import { t } from "../texts/text.js";
import { byId, make } from "../util/dom.js";
import { fixed, percent, plain } from "../util/format.js";
import { averages, countsOf, normalDensity, sampleMeans, summaryOf, theoryOf } from "./statistics.js";

/** @import { Theme } from "../paint/theme.js" */
/** @import { Curve, Plot } from "../instruments/chart.js" */
/** @import { Key } from "../texts/text.js" */
/** @import { Lesson } from "./lesson.js" */
/** @import { Trial } from "./trial.js" */

/** @typedef {ReturnType<Trial["over"]> & {settled: number[]}} Sample settled: as `Trial.settled` gives them */
/** @typedef {Pick<Trial, "setting" | "runs">} Of */

const COLOURS = ["trayBar", "other"];
const CLASSES = 4; // of the means' histogram, in a standard error
const ENDS = [0.05, 0.005]; // chances below which a deviation is called rare, and hardly chance

/** @param {number} value @returns {string} a dash if there is no value yet */
const shown = (value) => (Number.isFinite(value) ? fixed(value, 2) : "–");

/** Fills a table: `<id>-head` and `<id>`. @param {string} id @param {string[]} head @param {string[][]} rows */
export function fillTable(id, head, rows) {
  byId(`${id}-head`).replaceChildren(make("tr", {}, ...head.map((text) => make("th", { scope: "col" }, text))));
  byId(id).replaceChildren(...rows.map(([name, ...cells]) =>
    make("tr", {}, make("th", { scope: "row" }, name), ...cells.map((text) => make("td", {}, text)))));
}

/** @param {Of[]} trials @param {Sample[]} samples @returns {[string[], string[][]]} head and rows, a column for each board */
export function numbersOf(trials, samples) {
  const measured = samples.map(({ counts }) => summaryOf(counts));
  const ideal = trials.map(({ setting: { rows, p } }, i) => theoryOf(rows, p, measured[i].n));
  const theories = ideal.slice(0, new Set(trials.map(({ setting: { p } }) => p)).size);
  const both = trials.length > 1;
  const head = [t("class.numbers"), ...measured.map((_, i) => (both ? t("class.measured-of", { board: i + 1 }) : t("class.measured"))),
    ...theories.map((_, i) => (theories.length > 1 ? t("class.theory-of", { board: i + 1 }) : t("class.theory")))];
  /** @type {[Key, "mean" | "sd" | "se"][]} */
  const kinds = [["class.mean", "mean"], ["class.sd", "sd"], ["class.se", "se"]];
  return [head, [
    [t("word.balls"), ...measured.map(({ n }) => plain(n)), ...theories.map(() => "")],
    ...kinds.map(([key, kind]) => [t(key), ...[...measured, ...theories].map((each) => shown(each[kind]))]),
  ]];
}

/** @param {Of} trial @param {Sample} sample @returns {string} how surprising the sample is, in plain words */
export function surpriseOf({ setting: { rows, p } }, { settled }) {
  const counts = countsOf(settled, 0, 1, rows + 1);
  const fit = fitTest(counts, binomialChances(rows, p));
  if (!fit) return t("class.too-few");
  const { n, mean } = summaryOf(counts);
  const theory = theoryOf(rows, p, n);
  const off = t(mean < theory.mean ? "class.below" : "class.above", {
    off: shown(Math.abs(mean - theory.mean)), times: fixed(Math.abs(mean - theory.mean) / theory.se, 1),
  });
  const many = Math.max(1, Math.round(100 * fit.p));
  if (fit.p < ENDS[1]) return `${off} ${t("class.hardly")}`;
  return `${off} ${t(fit.p < ENDS[0] ? "class.rare" : "class.usual", { many })}`;
}

/** The chart and the table below the numbers. */
export class LessonView {
  /** @param {Theme} theme */
  constructor(theme) {
    this.canvas = byId("chart", HTMLCanvasElement);
    this.chart = new Chart(this.canvas, theme);
  }

  /** @param {Pick<Lesson, "view" | "size">} lesson @param {Of[]} trials @param {Sample[]} samples @param {boolean} secret */
  show({ view, size }, trials, samples, secret) {
    const plots = view === "average" || view === "means";
    byId("size-field").hidden = view !== "means";
    byId("plot").hidden = !plots || secret;
    byId("table-box").hidden = plots || secret;
    byId("view-words").textContent = "";
    if (secret) return;
    if (view === "bins") fillTable("table", ...binsOf(trials, samples));
    if (view === "rows") fillTable("table", ...rowsOf(trials, samples));
    if (view === "runs") fillTable("table", ...runsOf(trials));
    if (!plots) return;
    const { plot, words } = view === "average" ? averagePlot(trials, samples) : meansPlot(trials, samples, size);
    byId("view-words").textContent = words;
    this.canvas.setAttribute("aria-label", words);
    this.chart.set(plot);
  }
}

/** @param {Of[]} trials @param {Sample[]} samples @returns {[string[], string[][]]} */
function binsOf(trials, samples) {
  const due = trials.map(({ setting: { rows, p } }) => binomialChances(rows, p));
  const theories = due.slice(0, new Set(trials.map(({ setting: { p } }) => p)).size);
  const head = [t("word.bin"), ...samples.flatMap(() => [t("word.balls"), t("class.share-of")]), ...theories.map(() => t("class.theory"))];
  return [head, samples[0].counts.map((_, bin) => [
    plain(bin),
    ...samples.flatMap(({ counts, bins }) => [plain(counts[bin]), bins.length ? percent(counts[bin] / bins.length) : "–"]),
    ...theories.map((chances) => percent(chances[bin])),
  ])];
}

/** Each row as a die: how often balls went right there. @param {Of[]} trials @param {Sample[]} samples @returns {[string[], string[][]]} */
function rowsOf(trials, samples) {
  const head = [t("class.row"), ...samples.flatMap(() => [t("class.right"), t("class.share-of")])];
  return [head, samples[0].rights.map((_, row) => [plain(row + 1), ...samples.flatMap(({ rights, bins }, i) => {
    const { p } = trials[i].setting;
    const n = bins.length;
    const share = n ? `${percent(rights[row] / n)} ± ${percent(Math.sqrt((p * (1 - p)) / n))}` : "–";
    return [t("class.of", { right: rights[row], n }), share];
  })])];
}

/** @param {Of[]} trials @returns {[string[], string[][]]} a row for each run */
function runsOf(trials) {
  const head = [t("class.run"), ...trials.flatMap(() => [t("word.balls"), t("class.mean"), t("class.sd-short")])];
  return [head, trials[0].runs.map((_, run) => [plain(run + 1), ...trials.flatMap(({ runs, setting: { rows } }) => {
    const { n, mean, sd } = summaryOf(countsOf(runs[run]?.bins ?? [], 0, 1, rows + 1));
    return [plain(n), shown(mean), shown(sd)];
  })])];
}

/** @param {Of[]} trials @param {Sample[]} samples @returns {{plot: Plot, words: string}} the law of large numbers */
function averagePlot(trials, samples) {
  const { rows, p } = trials[0].setting;
  const law = theoryOf(rows, p, 1);
  const most = Math.max(10, ...samples.map(({ settled }) => settled.length));
  const places = Array.from({ length: 41 }, (_, i) => most ** (i / 40));
  /** @param {number} side */
  const funnel = (side) => places.map((n) => ({ x: n, y: law.mean + (side * 2 * law.sd) / Math.sqrt(n) }));
  const { n, mean } = summaryOf(countsOf(samples[0].settled, 0, 1, rows + 1));
  return {
    plot: {
      x: { from: 1, to: most, unit: t("class.axis-balls"), log: true },
      y: { from: Math.max(0, law.mean - 2 * law.sd), to: Math.min(rows, law.mean + 2 * law.sd), unit: "" },
      series: [
        { points: funnel(1), base: funnel(-1), colour: "ray", alpha: 0.8 },
        { points: [{ x: 1, y: law.mean }, { x: most, y: law.mean }], colour: "trayMark", width: 2 },
        ...samples.map(({ settled }, i) => ({ points: averages(settled), colour: COLOURS[i], width: 3 })),
      ].filter(({ points }) => points.length),
    },
    words: n ? t("class.average-words", { n, mean: shown(mean), ideal: shown(law.mean) }) : t("class.too-few"),
  };
}

/** @param {Of[]} trials @param {Sample[]} samples @param {number} size @returns {{plot: Plot, words: string}} the central limit theorem */
function meansPlot(trials, samples, size) {
  const { rows, p } = trials[0].setting;
  const law = theoryOf(rows, p, size);
  // Means are multiples of 1 / size: each class has the same number of them.
  const width = Math.max(1, Math.round((law.se / CLASSES) * size)) / size;
  const side = Math.ceil((4 * law.se) / width);
  const from = (Math.round(law.mean * size) - 0.5) / size - side * width;
  const classes = 2 * side + 1;
  /** @type {Curve[]} */
  const series = [];
  let most = 1;
  let words = t("class.too-few-means", { size });
  samples.forEach(({ settled }, i) => {
    const means = sampleMeans(settled, size);
    const counts = countsOf(means, from, width, classes);
    const ideal = Array.from({ length: 81 }, (_, k) => from + (k / 80) * classes * width).map((x) =>
      ({ x, y: means.length * width * normalDensity(x, { mean: law.mean, sd: law.se }) }));
    most = Math.max(most, ...counts, ...ideal.map(({ y }) => y));
    const top = counts.flatMap((count, k) => [{ x: from + k * width, y: count }, { x: from + (k + 1) * width, y: count }]);
    if (means.length) {
      series.push({ points: top, base: top.map(({ x }) => ({ x, y: 0 })), colour: COLOURS[i], alpha: i ? 0.55 : 1 });
      series.push({ points: ideal, colour: "ballLight", width: 3 });
    }
    if (i > 0 || means.length < 2) return;
    const mean = means.reduce((sum, each) => sum + each, 0) / means.length;
    const sd = Math.sqrt(means.reduce((sum, each) => sum + (each - mean) ** 2, 0) / (means.length - 1));
    words = t("class.means-words", { n: means.length, size, sd: shown(sd), ideal: shown(law.se) });
  });
  return {
    plot: {
      x: { from, to: from + classes * width, unit: t("class.axis-mean") },
      y: { from: 0, to: 1.08 * most, unit: "" }, series,
    },
    words,
  };
}
