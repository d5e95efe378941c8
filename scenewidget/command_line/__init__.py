"""What ``scenewidget`` does in a shell: a module for each command, each a thin skin over the package.

``scenewidget --help`` lists the commands; ``scenewidget tables --help`` explains one.
"""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Words after the program's name; those of the shell by default.

    Returns
    -------
    code : int
        0 if all went well, 1 if the command could not do its work, 2 for words that it does not know, 130
        if it was stopped by Ctrl-C (143 by SIGTERM, for `segment`), 141 if who reads what it prints has gone.

    Examples
    --------
    >>> from scenewidget.command_line import main
    >>> main(["tables", "no/such/folder", "--scenes", "016"])
    1
    """
    from scenewidget import __version__
    from scenewidget.command_line import agree, convert, evaluate, segment, tables
    from scenewidget.command_line.shared import as_flags, say

    parser = argparse.ArgumentParser(
        prog="scenewidget",
        description="Cut indoor 3D scans into meaningful pieces and judge the result.",
        epilog="scenewidget COMMAND --help explains a command, with examples.",
    )
    parser.add_argument("--version", action="version", version=f"scenewidget {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in (segment, evaluate, agree, convert, tables):
        command.add_parser(commands)
    words = sys.argv[1:] if arguments is None else arguments
    if not words:
        parser.print_help(sys.stderr)
        return 2
    options = parser.parse_args(words)

    def warn(message: Warning | str, *_: Any, **__: Any) -> None:
        say(f"scenewidget {options.command}: {as_flags(str(message))}", sys.stderr)

    try:
        with warnings.catch_warnings():
            warnings.showwarning = warn  # what is doubted, without a line of source
            code = int(options.run(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:  # as with "| head"; Python would complain once more at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except (OSError, TypeError, ValueError) as error:  # bad input: what the package says, no traceback
        said = isinstance(error, OSError) and error.filename is None and error.strerror
        say(f"scenewidget {options.command}: {as_flags(said or str(error))}", sys.stderr)
        return 1
    except KeyboardInterrupt:
        say(f"scenewidget {options.command}: stopped", sys.stderr)
        return 130
