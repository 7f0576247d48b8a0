"""Load and save results of batches. Files are replaced atomically: a kill cannot damage them."""

import json
from pathlib import Path
from typing import Final

from plinko.app.batches.files import write_whole
from plinko.engine import PlinkoError, RecordError, json_text
from plinko.engine.batches.tally import Tally, tally_of
from plinko.engine.parameters import number

SECONDS = "seconds"
"""The field of a file for the computing time in s; all other fields are the tally's."""

MOST_SECONDS: Final = 1e12  # 30,000 years

LARGEST: Final = 1 << 27
"""Bytes of a file: more than a result with the most hashes, and with the largest board, has."""


def load(path: Path) -> tuple[Tally, float]:
    """Read a tally and its computing time in s; raises RecordError if the file is invalid."""
    try:
        form = json_text.parse(json_text.read_text(path, LARGEST))
        tally = tally_of(form)
        seconds = number(form.get(SECONDS, 0.0), SECONDS, 0.0, MOST_SECONDS)
    except PlinkoError as error:
        raise RecordError(f"{path}: {error}", field=error.field) from None
    return tally, seconds


def form_of(tally: Tally, seconds: float) -> dict[str, object]:
    """The JSON form of a result, for files and for `--json`."""
    form = tally.to_dict()
    hashes = form.pop("hashes")
    rate = {"drops_per_second": tally.drops / seconds} if seconds else {}
    return {**form, SECONDS: seconds, **rate, "hashes": hashes}


def save(path: Path, tally: Tally, seconds: float) -> None:
    """Replace the file atomically."""
    write_whole(path, f"{json.dumps(form_of(tally, seconds))}\n".encode())
