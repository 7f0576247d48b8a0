"""Results of batches as files: the old or the new is there whenever the writer is stopped."""

import json
from pathlib import Path

from engine import RecordError
from engine.batches.tally import Tally, tally_of

SECONDS = "seconds"
"""What a file has beside the tally: how long its blocks took, s."""


def load(path: Path) -> tuple[Tally, float]:
    """The tally in a file, and the s that it took; RecordError that names the file."""
    try:
        form = json.loads(path.read_text(encoding="utf-8"))
        tally = tally_of(form)
        seconds = form.get(SECONDS, 0.0)
        if isinstance(seconds, bool) or not isinstance(seconds, int | float):
            raise RecordError(f"seconds {seconds!r} is not a number", field=SECONDS)
    except RecordError as error:
        raise RecordError(f"{path}: {error}", field=error.field) from None
    except ValueError as error:  # neither JSON nor text
        raise RecordError(f"{path}: not JSON: {error}") from None
    return tally, float(seconds)


def form_of(tally: Tally, seconds: float) -> dict[str, object]:
    """The JSON form: of the file, and of `--json`."""
    form = tally.to_dict()
    hashes = form.pop("hashes")
    rate = {"drops_per_second": tally.drops / seconds} if seconds else {}
    return {**form, SECONDS: seconds, **rate, "hashes": hashes}


def save(path: Path, tally: Tally, seconds: float) -> None:
    """Write the file anew, at once."""
    unfinished = path.with_name(path.name + ".new")
    unfinished.write_text(json.dumps(form_of(tally, seconds)) + "\n", encoding="utf-8")
    unfinished.replace(path)
