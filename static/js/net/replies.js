// The replies of the REST API; docs/api.md describes each. Types only.

/** @import { Odds } from "../model/odds.js" */
/** @import { Board } from "../model/board.js" */

/**
 * @typedef {{preset: boolean, name: string, digest: string, world: string | null, risk: string | null,
 *   stakes?: boolean}} BoardSummary
 * @typedef {{boards: BoardSummary[]}} BoardList of GET boards
 * @typedef {{board: Board, digest: string}} BoardReply of GET boards/…, POST boards and boards/check
 * @typedef {{id: string, token: string}} RoomReply of POST rooms
 * @typedef {{plays: {name: string | null, colour: string | null, bin: number | null, score: number, payout: number,
 *   board_digest: string, seed: string, x: number | null, aim: number | null}[]}} Plays of GET rooms/…/best
 * @typedef {{rooms: {id: string, mode: string, board_name: string}[]}} RoomList of GET rooms
 * @typedef {{board_digest: string, aims: Odds[]}} OddsReply of GET boards/…/odds
 * @typedef {{multipliers: number[], drops: number, chosen_by: number, least: {aim: number | null, return: number},
 *   aims: Odds[], rare_bins: number[], falling_bins: number[]}} PayoutsReply of POST payouts
 * @typedef {{value: number, target: number, label?: string}} Goal
 * @typedef {{panel?: string | null, ink?: string | null, accent?: string | null, font?: string | null,
 *   logo?: string | null}} Looks
 * @typedef {{timer?: {left: number, label?: string, running?: boolean}, goals?: Goal[], looks?: Looks,
 *   jackpot?: {value: number, label?: string, unit?: string}, faces?: Record<string, string>}} Show
 * @typedef {{age: number, show: Show}} ShowReply of GET rooms/…/show; age: seconds
 * @typedef {{ok: boolean, field?: string, expected?: unknown, actual?: unknown}} Verification
 */
