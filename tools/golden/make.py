"""Writes the golden digests: python -m tools.golden.make [--initial]

Refuses to change any digest under the same PHYSICS_VERSION: raise it in engine/constants.py and
describe the change in CHANGELOG.md under 'Simulation results changed'. New boards may be added at
any time. --initial overwrites everything; use it only before anyone relies on a result.
"""

import sys

from tools.golden import check
from tools.golden.lines import in_lines


def changed(old: check.Entry, new: check.Entry) -> list[str]:
    """One line for each entry of `old` that is missing or different in `new`."""
    lines = []
    for group in ("drops", "batches"):
        for name, entry in old[group].items():
            if name not in new[group]:
                lines.append(f"{name} is gone")
            else:
                lines += check.differences(entry, new[group][name], name)
    return lines


def main(arguments: list[str]) -> int:
    """Write the file; returns 1 instead if results changed under the same version."""
    new = check.current()
    if check.FILE.exists() and "--initial" not in arguments:
        old = check.golden()
        lines = changed(old, new) if old["physics_version"] == new["physics_version"] else []
        if lines:
            print("\n".join(lines))
            print("results changed: raise PHYSICS_VERSION first")
            return 1
    check.FILE.write_text(in_lines(new), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
