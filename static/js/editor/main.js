// The editor page: joins the board being edited with its view, panels, checks, tests and links.

import { ApiError, getJson, postJson } from "../net/api.js";
import { boardInHash, packBoard, unpackBoard } from "../net/board-link.js";
import { byId, make } from "../util/dom.js";
import {
  complete, describeRef, duplicated, EMPTY, holds, placeOf, refsInProblem, refsOf, sameRef, without,
  written,
} from "./draft.js";
import { groupOf, membersOf, named } from "./group.js";
import { EditHistory } from "./history.js";
import { EditorCheck } from "./check.js";
import { EditorHands } from "./pointer.js";
import { EditorTest } from "./test-drops.js";
import { EditorView } from "./view.js";
import { counted } from "../util/format.js";
import { NumberFields } from "./number-fields.js";
import { openPage, saveFile, showState } from "../board/page.js";

const BOARD_ROWS = [
  ["gravity", "Gravity, m/s²", 0.1], ["drag", "Drag, 1/s", 0.1], ["ball.radius", "Ball radius, m", 0.005],
  ["ball.density", "Ball density, kg/m²", 0.1], ["ball.restitution", "Ball bounce", 0.05],
  ["ball.friction", "Ball friction", 0.05], ["peg_material.restitution", "Peg bounce", 0.05],
  ["peg_material.friction", "Peg friction", 0.05], ["wall_material.restitution", "Wall bounce", 0.05],
  ["wall_material.friction", "Wall friction", 0.05], ["bins.y", "Bins at y, m", 0.05],
  ["drop.jitter", "Start spread, m", 0.05], ["drop.reach", "Aim within, m", 0.05],
].map(([path, label, step]) => ({ path, label, step }));

class Editor {
  selected = null;
  problems = [];
  #problem = null;
  #packed = "";

  /** @param {import("../paint/theme.js").Theme} theme */
  constructor(theme) {
    this.history = new EditHistory(EMPTY);
    this.view = new EditorView(theme, () => {
      this.test.histogram.layOut(this.view.geometry);
      this.#mark();
    });
    this.test = new EditorTest(theme, () => this.history.board, (words) => this.#say(words));
    this.check = new EditorCheck((verdict, board) => this.#judged(verdict, board));
    this.boardFields = new NumberFields(byId("board-fields"), (path, value) => this.#write(path, value));
    this.fields = new NumberFields(byId("selected-fields"), (path, value) => this.#write(path, value));
    this.hands = new EditorHands(this.view, () => this.#bench(), {
      onSelect: (ref) => this.#select(ref),
      onPreview: (board, ref) => this.#preview(board, ref),
      onChange: (board, ref) => this.#change(board, ref),
      onSay: (words) => this.#say(words),
      onMark: () => this.#mark(),
      onCommand: (command) => this.#command(command),
    });
    this.#wireKeys();
    this.#wireKeeping();
  }

  /** @param {any} board one that can be drawn @param {string} words */
  open(board, words) {
    this.history.push(board);
    this.selected = null;
    this.hands.cursor = { x: board.drop.x, y: Math.round((board.drop.y + board.bins.y) * 10) / 20 };
    this.#refresh();
    this.#say(words);
    showState("asleep", "Editing");
  }

  #bench() {
    const { board } = this.history;
    return {
      board,
      selected: this.selected,
      tool: document.querySelector("input[name=tool]:checked").value,
      step: Number(byId("snap").value),
      pegRadius: board.pegs[board.pegs.length - 1]?.radius ?? 0.05,
    };
  }

  #change(board, ref) {
    this.history.push(board);
    this.selected = ref;
    this.#refresh();
    const what = ref ? describeRef(board, ref) : `${counted(board.pegs.length, "peg")}, ${counted(board.walls.length, "wall")}`;
    this.#say(`${what}.`);
  }

  #write(path, value) {
    this.#change(written(this.history.board, path, value), this.selected);
  }

