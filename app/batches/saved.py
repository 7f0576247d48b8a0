"""Load and save results of batches. Files are replaced atomically: a kill cannot damage them."""

import json
from pathlib import Path

from engine import RecordError
from engine.batches.tally import Tally, tally_of

SECONDS = "seconds"
"""The field of a file for the s that its blocks took; all other fields are the tally's."""


def load(path: Path) -> tuple[Tally, float]:
    """Read a tally and the s that it took; raises RecordError if the file is invalid."""
    try:
        form = json.loads(path.read_text(encoding="utf-8"))
        tally = tally_of(form)
        seconds = form.get(SECONDS, 0.0)
        if isinstance(seconds, bool) or not isinstance(seconds, int | float):
            raise RecordError(f"seconds {seconds!r} is not a number", field=SECONDS)
    except RecordError as error:
        raise RecordError(f"{path}: {error}", field=error.field) from None
    except ValueError as error:  # not JSON, or not UTF-8
        raise RecordError(f"{path}: this is not a JSON file: {error}") from None
    return tally, float(seconds)


def form_of(tally: Tally, seconds: float) -> dict[str, object]:
    """The JSON form of a result, for files and for `--json`."""
    form = tally.to_dict()
    hashes = form.pop("hashes")
    rate = {"drops_per_second": tally.drops / seconds} if seconds else {}
    return {**form, SECONDS: seconds, **rate, "hashes": hashes}


def save(path: Path, tally: Tally, seconds: float) -> None:
    """Replace the file atomically."""
    unfinished = path.with_name(path.name + ".new")
    unfinished.write_text(json.dumps(form_of(tally, seconds)) + "\n", encoding="utf-8")
    unfinished.replace(path)
