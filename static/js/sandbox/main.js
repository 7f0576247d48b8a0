// The sandbox page: connects a private box, or the room that the address names, to the canvas, the pointer and the desk.

import { openPage, showState } from "../board/page.js";
import { Chart } from "../instruments/chart.js";
import { worldWords } from "../model/worlds.js";
import { ApiError, postJson } from "../net/api.js";
import { hasServer } from "../net/ask.js";
import { loadMachine } from "../solver/touching/machine.js";
import { t } from "../texts/text.js";
import { copyFrom } from "../util/copy.js";
import { byId, isWithin, make } from "../util/dom.js";
import { capital, fixed, rounded } from "../util/format.js";
import { FrameLoop } from "../util/frame-loop.js";
import { figure } from "../util/scale.js";
import { tab } from "../util/storage.js";
import { isRecord, readStored } from "../util/stored.js";
import { Dials } from "./dials.js";
import { EnergyHistory, energies, massOf, showFacts } from "./energies.js";
import { OwnBox } from "./own-box.js";
import { PointerController } from "./pointer.js";
import { SandboxRoom } from "./room.js";
import { ScenePanel } from "./scene-panel.js";
import { BALL, SOLVER, THROW, WORLD } from "./sliders.js";
import { SandboxView } from "./view.js";
import { showRoomLinks } from "./room-links.js";

/** @import { Point } from "../model/board.js" */
/** @import { ArenaEvent, Diagnostics, Settings } from "../model/messages.js" */
/** @import { RoomReply } from "../net/replies.js" */
/** @import { Theme } from "../paint/theme.js" */
/** @import { Machine } from "../solver/machine.js" */
/** @import { BoxHello, RoomState } from "./room.js" */

const PUBLIC_ROOM = "sandbox";
const TOKENS = "plinko.tokens.1"; // of the rooms this tab has opened
// In the address of a room just made: whether it was made from a private box, to be shared; and its token, if the
// browser stores nothing.
const SHARED = "shared";
const TOKEN = "token";
const CALM_MS = 400; // between two frames where reduced motion is preferred
/** @type {Partial<Record<RoomState, string>>} */
const STATE_TEXTS = {
  connecting: t("play.connecting"), live: t("play.live"), asleep: t("box.at-rest"), paused: t("box.paused"),
  closed: t("play.closed"),
};

/** The page of one room or private box. */
class SandboxPage {
  #still = window.matchMedia("(prefers-reduced-motion: reduce)");
  #drawn = 0;
  #calm = 0;
  /** @type {Record<string, Record<string, number>>} numbers by preset, by setting */
  #presets = {};

  /** @param {Theme} theme @param {string | Machine} played a room's ID, or the machine that computes a private box */
  constructor(theme, played) {
    this.loop = new FrameLoop((now) => this.#draw(now));
    this.view = new SandboxView(theme, () => this.loop.wake());
    this.chart = new Chart(byId("energy", HTMLCanvasElement), theme);
    this.history = new EnergyHistory();
    this.throwing = new Dials(byId("throw-sliders"), THROW, undefined, byId("throw-more"));
    this.throwing.set({ radius: 0.12, speed: 6, angle: 45 });
    /** @param {string} name @param {number} value */
    const set = (name, value) => this.room.send({ type: "settings", [name]: value });
    this.world = new Dials(byId("world-sliders"), WORLD, set, byId("world-more"));
    this.solver = new Dials(byId("solver-sliders"), SOLVER, set);
    this.ball = new Dials(byId("ball-sliders"), BALL, (name, value) =>
      this.room.send({ type: "edit", ball: this.pointer.chosen, [name]: value }));
    this.pointer = this.#makePointer();
    this.scene = new ScenePanel(() => {
      const scene = this.scene.read(this.room.settings);
      if (scene) this.room.send({ type: "reset", scene });
    }, (text) => this.#say(text));
    this.#wireDesk();
    this.room = this.#open(played);
    this.room.watch(document.visibilityState === "visible");
    if (this.room instanceof OwnBox) this.room.begin();
    document.addEventListener("visibilitychange", () => {
      this.room.watch(document.visibilityState === "visible");
      this.loop.wake();
    });
    window.addEventListener("pagehide", () => this.room.letGo());
  }

  /** @param {string | Machine} played @returns {SandboxRoom | OwnBox} */
  #open(played) {
    const listener = {
      onRoom: (/** @type {BoxHello} */ hello) => this.#enter(hello),
      onState: (/** @type {RoomState} */ state, /** @type {string | undefined} */ detail) =>
        this.#showState(state, detail),
      onEvent: (/** @type {ArenaEvent} */ event) => this.#happened(event),
      onError: (/** @type {string} */ message) => this.#say(message),
      onChange: () => this.loop.wake(),
    };
    const isRoom = typeof played === "string";
    document.documentElement.dataset.box = isRoom ? "room" : "own";
    return isRoom ? new SandboxRoom(played, listener) : new OwnBox(played, listener);
  }

  #makePointer() {
    return new PointerController(
      this.view,
      (place, reach) => this.#ballAt(place, reach),
      () => this.throwing.value("radius"),
      {
        onDrag: (ball, { x, y }) => this.room.drag(ball, x, y),
        onLetGo: () => this.room.letGo(),
        onChoose: (ball) => this.#choose(ball),
        onThrow: (place, vx, vy) => this.#throw(place, vx, vy),
        onThrowAimed: () => this.#throwAimed(),
        onKick: () => this.#kick(),
        onRemove: () => this.#remove(),
        onSay: (text) => this.#say(text),
        onChange: () => this.loop.wake(),
      },
    );
  }

