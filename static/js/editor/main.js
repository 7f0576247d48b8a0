// The editor page: connects the board that its address contains or names with its view, panels, checks and test drops.

import { openPage, showState } from "../board/page.js";
import { ApiError, getJson, postJson } from "../net/api.js";
import { boardInHash, unpackBoard } from "../net/board-link.js";
import { t } from "../texts/text.js";
import { byId, isWithin, radioValue, say } from "../util/dom.js";
import { withFullStop } from "../util/format.js";
import { complete, describeRef, EMPTY, holds, refsInProblem, refsOf, written } from "./draft/draft.js";
import { duplicated, placeOf, without } from "./draft/element.js";
import { groupOf, membersOf, sameElement } from "./draft/group.js";
import { EditHistory } from "./draft/history.js";
import { Keeping } from "./keeping.js";
import { NumberFields } from "./number-fields.js";
import { offerPayouts } from "./payouts.js";
import { PointerController } from "./pointer.js";
import { BOARD_ROWS, nameOf, rowsOf } from "./rows.js";
import { TestDrops } from "./test-drops.js";
import { EditorView } from "./view.js";

/** @import { Board } from "../model/board.js" */
/** @import { BoardReply } from "../net/replies.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { ElementRef, Ref } from "./draft/element.js" */
/** @import { Bench, Command } from "./pointer.js" */

const PAUSE_MS = 250; // without a change before the server is asked

class Editor {
  /** @type {Ref | null} */
  selected = null;
  /** @type {ElementRef[]} elements that the server's error is about */
  problems = [];
  /** Why the server refuses the board. @type {ApiError | null} */
  #problem = null;
  #timer = 0;

  /** @param {Theme} theme */
  constructor(theme) {
    this.history = new EditHistory(EMPTY);
    const board = () => this.history.board;
    this.view = new EditorView(theme, (geometry) => {
      this.test.histogram.layOut(geometry);
      this.#mark();
    });
    this.test = new TestDrops(theme, board, (text) => this.#say(text));
    offerPayouts(board, (solved) => this.#change(solved, this.selected), (text) => this.#say(text));
    this.keeping = new Keeping(board, (other, said) => this.open(other, said));
    this.name = byId("name", HTMLInputElement);
    this.boardFields = new NumberFields(byId("board-fields"), (path, value) => this.#write(path, value));
    this.fields = new NumberFields(byId("selected-fields"), (path, value) => this.#write(path, value));
    this.pointer = new PointerController(this.view, () => this.#bench(), {
      onSelect: (ref) => this.#select(ref),
      onPreview: (board, ref) => this.#preview(board, ref),
      onChange: (board, ref) => this.#change(board, ref),
      onSay: (text) => this.#say(text),
      onMark: () => this.#mark(),
      onCommand: (command) => this.#command(command),
    });
    this.#wireKeys();
  }

  /** @param {Board} board with all parts that drawing needs @param {string} said message for the visitor */
  open(board, said) {
    this.history.push(board);
    this.selected = null;
    this.pointer.cursor = { x: board.drop.x, y: Math.round((board.drop.y + board.bins.y) * 10) / 20 };
    this.#refresh();
    this.#say(said);
    showState("asleep", t("editor.editing"));
  }

  /** @returns {Bench} */
  #bench() {
    const { board } = this.history;
    return {
      board,
      selected: this.selected,
      tool: /** @type {Bench["tool"]} */ (radioValue("tool")),
      step: Number(byId("snap", HTMLSelectElement).value),
      pegRadius: board.pegs[board.pegs.length - 1]?.radius ?? 0.05,
    };
  }

  /** @param {Board} board @param {Ref | null} ref */
  #change(board, ref) {
    this.history.push(board);
    this.selected = ref;
    this.#refresh();
    const all = [t("editor.pegs", { n: board.pegs.length }), t("editor.walls", { n: board.walls.length })].join(", ");
    this.#say(`${ref ? describeRef(board, ref) : all}.`);
  }

  /** @param {string} path @param {number | string} value */
  #write(path, value) {
    this.#change(written(this.history.board, path, value), this.selected);
  }

