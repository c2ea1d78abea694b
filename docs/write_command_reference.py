# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/command_reference.md: every command with its arguments, options and examples, from the command line itself.

python docs/write_command_reference.py
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from typer.models import ArgumentInfo, OptionInfo

from masonry_cd.cli.app import app

PAGE = Path(__file__).with_name("command_reference.md")
HEAD = """# Commands

Written from the command line by `python docs/write_command_reference.py`. `masonry-cd COMMAND --help` says the same; `python -m masonry_cd`
stands for `masonry-cd` where that is not on the path. `masonry-cd --install-completion` teaches bash, zsh, fish or PowerShell to complete
commands and options with Tab.

Exit codes: 0 done; 1 the run could not go on; 2 bad input, with one line that says what and where; 128 + N stopped by signal N, as
130 by Ctrl-C.

"""
TYPES = {int: "INTEGER", float: "NUMBER", str: "TEXT", Path: "PATH"}


def page() -> str:
    """The text of the page."""
    commands = [each.callback for each in app.registered_commands if each.callback]
    parts = [HEAD, "| command | |\n|---|---|\n"]
    parts += [f"| [`{name(each)}`](#masonry-cd-{name(each)}) | {_summary(each)} |\n" for each in commands]
    return "".join(parts) + "\n" + "\n".join("".join(_section(each)) for each in commands)


def name(command: Callable[..., Any]) -> str:
    """How a command is called."""
    return command.__name__.replace("_", "-")


def _summary(command: Callable[..., Any]) -> str:
    """The first sentence of its help."""
    return inspect.cleandoc(command.__doc__ or "").split("\n\n")[0].replace("\n", " ")


def _section(command: Callable[..., Any]) -> Iterator[str]:
    """Heading, help text, examples, arguments and options of a command."""
    words, *examples = inspect.cleandoc(command.__doc__ or "").split("\b\n")
    yield f"## masonry-cd {name(command)}\n\n{words.strip()}\n\n"
    yield from (f"```sh\n{inspect.cleandoc(chr(10) + example.split(chr(10), 1)[1])}\n```\n\n" for example in examples)
    yield "| argument or option | default | |\n|---|---|---|\n"
    hints = get_type_hints(command, include_extras=True)
    for key, parameter in inspect.signature(command).parameters.items():
        kind, info = _annotation(hints[key])
        if not info.hidden:
            cells = (_names(key, kind, info), _default(parameter), info.help or "")
            yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def _annotation(hint: Any) -> tuple[Any, ArgumentInfo | OptionInfo]:
    """Type and description of a parameter. Of ``list[T] | None`` the type is ``T``."""
    assert get_origin(hint) is Annotated, hint
    kind, info = get_args(hint)[:2]
    while (inner := [each for each in get_args(kind) if each is not type(None)]) and not isinstance(kind, type):
        kind = inner[0]
    return (get_args(kind) or (kind,))[0], info


def _names(key: str, kind: Any, info: ArgumentInfo | OptionInfo) -> str:
    shown = info.metavar or TYPES.get(kind, "")
    if isinstance(info, ArgumentInfo):
        return f"`{shown}`"
    declared = (info.default, *(info.param_decls or ()))  # inside Annotated the first name is kept as if it were a default
    given = [word for word in declared if isinstance(word, str)]
    names = [part for word in given or _by_key(key, kind) for part in word.split("/")]
    shown = "" if kind is bool else shown
    return ", ".join(f"`{each}`" for each in names) + (f" `{shown}`" if shown else "")


def _by_key(key: str, kind: Any) -> list[str]:
    """Names of an option that brings none."""
    word = key.rstrip("_").replace("_", "-")
    return [f"--{word}", f"--no-{word}"] if kind is bool else [f"--{word}"]


def _default(parameter: inspect.Parameter) -> str:
    value = parameter.default
    if value is inspect.Parameter.empty:
        return "*needed*"
    if value in (None, False, ()):
        return ""
    if value is True:
        return "on"
    return f"`{', '.join(map(str, value)) if isinstance(value, list | tuple) else value}`"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
