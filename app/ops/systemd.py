"""Tells systemd that the server is ready, still alive or stopping (sd_notify)."""

import asyncio
import os
import socket


def notify(state: str) -> None:
    """Send `state`, such as READY=1, to the service manager; nothing without one."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if address:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
            # An address that begins with @ is abstract: its first byte is 0.
            sender.sendto(state.encode(), f"\0{address[1:]}" if address[0] == "@" else address)


async def keep_alive() -> None:
    """Tell the watchdog of this process twice in its time that the event loop runs."""
    if os.environ.get("WATCHDOG_PID", "") not in ("", str(os.getpid())):
        return
    seconds = int(os.environ.get("WATCHDOG_USEC", "0")) / 2e6
    while seconds:
        notify("WATCHDOG=1")
        await asyncio.sleep(seconds)
