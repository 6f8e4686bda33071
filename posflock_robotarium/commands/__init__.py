"""One module a family of commands: parse, call the library, print what came back.

These modules import typer and nothing heavy at the top, so that ``posflock --help`` is instant.
"""
