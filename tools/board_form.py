"""The pages' copy of the table of a board's fields. `make readme` writes it."""

import json
from pathlib import Path

from plinko.engine.board.form import FORM, Field

FILE = Path(__file__).parents[1] / "static" / "js" / "solver" / "input" / "form.js"

SCRIPT = """\
// The fields of a board's JSON form, in the order of its digest, with ranges and defaults.
// `make readme` writes this file from engine/board/form.py.

/**
 * @typedef {{name: string, low?: number, high?: number, most?: number, otherwise?: number}} Field
 *   most: items of a list; otherwise: the default
 */

/** @satisfies {Record<string, Field[]>} */
export const FORM = {
ROWS
};
"""


def script() -> str:
    rows = []
    for part, fields in FORM.items():
        rows += [f"  {part}: [", *(f"    {_row(field)}," for field in fields), "  ],"]
    return SCRIPT.replace("ROWS", "\n".join(rows))


def _row(field: Field) -> str:
    values = {
        "name": field.name,
        "low": None if field.low == field.high else _number(field.low),
        "high": None if field.low == field.high else _number(field.high),
        "most": field.most or None,
        "otherwise": None if field.default is None else _number(field.default),
    }
    shown = {key: value for key, value in values.items() if value is not None}
    return f"{{ {', '.join(f'{key}: {json.dumps(value)}' for key, value in shown.items())} }}"


def _number(value: float) -> float:
    return int(value) if value.is_integer() else value


if __name__ == "__main__":
    FILE.write_text(script(), encoding="utf-8")
