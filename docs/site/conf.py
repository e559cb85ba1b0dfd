# SPDX-License-Identifier: Apache-2.0
"""Sphinx settings for the site of the manual. make.py assembles the pages and calls Sphinx."""

import re

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms import SphinxTransform

project = "gyrotherm"
author = "The gyrotherm developers"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
myst_enable_extensions = ["deflist"]
myst_heading_anchors = 4
nitpicky = True
suppress_warnings = ["misc.highlighting_failure"]  # TOML of an excerpt, C of a table
html_theme = "alabaster"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "description": "Temperature-chamber test automation for inertial sensors", "page_width": "72rem",
    "body_max_width": "52rem", "sidebar_width": "16rem", "font_family": "sans-serif", "fixed_sidebar": False,
}  # fmt: skip

_NAMED = re.compile(r"^docs/((?:[\w-]+/)*[\w-]+)\.md$")


class NamedPages(SphinxTransform):
    """Turns paths of pages in code font, such as `docs/files.md`, into links to these pages."""

    default_priority = 210

    def apply(self, **_):
        for literal in list(self.document.findall(nodes.literal)):
            named = _NAMED.match(literal.astext())
            if not named or isinstance(literal.parent, nodes.reference):
                continue
            link = addnodes.pending_xref(
                "", refdoc=self.env.docname, refdomain="std", reftype="doc", reftarget=f"/{named[1]}",
                refexplicit=True, refwarn=True,
            )  # fmt: skip
            literal.replace_self(link)
            link += nodes.literal("", literal.astext())


def setup(app):
    app.add_transform(NamedPages)
    return {"parallel_read_safe": True}