  #wireDesk() {
    byId("pause").addEventListener("click", () => this.#pause());
    byId("step").addEventListener("click", () => this.#step());
    byId("clear").addEventListener("click", () => this.room.send({ type: "clear" }));
    byId("reset").addEventListener("click", () => this.room.send({ type: "reset" }));
    byId("throw").addEventListener("click", () => this.#throwAimed());
    byId("drop").addEventListener("click", () => this.room.send({ type: "drop" }));
    byId("remove").addEventListener("click", () => this.#remove());
    for (const name of ["gravity", "restitution"]) {
      const select = byId(`${name}-preset`, HTMLSelectElement);
      select.addEventListener("change", () => {
        if (select.value) this.room.send({ type: "settings", [name]: select.value });
      });
    }
    byId("own").addEventListener("click", () => {
      const scene = this.scene.read(this.room.settings);
      if (scene) void this.#moveInto({ scene });
    });
    byId("share").addEventListener("click", () => this.#share());
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /**
   * Keys pause and step, unless the focused element takes text.
   * @param {KeyboardEvent} event
   */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || this.pointer.locked) return;
    if (isWithin(event, "input:not([type=range]), select")) return;
    /** @type {Record<string, () => void>} */
    const acts = { p: () => this.#pause(), ".": () => this.#step() };
    const act = acts[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  }

  // The room.

  /** @param {BoxHello} hello */
  #enter(hello) {
    const { arena, extent, board } = hello;
    this.view.setGeometry(arena.place, extent);
    this.pointer.begin(extent);
    this.history.rows = [];
    this.#fillPresets(arena.presets);
    this.#showSettings(arena.settings);
    this.scene.show(arena.scene);
    byId("title").textContent = titleOf(hello);
    byId("drop").hidden = !board;
    byId("to-table", HTMLAnchorElement).href = board && hello.room.startsWith("interacting-")
      ? `./?${new URLSearchParams({ room: hello.room })}` : "./";
    this.#choose(null);
    const fresh = new URLSearchParams(window.location.hash.slice(1));
    const given = fresh.get(TOKEN);
    if (given) keepToken(hello.room, given);
    const token = tokens()[hello.room];
    this.#lock(arena.owned);
    if (arena.owned && token) this.room.send({ type: "claim", token });
    this.#describe();
    this.#say(t("box.opened", { title: titleOf(hello), n: this.room.made.size }));
    this.loop.wake();
    if (window.location.hash) history.replaceState(null, "", window.location.href.replace(window.location.hash, ""));
    if (fresh.has(SHARED)) void this.#showLink();
  }

  /** @param {boolean} locked */
  #lock(locked) {
    this.pointer.locked = locked;
    byId("locked").hidden = !locked;
    document.documentElement.dataset.locked = String(locked);
    for (const field of document.querySelectorAll(".desk :is(button:not(#own, #share), select, .dial input)")) {
      field.toggleAttribute("disabled", locked);
    }
    byId("step", HTMLButtonElement).disabled = locked || !this.room.paused;
  }

  /** @param {ArenaEvent} event */
  #happened(event) {
    if (event.type === "claimed") this.#lock(false);
    else if (event.type === "settings") this.#showSettings(event.settings);
    else if (event.type === "placed") this.#describe();
    else if (event.type === "removed") this.#gone(event.balls);
    else if (event.type === "edited") this.#choose(this.pointer.chosen);
    else if (event.type === "diagnostics") this.#measured(event);
    else if (event.type === "landed") {
      this.#gone([event.ball]);
      const { ball, bin } = event;
      this.#say(bin === null ? t("box.ball-rests", { ball }) : t("box.ball-fell", { ball, bin }));
    }
  }

  /** @param {number[]} balls */
  #gone(balls) {
    for (const ball of balls) this.pointer.forget(ball & 0xffff);
    if (this.pointer.chosen === null) this.#choose(null);
    this.#describe();
  }

  /** @param {Diagnostics} event */
  #measured(event) {
    const mass = massOf(this.room.made.values());
    const row = energies(event, mass, this.room.settings, this.view.extent);
    this.history.add(row);
    this.chart.set(this.history.plot());
    showFacts(byId("facts"), event, row);
    const [total, kinetic, potential] = [row.total, row.kinetic, row.potential].map(figure);
    byId("energy").setAttribute("aria-label", t("box.energy-words", { total, kinetic, potential }));
  }

