"""`multisrt completion`: scripts that complete commands in bash, zsh and fish."""

from __future__ import annotations

import os
from typing import ClassVar

import click
from click.shell_completion import (
    BashComplete,
    CompletionItem,
    FishComplete,
    ShellComplete,
    ZshComplete,
    add_completion_class,
    split_arg_string,
)

PROGRAM, VARIABLE = "multisrt", "_MULTISRT_COMPLETE"

_BASH = r"""
%(complete_func)s() {
    local IFS=$'\n' completion kind value
    COMPREPLY=()
    for completion in $(env COMP_WORDS="${COMP_LINE:0:COMP_POINT}" \
            COMP_WORDBREAKS="$COMP_WORDBREAKS" %(complete_var)s=bash_complete "$1"); do
        kind=${completion%%%%,*}
        value=${completion#*,}
        case $kind in
            dir) compopt -o dirnames ;;
            file) compopt -o default ;;
            plain)
                COMPREPLY+=("$value")
                [[ $value == *[=:/] ]] && compopt -o nospace
                ;;
        esac
    done
    return 0
}
complete -o nosort -F %(complete_func)s %(prog_name)s
"""

_ZSH = r"""
%(complete_func)s() {
    local -a response words_done words_open
    local kind value description
    response=("${(@f)$(env COMP_WORDS="${words[1,CURRENT]}" COMP_CWORD=$((CURRENT-1)) \
        %(complete_var)s=zsh_complete $words[1])}")
    for kind value description in ${response}; do
        [[ $description == _ ]] && description=
        case $kind in
            dir) _path_files -/ ;;
            file) _path_files -f ;;
            plain)
                if [[ $value == *[=:/] ]]; then
                    words_open+=("${value//:/\\:}:$description")
                else
                    words_done+=("${value//:/\\:}:$description")
                fi
                ;;
        esac
    done
    (( $#words_done )) && _describe -V completions words_done -U
    (( $#words_open )) && _describe -V completions words_open -U -S ''
    return 0
}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then
    %(complete_func)s "$@"
else
    compdef %(complete_func)s %(prog_name)s
fi
"""

WHERE = {
    "bash": """\
# Completion of multisrt for bash, version 4.4 or later. With the package bash-completion:
#   mkdir -p ~/.local/share/bash-completion/completions
#   multisrt completion bash > ~/.local/share/bash-completion/completions/multisrt
# Without it, add this line to ~/.bashrc:
#   eval "$(multisrt completion bash)"
""",
    "zsh": """\
#compdef multisrt
# Completion of multisrt for zsh:
#   mkdir -p ~/.zfunc
#   multisrt completion zsh > ~/.zfunc/_multisrt
# and in ~/.zshrc, if these lines are not there yet:
#   fpath+=~/.zfunc
#   autoload -Uz compinit && compinit
""",
    "fish": """\
# Completion of multisrt for fish:
#   multisrt completion fish > ~/.config/fish/completions/multisrt.fish
""",
}
"""The head of the script for each shell: where it belongs."""


class _Joined(ShellComplete):
    """Completes ``--option=VALUE`` like ``--option VALUE``."""

    def get_completions(self, args: list[str], incomplete: str) -> list[CompletionItem]:
        option, equals, _ = incomplete.partition("=")
        found = super().get_completions(args, incomplete)
        if equals and option.startswith("--"):
            for item in found:
                item.value = f"{option}={item.value}"
        return found


class Bash(_Joined, BashComplete):
    """Completion in bash, which takes ``KEY=VALUE`` and ``KIND:ROBOT`` as several words."""

    source_template: ClassVar[str] = _BASH

    def get_completion_args(self) -> tuple[list[str], str]:
        """Return the words before the cursor, and what is there of the last one."""
        line = os.environ["COMP_WORDS"]
        words = split_arg_string(line)[1:]
        return (words, "") if line[-1:].isspace() else (words[:-1], words[-1] if words else "")

    def get_completions(self, args: list[str], incomplete: str) -> list[CompletionItem]:
        """Return the completions, without what stands before the word that bash replaces."""
        breaks = os.environ.get("COMP_WORDBREAKS", "=:")
        kept = max((incomplete.rfind(one) + 1 for one in "=:" if one in breaks), default=0)
        found = super().get_completions(args, incomplete)
        for item in found:
            if item.type == "plain":
                item.value = item.value[kept:]
        return found


class Zsh(_Joined, ZshComplete):
    """Completion in zsh."""

    source_template: ClassVar[str] = _ZSH

    def format_completion(self, item: CompletionItem) -> str:
        """Return kind, value and description of a completion, in one line each."""
        return f"{item.type}\n{item.value}\n{item.help or '_'}"


class Fish(_Joined, FishComplete):
    """Completion in fish."""


SHELLS: dict[str, type[ShellComplete]] = {"bash": Bash, "zsh": Zsh, "fish": Fish}

for shell_name, shell_class in SHELLS.items():
    add_completion_class(shell_class, shell_name)


@click.command()
@click.argument("shell", metavar="SHELL", type=click.Choice(list(SHELLS)))
@click.pass_context
def completion(context: click.Context, shell: str) -> None:
    """Print a script that completes commands in a shell.

    SHELL is bash, zsh or fish. The tab key then completes commands, options, worlds and their
    parameters, strategies and their options, and files. The first lines of the script
    describe where to put it.

    \b
    Examples:
      eval "$(multisrt completion bash)"     # this shell only
      multisrt completion zsh > ~/.zfunc/_multisrt
      multisrt completion fish > ~/.config/fish/completions/multisrt.fish
    """
    root = context.find_root().command
    script = SHELLS[shell](root, {}, PROGRAM, VARIABLE)
    click.echo(WHERE[shell] + (script.source_template % script.source_vars()).lstrip("\n"))