  #preview(board, ref) {
    this.view.setBoard(board);
    this.#draw(board, ref, []);
    byId("bubble").hidden = true;
  }

  #select(ref) {
    this.selected = ref;
    this.#showSelected();
    this.#mark();
    if (ref) this.#say(`${describeRef(this.history.board, ref)}.`);
  }

  /** Everything that shows the board, after it has become another one. */
  #refresh() {
    const { board, canUndo, canRedo } = this.history;
    if (this.selected && !holds(board, this.selected)) this.selected = null;
    this.problems = this.problems.filter((ref) => holds(board, ref));
    this.view.setBoard(board);
    byId("undo").disabled = !canUndo;
    byId("redo").disabled = !canRedo;
    byId("name").value = board.name;
    byId("field").setAttribute("aria-label", `${board.name}, ${counted(board.pegs.length, "peg")}`);
    document.title = `${board.name} – Board editor – Plinko`;
    this.boardFields.show(BOARD_ROWS, board);
    this.#showSelected();
    this.#mark();
    this.test.reset();
    document.documentElement.dataset.check = "asked"; // the verdict shown is of another board
    this.check.ask(board);
    this.#keepInAddress(board);
  }

  #showSelected() {
    const { board } = this.history;
    const ref = this.selected;
    byId("selected-title").textContent = ref ? nameOf(ref) : "Nothing selected";
    byId("selected-keys").hidden = !ref;
    byId("duplicate").hidden = !["peg", "wall", "group"].includes(ref?.kind);
    byId("delete").hidden = ref?.kind === "drop";
    this.fields.show(ref ? rowsOf(ref) : [], board);
    this.#markFields();
  }

  #mark() {
    this.#draw(this.history.board, this.selected, this.problems);
    this.#placeBubble();
  }

  #draw(board, selected, problems) {
    const focused = document.activeElement === this.view.field;
    this.view.draw({
      selected,
      problems,
      cursor: focused && !selected && !this.hands.dragging && !this.hands.band ? this.hands.cursor : null,
      band: this.hands.band,
      step: this.#bench().step,
    });
  }

  #judged(verdict, board) {
    this.#problem = verdict.ok ? null : verdict;
    this.problems = verdict.ok ? [] : refsInProblem(board, verdict.field, verdict.message);
    const text = byId("check-text");
    text.dataset.tone = verdict.ok ? "good" : "bad";
    text.textContent = verdict.ok
      ? `It can be played. Digest ${verdict.digest.slice(0, 16)}…`
      : sentence(verdict.message);
    byId("show-problem").hidden = verdict.ok;
    document.documentElement.dataset.check = verdict.ok ? "good" : "bad";
    this.#markFields();
    this.#mark();
  }

  #markFields() {
    const path = this.#problem?.field ?? null;
    this.boardFields.mark(path);
    this.fields.mark(path);
  }

  #placeBubble() {
    const bubble = byId("bubble");
    const [ref] = this.problems;
    bubble.hidden = !ref || !this.#problem || this.hands.dragging;
    if (bubble.hidden) return;
    bubble.textContent = sentence(this.#problem.message);
    this.view.placeBubble(bubble, ref);
  }

  #showProblem() {
    const [ref] = this.problems;
    if (ref) {
      this.#select(ref);
      this.view.field.focus();
      return;
    }
    this.boardFields.focus(this.#problem?.field);
  }

  #command(command) {
    const { board } = this.history;
    if (command === "undo" || command === "redo") this.#travel(command);
    else if (command === "next" || command === "last") this.#step(command === "next" ? 1 : -1, false);
    else if (command === "and-next" || command === "and-last") this.#step(command === "and-next" ? 1 : -1, true);
    else if (command === "all") this.#select(groupOf(refsOf(board)));
    else if (!this.selected) this.#say("Nothing is selected.");
    else if (command === "delete") this.#delete(board, this.selected);
    else this.#duplicate(board, this.selected);
  }

  #travel(way) {
    if (!this.history[way]()) {
      this.#say(way === "undo" ? "There is nothing to undo." : "There is nothing to do again.");
      return;
    }
    this.#refresh();
    this.#say(way === "undo" ? "Undone." : "Done again.");
  }

  /** Goes to the next element from the one selected last; `also` keeps what is selected. */
  #step(by, also) {
    const members = membersOf(this.selected);
    const all = refsOf(this.history.board);
    const refs = also ? all.filter((ref) => groupOf([ref])) : all;
    const last = members.at(-1);
    const whole = last ? { kind: last.kind, index: last.index } : null;
    const at = refs.findIndex((ref) => sameRef(ref, whole));
    const next = refs[(Math.max(at, by < 0 ? 0 : -1) + by + refs.length) % refs.length];
    this.#select(also ? groupOf([...members, next]) : next);
  }

  #delete(board, ref) {
    const left = without(board, ref);
    if (!left) {
      this.#say("A board keeps its start and one bin.");
      return;
    }
    this.hands.cursor = placeOf(board, ref);
    this.#change(left, null);
    this.#say(`${nameOf(ref)} deleted.`);
  }

  #duplicate(board, ref) {
    const made = duplicated(board, ref, this.#bench().step || 0.1);
    if (made) this.#change(made.board, made.ref);
  }

  #say(words) {
    byId("result").textContent = words;
  }

  #wireKeys() {
    for (const id of ["undo", "redo", "delete", "duplicate"]) {
      byId(id).addEventListener("click", () => this.#command(id));
    }
    byId("show-problem").addEventListener("click", () => this.#showProblem());
    byId("snap").addEventListener("change", () => this.#mark());
    byId("name").addEventListener("change", () => this.#write("name", byId("name").value.trim()));
    for (const type of ["focus", "blur"]) this.view.field.addEventListener(type, () => this.#mark());
    document.addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.target.closest("input, #field")) return;
      const key = event.key.toLowerCase();
      if (key !== "z" && key !== "y") return;
      event.preventDefault();
      this.#command(key === "y" || event.shiftKey ? "redo" : "undo");
    });
  }

  #wireKeeping() {
    byId("save").addEventListener("click", () => {
      const { board } = this.history;
      saveFile(`${board.name}.json`, `${JSON.stringify(board, null, 2)}\n`, "application/json");
    });
    byId("load").addEventListener("click", () => byId("file").click());
    byId("file").addEventListener("change", () => this.#load(byId("file").files[0]));
    byId("share").addEventListener("click", () => this.#share());
    byId("register").addEventListener("click", () => this.#register());
    byId("play-room").addEventListener("click", () => this.#playRoom());
    byId("start-from").addEventListener("change", () => this.#startFrom(byId("start-from").value));
  }

  async #load(file) {
    if (!file) return;
    try {
      const board = complete(JSON.parse(await file.text()));
      this.open(board, `Loaded ${file.name}.`);
      this.#note(`Loaded ${file.name}.`);
    } catch (error) {
      if (!(error instanceof SyntaxError || error instanceof RangeError)) throw error;
      const why = error instanceof SyntaxError ? `It is not JSON: ${error.message}.` : error.message;
      this.#note(`${file.name} was not loaded. ${why}`, "bad");
    } finally {
      byId("file").value = ""; // the same file can be chosen again
    }
  }

  /** @param {string} name of a preset, or "" for an empty board */
  async #startFrom(name) {
    await this.#attempt(async () => {
      this.open(name ? (await getJson(`boards/${name}`)).board : EMPTY, name ? `A copy of ${name}.` : "A small board.");
    });
  }

  async #share() {
    const link = window.location.href;
    byId("link-field").hidden = false;
    byId("link").value = link;
    byId("link").select();
    try {
      await navigator.clipboard.writeText(link);
      this.#note(`The link is copied: ${counted(link.length, "character")}, the whole board is in it.`);
    } catch {
      // Without permission or a secure address the browser refuses; the field has the link.
      this.#note("Copy the link from the field: this browser does not let the page do it.");
    }
  }

  async #register() {
    await this.#attempt(async () => {
      const { digest } = await postJson("boards", this.history.board);
      this.#note([
        "Registered under its digest ", make("code", {}, digest), ". ",
        make("a", { href: `replay.html?board=${digest}&seed=1` }, "Replay seed 1 on it"), ".",
      ], "good");
    });
  }

  async #playRoom() {
    await this.#attempt(async () => {
      const { id } = await postJson("rooms", { board: this.history.board });
      window.location.assign(`./?${new URLSearchParams({ room: id })}`);
    });
  }

  /** Does what the server may refuse, and says so where it does. */
  async #attempt(act) {
    try {
      await act();
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#note(sentence(error.message), "bad");
    }
  }

  #note(content, tone = "") {
    const note = byId("keep-text");
    note.dataset.tone = tone;
    note.replaceChildren(...[content].flat());
  }

  /** The address is the link: a reload, or whoever gets it, has this board. */
  async #keepInAddress(board) {
    const packed = await packBoard(board);
    if (board !== this.history.board || packed === this.#packed) return;
    this.#packed = packed;
    const hash = `#board=${packed}`;
    window.history.replaceState(null, "", `${window.location.pathname}${hash}`);
    byId("to-replay").href = `replay.html?seed=1${hash}`;
    byId("to-compare").href = `compare.html?seed=1${hash}`;
    byId("link-field").hidden = true;
  }
}

