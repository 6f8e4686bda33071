"""Options after the script's name: whose they are.

``posflock run SCRIPT -o run`` is what everybody writes first. What follows a script is the
script's own, as with ``python SCRIPT``, since it may have an option of the same name. Most
Robotarium scripts read no arguments at all, for the testbed gives none: for those, options after
the name can only be meant for posflock, and are taken so. Of a script that does read arguments and
refuses them, the message says where posflock's options go.
"""

import re
from pathlib import Path
from typing import Any

from posflock_robotarium.commands.help_pages import CommandPage

#: By what a file shows that it may read arguments.
_READS_ARGUMENTS = re.compile(
    r"\b(argv|orig_argv|argparse|optparse|getopt|click|typer|fire|docopt|absl|tyro|hydra|"
    r"jsonargparse|simple_parsing|plac|cleo|cyclopts)\b"
)


class RunPage(CommandPage):
    """A command whose last argument is a script, followed by the script's own arguments."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments; options of this command may stand after a script that takes none.

        Parameters
        ----------
        ctx : click.Context
            Of the call.
        args : list of str
            What follows the command's name.
        """
        words = list(args)
        left: list[str] = super().parse_args(ctx, list(words))
        own = list(ctx.args)
        if not (own and own[0] in self._names(ctx)):
            return left
        head, script = words[: len(words) - len(own) - 1], words[len(words) - len(own) - 1]
        if may_read_arguments(Path(script)):
            return left
        moved = [*head, *own, script]
        with self.make_context(ctx.info_name, list(moved), parent=ctx.parent) as tried:
            if tried.args or str(tried.params.get("script")) != script:
                return left
        ctx.args, ctx.params = [], {}
        return super().parse_args(ctx, moved)

    def _names(self, ctx: Any) -> set[str]:
        return {name for p in self.get_params(ctx) for name in (*p.opts, *p.secondary_opts)}


def may_read_arguments(script: Path) -> bool:
    """Whether a script, or a file beside it that it imports, may read its arguments.

    Parameters
    ----------
    script : Path
        Its main file; of one that cannot be read it is not known, and so it may.
    """
    from posflock_robotarium.flocking.errors import PosflockError
    from rps_compat.scripts.import_graph import is_ours, trace

    try:
        found = trace(script)
        beside = [local.path for local in found.locals if not is_ours(local.name)]
        texts = [path.read_bytes().decode("utf-8", "replace") for path in (script, *beside)]
    except (OSError, PosflockError):
        return True
    unknown = {missing.statement.top for missing in found.missing}
    return any(_READS_ARGUMENTS.search(text) for text in (*texts, *unknown))
