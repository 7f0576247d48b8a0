"""The `plinko` command: one file per subcommand, imported only when that subcommand runs.

drops/ computes, boards/ lists and makes boards, server/ runs a server or talks to one. Imports
everything. Start with drops/drop.py; common.py has the options that several subcommands share.
"""

import atexit
import gc
import importlib
import logging
import os
import sys
from collections.abc import Sequence

import click

from plinko.app.cli import common

GROUPS = {
    "One drop": {
        "drop": "drops.drop",
        "certify": "drops.certify",
        "verify": "drops.verify",
        "render": "drops.render",
        "map": "drops.map",
    },
    "Many drops": {
        "simulate": "drops.simulate",
        "merge": "drops.merge",
        "seeds": "drops.seeds",
    },
    "Boards": {
        "boards": "boards.boards",
        "odds": "boards.odds",
        "payouts": "boards.payouts",
        "calibrate": "boards.calibrate",
    },
    "Server": {
        "serve": "server.serve",
        "site": "server.site",
    },
    "For operators": {
        "ledger": "server.ledger",
        "halt": "server.operator:halt",
        "announce": "server.operator:announce",
        "relay": "server.serve:relay",
        "rooms": "server.operator:rooms",
        "players": "server.operator:players",
    },
}
"""Subcommands in the order of the help: the module of each, and its name there if not `command`."""

COMMANDS = {name: module for group in GROUPS.values() for name, module in group.items()}

EXIT_NOT_NOW = 1  # a server that could not start now, but may later with the same settings
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130  # 128 + SIGINT, as a shell reports it
EXIT_BROKEN_PIPE = 141  # 128 + SIGPIPE
EXIT_TERMINATED = 143  # 128 + SIGTERM


class _LazyGroup(click.Group):
    """A group that imports only the subcommand it runs, because imports dominate the start."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        module, _, name = COMMANDS[cmd_name].partition(":")
        found = importlib.import_module(f"plinko.app.cli.{module}")
        command: click.Command = getattr(found, name or "command")
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        width = max(map(len, COMMANDS))
        for title, names in GROUPS.items():
            found = ((name, self.get_command(ctx, name)) for name in names)
            rows = [
                (name.ljust(width), command.get_short_help_str(100))
                for name, command in found
                if command
            ]
            with formatter.section(title):
                formatter.write_dl(rows)

    def invoke(self, ctx: click.Context) -> object:
        """Run the subcommand. A closed pipe (`plinko … | head`) ends it without a message."""
        try:
            result: object = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            # At exit Python flushes stdout again and would warn about the closed pipe.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return EXIT_BROKEN_PIPE
        return result


@click.group(
    cls=_LazyGroup,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "show_default": True},
)
@click.version_option(package_name="plinko-sim", message="%(version)s")
@click.pass_context
def plinko(ctx: click.Context) -> None:
    """Plinko with true physics: seeded drops that replay bit for bit.

    BOARD is a preset's name (see `plinko boards`) or the path of a board's JSON file.
    """
    if ctx.invoked_subcommand is None:
        common.echo(ctx.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; an error is one line on stderr.

    Without `arguments` it reads those of the process.
    """
    # At exit Python collects garbage among all remaining objects. With numba loaded this takes a
    # quarter of a second; frozen objects are skipped.
    atexit.register(gc.freeze)
    common.escape_output()
    try:
        result = plinko.main(arguments, prog_name="plinko", standalone_mode=False)
    except click.ClickException as error:
        return _fail(_usage_message(error))
    except (click.Abort, KeyboardInterrupt) as stop:
        from plinko.app.batches.stopping import Terminated

        # click raises Abort from a KeyboardInterrupt.
        ended = isinstance(stop, Terminated) or isinstance(stop.__cause__, Terminated)
        return EXIT_TERMINATED if ended else EXIT_INTERRUPTED
    except OSError as error:
        return _fail(_os_message(error))
    except Exception as error:
        from plinko.app.errors import StartError
        from plinko.engine.errors import PlinkoError

        # Any other error is a bug in Plinko and keeps its traceback.
        if not isinstance(error, PlinkoError):
            raise
        return _fail(str(error), EXIT_NOT_NOW if isinstance(error, StartError) else EXIT_BAD_INPUT)
    return result if isinstance(result, int) else 0


def _fail(message: str, code: int = EXIT_BAD_INPUT) -> int:
    from plinko.app.ops import logs

    if logs.in_json():
        logging.getLogger("plinko").critical(message)
    else:
        common.echo(f"plinko: {' '.join(message.split())}", err=True)
    return code


def _usage_message(error: click.ClickException) -> str:
    message = error.format_message().rstrip(".")
    if isinstance(error, click.UsageError) and error.ctx is not None:
        return f"{message} (see `{error.ctx.command_path} --help`)"
    return message


def _os_message(error: OSError) -> str:
    reason = error.strerror or str(error)
    return f"{error.filename}: {reason}" if error.filename is not None else reason