/** @param {import("./element.js").Ref} ref @returns {string} */
function nameOf({ kind, index, end, refs }) {
  if (refs) return capital(named({ refs }));
  if (kind === "drop") return "Start";
  if (kind === "wall" && end) return `Wall ${index}, end ${end}`;
  return `${{ peg: "Peg", wall: "Wall", edge: "Edge", bin: "Bin" }[kind]} ${index}`;
}

/** The numbers of an element; a group has none. */
function rowsOf({ kind, index }) {
  const rows = {
    group: [],
    drop: [["drop.x", "x, m"], ["drop.y", "y, m"], ["drop.jitter", "Spread, m"]],
    peg: ["x", "y", "radius"].map((name) => [`pegs[${index}].${name}`, `${name}, m`]),
    wall: ["x1", "y1", "x2", "y2"].map((name) => [`walls[${index}].${name}`, `${name}, m`]),
    edge: [[`bins.edges[${index}]`, "x, m"]],
    bin: [[`bins.multipliers[${index}]`, "Pays", 0.1]],
  }[kind];
  return rows.map(([path, label, step]) => ({ path, label, step }));
}

function capital(words) {
  return words[0].toUpperCase() + words.slice(1);
}

/** A message of the server's as it is (it begins with a field's name), with a full stop. */
function sentence(text) {
  return /[.!?]$/.test(text) ? text : `${text}.`;
}

/** The board that the address holds or names, or one to start with. */
async function firstBoard() {
  const packed = boardInHash(window.location.hash);
  if (packed !== null) return [complete(await unpackBoard(packed)), "The board of the link."];
  const name = new URLSearchParams(window.location.search).get("board");
  if (!name) return [EMPTY, "A small board to start with."];
  const { board } = await getJson(`boards/${encodeURIComponent(name)}`);
  return [board, `A copy of ${board.name}.`];
}

openPage(async (theme) => {
  const editor = new Editor(theme);
  const [board, words] = await firstBoard();
  editor.open(board, words);
  window.addEventListener("hashchange", () => window.location.reload());
  const { boards } = await getJson("boards");
  const presets = boards.filter(({ preset }) => preset).map(({ name }) => name);
  byId("start-from").append(
    make("option", { value: "", disabled: "", selected: "" }, "choose a board to copy"),
    make("option", { value: "" }, "a small board"),
    ...presets.map((name) => make("option", { value: name }, name)),
  );
});
