// The editor's panel "Share and keep": link, file, registration, a room to play in, a preset to start from.

import { boardOptions } from "../board/page.js";
import { ApiError, getJson, postJson } from "../net/api.js";
import { packBoard } from "../net/board-link.js";
import { JsonError, readJson, textOfFile } from "../solver/input/json-text.js";
import { t } from "../texts/text.js";
import { copyFrom } from "../util/copy.js";
import { byId, make } from "../util/dom.js";
import { saveFile } from "../util/file.js";
import { withFullStop } from "../util/format.js";
import { complete, EMPTY } from "./draft/draft.js";

/** @import { Board } from "../model/board.js" */
/** @import { BoardList, BoardReply, RoomReply } from "../net/replies.js" */

/** The panel, and the page's address, which always contains the whole board. */
export class Keeping {
  #packed = "";

  /**
   * @param {() => Board} board the edited one
   * @param {(board: Board, said: string) => void} open begins to edit another board
   */
  constructor(board, open) {
    this.board = board;
    this.open = open;
    this.file = byId("file", HTMLInputElement);
    this.link = byId("link", HTMLInputElement);
    this.linkField = byId("link-field");
    this.presets = byId("start-from", HTMLSelectElement);
    byId("save").addEventListener("click", () =>
      saveFile(`${board().name}.json`, `${JSON.stringify(board(), null, 2)}\n`, "application/json"));
    byId("load").addEventListener("click", () => this.file.click());
    this.file.addEventListener("change", () => this.#load());
    byId("share").addEventListener("click", () => this.#share());
    byId("register").addEventListener("click", () => this.#register());
    byId("play-room").addEventListener("click", () => this.#playRoom());
    this.presets.addEventListener("change", () => this.#startFrom(this.presets.value));
  }

  /** Fills the list of presets to start from. */
  async listPresets() {
    const { boards } = /** @type {BoardList} */ (await getJson("boards"));
    // The variants for low and high risk differ only in payouts.
    const presets = boards.filter(({ preset, risk }) => preset && (risk ?? "medium") === "medium");
    this.presets.append(
      make("option", { value: "", disabled: "", selected: "" }, t("editor.choose-board")),
      make("option", { value: "" }, t("editor.small-board")),
      ...boardOptions(presets.map(({ name, world }) => ({ value: name, name, world }))),
    );
  }

  /** Puts the board into the page's address, so that a reload or a shared link opens it. @param {Board} board */
  async keepInAddress(board) {
    const packed = await packBoard(board);
    if (board !== this.board() || packed === this.#packed) return;
    this.#packed = packed;
    const hash = `#board=${packed}`;
    window.history.replaceState(null, "", `${window.location.pathname}${hash}`);
    byId("to-replay", HTMLAnchorElement).href = `replay.html?seed=1${hash}`;
    this.linkField.hidden = true;
  }

  async #load() {
    const file = this.file.files?.[0];
    if (!file) return;
    try {
      const said = t("editor.loaded", { file: file.name });
      this.open(complete(readJson(await textOfFile(file), false)), said);
      this.#note([said]);
    } catch (error) {
      if (!(error instanceof JsonError || error instanceof RangeError)) throw error;
      this.#note([t("editor.not-loaded", { file: file.name, why: withFullStop(error.message) })], "bad");
    } finally {
      this.file.value = ""; // the same file can be chosen again
    }
  }

  /** @param {string} name of a preset, or "" for an empty board */
  async #startFrom(name) {
    await this.#attempt(async () => {
      if (name) {
        const { board } = /** @type {BoardReply} */ (await getJson(`boards/${name}`));
        this.open(board, t("editor.copy-of", { board: name }));
      } else {
        this.open(EMPTY, t("editor.opened-small"));
      }
    });
  }

  async #share() {
    const address = window.location.href;
    this.linkField.hidden = false;
    const copied = await copyFrom(this.link, address);
    this.#note([copied ? t("editor.link-copied", { n: address.length }) : t("editor.link-marked")]);
  }

  async #register() {
    await this.#attempt(async () => {
      const { digest } = /** @type {BoardReply} */ (await postJson("boards", this.board()));
      this.#note([
        t("editor.registered"), " ", make("code", {}, digest), " ",
        make("a", { href: `replay.html?board=${digest}&seed=1` }, t("editor.replay-it")),
      ], "good");
    });
  }

  async #playRoom() {
    await this.#attempt(async () => {
      const { id } = /** @type {RoomReply} */ (await postJson("rooms", { board: this.board() }));
      window.location.assign(`./?${new URLSearchParams({ room: id })}`);
    });
  }

  /** Runs a request, and shows the message if the server refuses it. @param {() => Promise<void>} act */
  async #attempt(act) {
    try {
      await act();
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#note([withFullStop(error.message)], "bad");
    }
  }

  /** @param {(Node | string)[]} content @param {"" | "good" | "bad"} [tone] */
  #note(content, tone = "") {
    const note = byId("keep-text");
    note.dataset.tone = tone;
    note.replaceChildren(...content);
  }
}
