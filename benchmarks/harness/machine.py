"""A description of the machine: processor, cores, load, and versions of the packages in use."""

import os
import platform
import sys
from importlib import metadata
from pathlib import Path

CPU_INFO = Path("/proc/cpuinfo")
PACKAGES = ("numpy", "wasmtime", "numba", "llvmlite", "pymunk", "Box2D", "mpmath", "matplotlib")


def describe() -> dict[str, str]:
    """Everything a reader needs to judge a figure, by name, in the order to print it."""
    return {
        "processor": processor(),
        "cores": str(cores()),
        "system": f"{platform.system()} {platform.machine()}",
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        **{name: version(name) for name in PACKAGES},
        "load": load(),
    }


def processor() -> str:
    """The processor's model, as the system names it."""
    if CPU_INFO.is_file():
        for line in CPU_INFO.read_text().splitlines():
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def version(package: str) -> str:
    """The package's version, or "not installed"."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def load() -> str:
    """Mean number of runnable processes in the last minute: a busy machine gives noisy figures."""
    return f"{os.getloadavg()[0]:.1f}" if sys.platform != "win32" else "unknown"