  /** @param {Settings} settings */
  #showSettings(settings) {
    this.world.set(settings);
    this.solver.set(settings);
    byId("pause").textContent = this.room.paused ? t("box.resume") : t("word.pause");
    byId("step", HTMLButtonElement).disabled = this.pointer.locked || !this.room.paused;
    for (const [name, options] of Object.entries(this.#presets)) {
      const found = Object.entries(options).find(([, value]) => Math.abs(value - settings[name]) < 1e-9);
      const select = byId(`${name}-preset`, HTMLSelectElement);
      // Presets may have equal numbers: the one that the player has chosen stays.
      if (!select.value || options[select.value] !== settings[name]) select.value = found?.[0] ?? "";
    }
  }

  /** @param {RoomState} state @param {string} [detail] */
  #showState(state, detail) {
    showState(state, state === "reconnecting"
      ? t("play.reconnecting", { seconds: detail ?? "" }) : (STATE_TEXTS[state] ?? ""));
    if (state === "closed") {
      this.#say(detail || t("box.room-closed"));
      void showRoomLinks();
    }
    // A snapshot from before a drag can still say that all balls sleep.
    if (state === "asleep" && this.room.made.size && !this.pointer.holds) this.#say(t("box.all-rest"));
    this.loop.wake();
  }

  /** @param {Record<string, Record<string, number>>} presets */
  #fillPresets(presets) {
    this.#presets = presets;
    for (const [name, values] of Object.entries(presets)) {
      const select = byId(`${name}-preset`, HTMLSelectElement);
      if (select.options.length) continue;
      const own = make("option", { value: "" }, t("box.as-set"));
      select.append(own, ...Object.entries(values).map(([preset, value]) =>
        make("option", { value: preset }, `${worldWords(capital(preset))} (${fixed(value, 2)})`)));
    }
  }

  // Actions.

  /** @param {Point} point @param {number} vx @param {number} vy */
  #throw({ x, y }, vx, vy) {
    const radius = this.throwing.value("radius");
    const sent = this.room.send({ type: "add", x, y, vx, vy, radius });
    const speed = Math.hypot(vx, vy);
    if (!sent) this.#say(t("box.no-line"));
    else this.#say(speed ? t("box.thrown", { speed: fixed(speed, 1) }) : t("box.put-down"));
  }

  /** @returns {[number, number]} m/s */
  #aimed() {
    const angle = (this.throwing.value("angle") * Math.PI) / 180;
    const speed = this.throwing.value("speed");
    return [speed * Math.cos(angle), -speed * Math.sin(angle)];
  }

  #throwAimed() {
    this.#throw(this.pointer.cross, ...this.#aimed());
  }

  #kick() {
    const ball = this.pointer.chosen ?? this.#ballAt(this.pointer.cross, Number.POSITIVE_INFINITY);
    if (ball === null) return;
    const [vx, vy] = this.#aimed();
    this.room.send({ type: "kick", ball, vx, vy });
    this.#say(t("box.kicked", { ball }));
  }

  #remove() {
    const ball = this.pointer.chosen ?? this.#ballAt(this.pointer.cross, 0.1);
    if (ball === null) return;
    this.room.send({ type: "remove", ball });
    this.#say(t("box.removed", { ball }));
  }

  #pause() {
    this.room.send({ type: "pause", paused: !this.room.paused });
    this.#say(this.room.paused ? t("box.going-on") : t("box.paused-said"));
  }

  #step() {
    if (this.room.paused) this.room.send({ type: "step" });
  }

  /** @param {number | null} ball */
  #choose(ball) {
    this.pointer.chosen = ball;
    const made = ball === null ? undefined : this.room.made.get(ball);
    byId("ball-panel").hidden = !made;
    if (!made) return;
    const mass = massOf([made]);
    byId("ball-title").textContent = t("box.ball-title", { ball: String(ball), mass: rounded(mass, 3) });
    this.ball.set(made);
  }

  /**
   * Finds the ball at a point, or the nearest within reach.
   * @param {Point} point
   * @param {number} reach m
   */
   #ballAt({ x, y }, reach) {
    let best = reach;
    /** @type {number | null} */
    let found = null;
    for (const ball of this.room.look(performance.now())) {
      const away = Math.max(0, Math.hypot(ball.x - x, ball.y - y) - ball.radius);
      if (away < best || (away === 0 && best === 0 && found === null)) [best, found] = [away, ball.id];
    }
    return found;
  }

  // Sharing.

  /** Makes a room from a private box; shows the link of a room. */
  async #share() {
    if (this.room instanceof OwnBox) await this.#moveInto({ story: this.room.story }, { [SHARED]: "" });
    else await this.#showLink();
  }

  async #showLink() {
    const link = window.location.href.replace(window.location.hash, "");
    const copied = await copyFrom(byId("share-link", HTMLInputElement), link);
    this.#say(copied ? t("box.copied") : t("box.marked"));
  }

  /** @param {object} wanted of the room @param {Record<string, string>} [fresh] for the hash of its address */
  async #moveInto(wanted, fresh = {}) {
    try {
      const { id, token } = /** @type {RoomReply} */ (await postJson("rooms", wanted));
      const hash = String(new URLSearchParams({ ...fresh, ...(!keepToken(id, token) && { [TOKEN]: token }) }));
      window.location.assign(`sandbox.html?${new URLSearchParams({ room: id })}${hash && `#${hash}`}`);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.#say(error.message);
    }
  }

  // The picture.

  /** @param {number} now */
  #draw(now) {
    if (this.#still.matches && now - this.#drawn < CALM_MS) {
      // Draw less often, but always draw the last change.
      if (this.#calm !== 0) return false;
      this.#calm = setTimeout(() => {
        this.#calm = 0;
        this.loop.wake();
      }, CALM_MS);
      return false;
    }
    this.#drawn = now;
    this.view.draw(this.room.look(now), this.pointer);
    return this.room.busy;
  }

  #describe() {
    byId("board-moving").setAttribute("aria-label", t("box.describe", { n: this.room.made.size }));
  }

  /** @param {string} text */
  #say(text) {
    byId("result").textContent = text;
  }
}

/** @param {BoxHello} hello */
function titleOf({ board, board_name: name, arena }) {
  if (board) return t("box.touching-on", { board: name });
  return arena.scene?.scene === "galton" ? t("box.galton") : t("page.sandbox");
}

/** @returns {Record<string, string | undefined>} by room */
function tokens() {
  return readStored(tab, TOKENS, isTokens) ?? {};
}

/** @param {unknown} value @returns {value is Record<string, string>} */
function isTokens(value) {
  return isRecord(value) && Object.values(value).every((token) => typeof token === "string");
}

/** @param {string} room @param {string} token @returns {boolean} whether it outlives this page */
function keepToken(room, token) {
  return tab.setItem(TOKENS, JSON.stringify({ ...tokens(), [room]: token }));
}

openPage(async (theme) => {
  const room = hasServer ? new URLSearchParams(window.location.search).get("room") : null;
  const machine = room || (hasServer && typeof WebAssembly === "undefined") ? null : await loadMachine();
  new SandboxPage(theme, machine ?? room ?? PUBLIC_ROOM);
});