  /** @param {Board} board @param {Ref} ref */
  #preview(board, ref) {
    this.view.setBoard(board);
    this.#draw(ref, []);
    byId("bubble").hidden = true;
  }

  /** @param {Ref | null} ref */
  #select(ref) {
    this.selected = ref;
    this.#showSelected();
    this.#mark();
    if (ref) this.#say(`${describeRef(this.history.board, ref)}.`);
  }

  /** Updates everything that shows the board, after the board has changed. */
  #refresh() {
    const { board, canUndo, canRedo } = this.history;
    if (this.selected && !holds(board, this.selected)) this.selected = null;
    this.problems = this.problems.filter((ref) => holds(board, ref));
    this.view.setBoard(board);
    byId("undo", HTMLButtonElement).disabled = !canUndo;
    byId("redo", HTMLButtonElement).disabled = !canRedo;
    this.name.value = board.name;
    byId("field").setAttribute("aria-label", `${board.name}, ${t("editor.pegs", { n: board.pegs.length })}`);
    document.title = t("editor.title-board", { board: board.name });
    this.boardFields.show(BOARD_ROWS, board);
    this.#showSelected();
    this.#mark();
    this.test.reset();
    document.documentElement.dataset.check = "asked"; // the verdict that is shown is about the previous board
    this.#ask(board);
    this.keeping.keepInAddress(board);
  }

  /** Has the server check the board a moment after its last change. @param {Board} board */
  #ask(board) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(async () => {
      const asked = postJson("boards/check", board).catch((error) => error);
      const reply = /** @type {BoardReply | Error} */ (await asked);
      if (reply instanceof Error && !(reply instanceof ApiError)) throw reply;
      if (board === this.history.board) this.#judged(reply, board);
    }, PAUSE_MS);
  }

  #showSelected() {
    const { board } = this.history;
    const ref = this.selected;
    byId("selected-title").textContent = ref ? nameOf(ref) : t("editor.nothing-selected");
    byId("selected-keys").hidden = !ref;
    byId("duplicate").hidden = !ref || !["peg", "wall", "group"].includes(ref.kind);
    byId("delete").hidden = ref?.kind === "drop";
    this.fields.show(ref ? rowsOf(ref, board) : [], board);
    this.#markFields();
  }

  #mark() {
    this.#draw(this.selected, this.problems);
    this.#placeBubble();
  }

  /** @param {Ref | null} selected @param {ElementRef[]} problems */
  #draw(selected, problems) {
    const focused = document.activeElement === this.view.field;
    const busy = this.pointer.dragging || this.pointer.band !== null;
    this.view.draw({
      selected,
      problems,
      cursor: focused && !selected && !busy ? this.pointer.cursor : null,
      band: this.pointer.band,
      step: this.#bench().step,
    });
  }

  /** @param {BoardReply | ApiError} reply @param {Board} board */
  #judged(reply, board) {
    const problem = reply instanceof ApiError ? reply : null;
    this.#problem = problem;
    this.problems = problem ? refsInProblem(board, problem.field, problem.message) : [];
    const words = reply instanceof ApiError
      ? withFullStop(reply.message) : t("editor.playable", { digest: reply.digest.slice(0, 16) });
    say(byId("check-text"), problem ? "bad" : "good", words);
    byId("show-problem").hidden = !problem;
    document.documentElement.dataset.check = problem ? "bad" : "good";
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
    const problem = this.pointer.dragging ? null : this.#problem;
    bubble.hidden = !ref || !problem;
    if (!ref || !problem) return;
    bubble.textContent = withFullStop(problem.message);
    this.view.placeBubble(bubble, ref);
  }

  #showProblem() {
    const [ref] = this.problems;
    if (ref) {
      this.#select(ref);
      this.view.field.focus();
      return;
    }
    if (this.#problem?.field) this.boardFields.focus(this.#problem.field);
  }

  /** @param {Command} command */
  #command(command) {
    const { board } = this.history;
    if (command === "undo" || command === "redo") this.#travel(command);
    else if (command === "next") this.#step(1, false);
    else if (command === "last") this.#step(-1, false);
    else if (command === "and-next") this.#step(1, true);
    else if (command === "and-last") this.#step(-1, true);
    else if (command === "all") this.#select(groupOf(refsOf(board)));
    else if (!this.selected) this.#say(t("editor.nothing-is-selected"));
    else if (command === "delete") this.#delete(board, this.selected);
    else {
      const made = duplicated(board, this.selected, this.#bench().step || 0.1);
      if (made) this.#change(made.board, made.ref);
    }
  }

  /** @param {"undo" | "redo"} way */
  #travel(way) {
    if (!this.history.travel(way)) {
      this.#say(way === "undo" ? t("editor.undo-none") : t("editor.redo-none"));
      return;
    }
    this.#refresh();
    this.#say(way === "undo" ? t("editor.undone") : t("editor.redone"));
  }

  /**
   * Selects the next element after the one selected last; with `also`, in addition to the selection.
   * @param {number} by
   * @param {boolean} also
   */
  #step(by, also) {
    const members = membersOf(this.selected);
    const all = refsOf(this.history.board);
    const refs = also ? all.filter((ref) => groupOf([ref])) : all;
    const last = members.at(-1);
    /** @type {ElementRef | null} */
    const whole = last ? { kind: last.kind, index: last.index } : null;
    const at = refs.findIndex((ref) => sameElement(ref, whole));
    const next = refs[(Math.max(at, by < 0 ? 0 : -1) + by + refs.length) % refs.length];
    this.#select(also ? groupOf([...members, next]) : next);
  }

  /** @param {Board} board @param {Ref} ref */
  #delete(board, ref) {
    const left = without(board, ref);
    if (!left) {
      this.#say(t("editor.keeps"));
      return;
    }
    this.pointer.cursor = placeOf(board, ref);
    this.#change(left, null);
    this.#say(t("editor.deleted", { what: nameOf(ref) }));
  }

  /** @param {string} text */
  #say(text) {
    byId("result").textContent = text;
  }

  #wireKeys() {
    for (const id of /** @type {const} */ (["undo", "redo", "delete", "duplicate"])) {
      byId(id).addEventListener("click", () => this.#command(id));
    }
    byId("show-problem").addEventListener("click", () => this.#showProblem());
    byId("snap").addEventListener("change", () => this.#mark());
    this.name.addEventListener("change", () => this.#write("name", this.name.value.trim()));
    for (const type of ["focus", "blur"]) this.view.field.addEventListener(type, () => this.#mark());
    document.addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || isWithin(event, "input, #field")) return;
      const key = event.key.toLowerCase();
      if (key !== "z" && key !== "y") return;
      event.preventDefault();
      this.#command(key === "y" || event.shiftKey ? "redo" : "undo");
    });
  }
}

/** @returns {Promise<{board: Board, said: string}>} said: message for the visitor */
async function firstBoard() {
  const packed = boardInHash(window.location.hash);
  if (packed !== null) {
    return { board: complete(await unpackBoard(packed)), said: t("editor.opened-link") };
  }
  const name = new URLSearchParams(window.location.search).get("board");
  if (!name) return { board: EMPTY, said: t("editor.opened-start") };
  const reply = await getJson(`boards/${encodeURIComponent(name)}`);
  const { board } = /** @type {BoardReply} */ (reply);
  return { board, said: t("editor.copy-of", { board: board.name }) };
}

openPage(async (theme) => {
  const editor = new Editor(theme);
  const { board, said } = await firstBoard();
  editor.open(board, said);
  window.addEventListener("hashchange", () => window.location.reload());
  await editor.keeping.listPresets();
});
