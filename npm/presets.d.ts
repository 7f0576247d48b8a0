import type { Board } from "./model/board.js";

declare const board: Board;
export default board;
