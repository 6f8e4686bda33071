"""What a command starts ends with it, and what a script may reach is bounded and said.

Two questions, each answered once for all commands:

**Who cleans up?** A command that is killed cannot. So beside it runs a *keeper*, a bare Python of a
few megabytes that waits for its end: it ends every process that was started, whatever session that
has moved to, and removes the temporary folder (:mod:`~.kept`, :mod:`~.keeper`). A folder that even
its keeper could not remove is locked by nobody, and the next start removes it
(:mod:`~.stale_folders`).

**What can a script reach?** Where the kernel lets users make namespaces, a script has no network, a
``/tmp`` and a ``/dev`` of its own, sees no other process, and can write in its own folder alone
(:mod:`~.namespaces`). Elsewhere an audit hook (`rps_compat.running.policy`) stops what Python does,
and nothing stops native code. Either way, disk, output, memory and processes are limited from
outside (:mod:`~.usage`).

Everything here needs the standard library alone: a keeper starts in some ten milliseconds.
"""
