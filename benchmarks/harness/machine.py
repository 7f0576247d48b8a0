"""What the figures were measured on: processor, cores, and the versions of all that matters."""

import os
import platform
import sys
from importlib import metadata
from pathlib import Path

CPU_INFO = Path("/proc/cpuinfo")
PACKAGES = ("numpy", "wasmtime", "numba", "llvmlite", "pymunk", "Box2D", "mpmath", "matplotlib")


def describe() -> dict[str, str]:
    """Name and value of everything a reader needs to judge a figure, in the order to print it."""
    return {
        "processor": processor(),
        "cores": str(cores()),
        "system": f"{platform.system()} {platform.machine()}",
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        **{name: version(name) for name in PACKAGES},
        "load": load(),
    }


def processor() -> str:
    """Model of the processor as the system names it."""
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
    """Version of an installed package, or that it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def load() -> str:
    """Runnable processes over the last minute: figures of a busy machine are noisy."""
    return f"{os.getloadavg()[0]:.1f}" if sys.platform != "win32" else "unknown"
