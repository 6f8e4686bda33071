"""Build the site into ``build/docs/html``, and check it: ``python -m tools.documentation``."""

from __future__ import annotations

import argparse
import shutil
import sys

from sphinx.cmd.build import main as sphinx

from tools.documentation.accessible_pages import make_accessible
from tools.documentation.built_pages import faults_of
from tools.documentation.public_names import public_surface
from tools.documentation.staging import ROOT, stage

BUILD = ROOT / "build" / "docs"


def main() -> int:
    """Build, check, and say where the site is; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tools.documentation", description=__doc__)
    parser.add_argument("--external", action="store_true", help="ask every address on the network")
    asked = parser.parse_args()
    source, site = BUILD / "source", BUILD / "html"
    stage(source)
    shutil.rmtree(site, ignore_errors=True)  # no page of an earlier build
    builder, out = ("linkcheck", BUILD / "links") if asked.external else ("html", site)
    strict = [
        "-b",
        builder,
        "-c",
        str(ROOT / "docs"),
        "-W",
        "--keep-going",
        "-n",
        "-q",
        "-E",
        "-j",
        "auto",
    ]
    code = sphinx([*strict, "-d", str(BUILD / "doctrees"), str(source), str(out)])
    if code or asked.external:
        return code
    make_accessible(site)
    faults = faults_of(site, public_surface())
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"{site / 'index.html'}: {sum(1 for _ in site.rglob('*.html'))} pages")
    return 1 if faults else 0


sys.exit(main())
