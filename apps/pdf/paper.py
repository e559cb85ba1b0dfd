#!/usr/bin/python3 -I
# SPDX-License-Identifier: Apache-2.0
"""Makes a PDF/A-1b of a calibration report's HTML with WeasyPrint, or a PNG of a figure with rsvg-convert.

    paper.py pdf PAGE.html OUT.pdf [--signature-field]
    paper.py png FIGURE.svg OUT.png WIDTH

gyrotherm-pdf runs it. Each omission is reported as a line with "omitted" on stdout. A failure is one line, with exit code 1.
With the same fonts and the same WeasyPrint version, the same input gives the same bytes."""

from __future__ import annotations

import base64
import binascii
import hashlib
import io
import logging
import os
import re
import subprocess
import sys
import unicodedata
from html import escape, unescape
from pathlib import Path
from typing import Any
from xml.parsers import expat

FAMILY = "DejaVu Sans"
SVG = "http://www.w3.org/2000/svg"
PACKAGES = {"rsvg-convert": "librsvg2-bin", "fc-match": "fontconfig", "fc-list": "fontconfig"}


class PaperError(Exception):
    """The output file cannot be made. The text is one sentence for the user."""


class LogoError(Exception):
    """The logo is refused and will be omitted from the report. The text is the reason."""


def run(command: list[str], given: bytes = b"") -> bytes:
    """Runs a program and returns its standard output. `given` is its standard input."""
    try:
        done = subprocess.run(command, input=given, capture_output=True, timeout=50, check=True)
    except FileNotFoundError as error:
        raise PaperError(f"{command[0]} is not installed (Debian: {PACKAGES[command[0]]})") from error
    except subprocess.TimeoutExpired as error:
        raise PaperError(f"{command[0]} did not exit within 50 s") from error
    except subprocess.CalledProcessError as error:
        raise PaperError(f"{command[0]}: {error.stderr.decode(errors='replace').strip()}") from error
    return done.stdout


# Figures


def blend_with_white(colour: str, opacity: float) -> str:
    """Returns the opaque colour that equals "#rrggbb" with this opacity on white paper."""
    parts = [int(colour[at : at + 2], 16) for at in (1, 3, 5)]
    return "#" + "".join(f"{round(255 - opacity * (255 - part)):02x}" for part in parts)


def condense_text(text: re.Match[str]) -> str:
    """Returns the start of a text element with letters condensed to 0.88 of their width. Keeps the rotation.

    Figures are laid out for a narrower font than DejaVu Sans."""
    x, y, attributes = text.groups()
    turned = re.search(r' transform="rotate\((-?[0-9.]+)[^"]*"', attributes)
    turn = f" rotate({turned[1]})" if turned else ""
    attributes = attributes.replace(turned[0], "") if turned else attributes
    return f'<text x="0" y="0" transform="translate({x} {y}){turn} scale(0.88 1)"{attributes}>'


def prepare_for_print(markup: str) -> str:
    """Returns markup with the figures of report/plot prepared for a page: opaque colours, one condensed font."""
    markup = re.sub(r'fill="(#[0-9a-f]{6})"([^<>]*?) fill-opacity="([0-9.]+)"',
                    lambda found: f'fill="{blend_with_white(found[1], float(found[3]))}"{found[2]}', markup)
    markup = re.sub(r'font-family="[^"]*"', f'font-family="{FAMILY}"', markup)
    return re.sub(r'<text x="([^"]*)" y="([^"]*)"([^<>]*)>', condense_text, markup)


def keep_words_whole(markup: str) -> str:
    """Replaces word joiners (U+2060) by spans that do not break: WeasyPrint would store them in the text of the PDF for
    the letter behind them, so that words could not be found or copied."""
    joined = re.compile("[^\\s<>\u2060]*\u2060[^\\s<>]*")

    def keep(token: re.Match[str]) -> str:
        return f'<span style="white-space: nowrap">{token[0]}</span>'

    parts = re.split(r"(<title>.*?</title>|<svg.*?</svg>|<style.*?</style>|<[^>]*>)", markup, flags=re.DOTALL)
    parts[::2] = [joined.sub(keep, text) for text in parts[::2]]
    return "".join(parts).replace("\u2060", "")


def svg_size(svg: str) -> tuple[float, float]:
    """Returns width and height of an SVG in its own pixels."""
    roots: list[tuple[str, dict[str, str]]] = []
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler = lambda name, attributes: roots.append((name, attributes))
    try:
        parser.Parse(svg.encode(), True)
    except expat.ExpatError as error:
        raise PaperError(f"figure: not a valid SVG: {error}") from error
    name, attributes = roots[0]
    box = re.split(r"[ ,]+", attributes.get("viewBox", "").strip())
    size = box[2:] if len(box) == 4 else [attributes.get("width", ""), attributes.get("height", "")]
    try:
        width, height = (float(part) for part in size)
    except ValueError:
        width = height = 0.0
    if name != f"{SVG} svg" and name != "svg" or not (0 < width < 1e9 and 0 < height < 1e9):
        raise PaperError("figure: expected an svg element with a size")
    return width, height


def figure_to_png(svg: str, width_px: int) -> bytes:
    """Returns a figure as a PNG; its aspect ratio determines the height."""
    width, height = svg_size(svg)
    height_px = round(width_px * height / width)
    if height_px < 1 or height_px * width_px > 100_000_000:
        raise PaperError("figure: the PNG would have no pixels or more than 100 million")
    return render_svg(prepare_for_print(svg).encode(), width_px, height_px)


def render_svg(svg: bytes, width_px: int, height_px: int, *, keep_aspect_ratio: bool = False) -> bytes:
    """Returns an SVG as a PNG on white. With `keep_aspect_ratio`, the given size is a maximum."""
    size = ["--width", str(width_px), "--height", str(height_px)]
    if keep_aspect_ratio:
        size.append("--keep-aspect-ratio")
    return run(["rsvg-convert", *size, "--background-color", "white"], svg)


# The laboratory's logo is untrusted input.

PERMITTED_ELEMENTS = frozenset("svg g defs title desc metadata rect circle ellipse line polyline polygon path text "
                               "tspan style linearGradient radialGradient stop switch".split())
LOGO_PX = (1240, 472)  # 52.5 mm × 20 mm at 600 dpi


def is_harmless(value: str) -> bool:
    """Returns True if a value or style sheet has no external reference and is quick to draw.

    A backslash is refused because it could hide any keyword."""
    tight = value.replace(" ", "").lower().replace("dasharray:none", "")
    if any(word in tight for word in ("\\", "@import", "dasharray")):
        return False
    return tight.count("url(") == sum(tight.count(start) for start in ("url(#", "url('#", 'url("#'))


class LogoCheck:
    """Refuses an SVG with external references, or with elements that make a small file expensive to draw."""

    def __init__(self) -> None:
        self.elements = 0
        self.text: list[str] = []

    def refuse_entity(self, *_: object) -> None:
        raise LogoError("declares entities")

    def refuse_instruction(self, *_: object) -> None:
        raise LogoError("contains a processing instruction")

    def add_text(self, text: str) -> None:
        self.text.append(text)

    def end(self, _: str = "") -> None:
        """Checks the complete text of an element."""
        if not is_harmless("".join(self.text)):
            raise LogoError("contains a style that is not permitted in a logo")
        self.text = []

    def start(self, name: str, attributes: dict[str, str]) -> None:
        self.end()
        self.elements += 1
        space, _, element = name.rpartition(" ")
        if self.elements == 1 and element != "svg":
            raise LogoError("is not an SVG")
        if self.elements > 5000:
            raise LogoError("has more than 5000 elements")
        if space != SVG:  # private data of drawing programs
            return
        if element not in PERMITTED_ELEMENTS:
            raise LogoError(f"contains <{element}>, which is not permitted in a logo")
        for long_name, value in attributes.items():
            attribute = long_name.rpartition(" ")[2]
            if attribute == "href" and not value.startswith("#"):
                raise LogoError("contains an external reference")
            if attribute == "stroke-dasharray" and value != "none" or not is_harmless(value):
                raise LogoError(f'contains a value of "{attribute}" that is not permitted in a logo')


def logo_to_png(content: bytes) -> bytes:
    """Checks an SVG and returns it as a PNG on white."""
    check = LogoCheck()
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler, parser.EndElementHandler = check.start, check.end
    parser.EntityDeclHandler, parser.ProcessingInstructionHandler = check.refuse_entity, check.refuse_instruction
    parser.CharacterDataHandler = check.add_text
    try:
        parser.Parse(content, True)
        return render_svg(content, *LOGO_PX, keep_aspect_ratio=True)
    except expat.ExpatError as error:
        raise LogoError(f"is not a valid SVG: {error}") from error
    except PaperError as error:
        raise LogoError(f"cannot be drawn: {error}") from error


def flatten_png(content: bytes) -> bytes:
    """Returns a PNG without transparency. Refuses a PNG larger than 4000 pixels in either direction."""
    from PIL import Image, ImageFile

    ImageFile.LOAD_TRUNCATED_IMAGES = False  # WeasyPrint sets it to True
    if not content.startswith(b"\x89PNG\r\n\x1a\n"):
        raise LogoError("is not a PNG")
    try:
        with Image.open(io.BytesIO(content), formats=["PNG"]) as opened:
            if max(opened.size) > 4000:
                raise LogoError("is wider or higher than 4000 pixels")
            if opened.mode.startswith("I"):  # 16-bit grey, which convert() would clip
                opened = opened.convert("I").point(lambda value: value / 256).convert("L")
            picture = opened.convert("RGBA")
    except Image.DecompressionBombError as error:
        raise LogoError("is wider or higher than 4000 pixels") from error
    except (OSError, ValueError, SyntaxError) as error:
        raise LogoError(f"is not a valid PNG: {error}") from error
    flat = Image.new("RGB", picture.size, "white")
    flat.paste(picture, mask=picture)
    bytes_out = io.BytesIO()
    flat.save(bytes_out, "PNG")
    return bytes_out.getvalue()


def fetch(url: str, remarks: list[str]) -> dict[str, Any]:
    """Returns the picture in a data URL as an opaque PNG. Refuses all other URLs: no network, no files."""
    header, _, coded = url.partition(",")
    try:
        if not header.startswith("data:image/"):
            raise LogoError("is not embedded in the report")
        try:
            content = base64.b64decode(coded, validate=True)
        except binascii.Error as error:
            raise LogoError("is not valid base64") from error
        if len(content) > 2_000_000:
            raise LogoError("is larger than 2 MB")
        picture = logo_to_png(content) if header.startswith("data:image/svg+xml") else flatten_png(content)
    except LogoError as error:
        remarks.append(f"laboratory.logo: {error}; the logo is omitted")
        raise ValueError(str(error)) from error
    return {"string": picture, "mime_type": "image/png"}


# Fonts


def is_visible(letter: str) -> bool:
    """Returns whether a character needs a glyph: not a blank, a control character or a variation selector. Private and
    unassigned characters need one."""
    is_selector = 0xFE00 <= ord(letter) <= 0xFE0F or 0xE0100 <= ord(letter) <= 0xE01EF
    return unicodedata.category(letter) not in {"Cc", "Cf", "Zl", "Zp", "Zs"} and not is_selector


def check_fonts(text: str) -> list[str]:
    """Fails if the font is not installed. Returns a remark on characters that no installed font has."""
    family, _, charset = run(["fc-match", "-f", "%{family[0]}|%{charset}", FAMILY]).decode().partition("|")
    if family != FAMILY:
        raise PaperError(f"{FAMILY}: font not installed (Debian: fonts-dejavu-core)")
    ranges = [[int(end, 16) for end in part.split("-")] for part in charset.split()]
    uncovered = [letter for letter in sorted(set(text)) if is_visible(letter)
               and not any(part[0] <= ord(letter) <= part[-1] for part in ranges)]
    missing = [f"U+{ord(one):04X}" for one in uncovered if not run(["fc-list", f":charset={ord(one):x}", "family"])]
    if not missing:
        return []
    return [f"no installed font has {', '.join(missing)}; they are omitted; install fonts-noto-cjk for Chinese, "
            "Japanese and Korean, fonts-noto-core for other scripts"]


# The PDF


def add_signature_field(pdf: Any, pydyf: Any) -> None:
    """Adds an invisible empty signature field to the last page.

    A later signature then adds no other object. Without the field, signing adds one, and pdfsig also adds a font.
    """
    page = pdf.objects[pdf.pages["Kids"][-3]]
    look = pydyf.Stream([], {"Type": "/XObject", "Subtype": "/Form", "BBox": pydyf.Array([0, 0, 0, 0])})
    pdf.add_object(look)
    field = pydyf.Dictionary({
        "Type": "/Annot", "Subtype": "/Widget", "FT": "/Sig", "T": pydyf.String("Signature"), "F": 132,
        "Rect": pydyf.Array([0, 0, 0, 0]), "P": page.reference, "AP": pydyf.Dictionary({"N": look.reference}),
    })  # fmt: skip
    pdf.add_object(field)
    page["Annots"] = pydyf.Array([*page.get("Annots", []), field.reference])
    pdf.catalog["AcroForm"] = pydyf.Dictionary({"Fields": pydyf.Array([field.reference]), "SigFlags": 1})


def add_glyph_sets(pdf: Any, pydyf: Any) -> None:
    """Adds to each font the list of its glyphs, required by PDF/A-1 (ISO 19005-1, 6.3.5).

    WeasyPrint 57.2 writes the list for PDF 1.4 only, and fails if the number of the last glyph is a multiple of 8."""
    for font in [one for one in pdf.objects if isinstance(one, dict) and "DescendantFonts" in one]:
        inner = pdf.objects[int(font["DescendantFonts"][0].split()[0])]
        glyphs = [first + k for first, widths in zip(inner["W"][::2], inner["W"][1::2]) for k in range(len(widths))]
        bits = bytearray(max(glyphs) // 8 + 1)
        for glyph in glyphs:
            bits[glyph // 8] |= 0x80 >> glyph % 8
        glyph_set = pydyf.Stream([bytes(bits)])
        pdf.add_object(glyph_set)
        descriptor = pdf.objects[int(inner["FontDescriptor"].split()[0])]
        descriptor["CIDSet"] = glyph_set.reference
        if "FontFile3" in descriptor:
            strip_opentype(pdf.objects[int(descriptor["FontFile3"].split()[0])])
            descriptor.pop("Subtype", None)


def strip_opentype(program: Any) -> None:
    """Reduces an OpenType font to its outlines, because PDF 1.4 does not support OpenType."""
    from fontTools.ttLib import TTFont

    (content,) = program.stream
    if content.startswith(b"OTTO"):
        program.stream = [TTFont(io.BytesIO(content)).reader["CFF "]]
        program.extra["Subtype"] = "/CIDFontType0C"


XMP = """<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>
<x:xmpmeta xmlns:x="adobe:ns:meta/">
<rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
<rdf:Description rdf:about="" xmlns:dc="http://purl.org/dc/elements/1.1/" xmlns:pdf="http://ns.adobe.com/pdf/1.3/"
 xmlns:xmp="http://ns.adobe.com/xap/1.0/" xmlns:pdfaid="http://www.aiim.org/pdfa/ns/id/">
<dc:format>application/pdf</dc:format>
<dc:title><rdf:Alt><rdf:li xml:lang="x-default">{title}</rdf:li></rdf:Alt></dc:title>
<dc:creator><rdf:Seq><rdf:li>{author}</rdf:li></rdf:Seq></dc:creator>
<dc:language><rdf:Bag><rdf:li>{language}</rdf:li></rdf:Bag></dc:language>
<pdf:Keywords>{keywords}</pdf:Keywords>
<pdf:Producer>WeasyPrint {version}</pdf:Producer>
<xmp:CreatorTool>{program}</xmp:CreatorTool>
{dates}<pdfaid:part>1</pdfaid:part>
<pdfaid:conformance>B</pdfaid:conformance>
</rdf:Description>
</rdf:RDF>
</x:xmpmeta>
<?xpacket end="r"?>"""


def make_xmp(facts: Any, version: str) -> bytes:
    """Returns the metadata of a document as XMP.

    Replaces the packet of WeasyPrint 57.2, in which PDFBox's preflight does not find the PDF/A part."""
    dates = "".join(f"<xmp:{name}>{escape(day)}</xmp:{name}>\n"
                    for name, day in (("CreateDate", facts.created), ("ModifyDate", facts.modified)) if day)
    return XMP.format(title=escape(facts.title or ""), author=escape(", ".join(facts.authors)),
                      language=escape(facts.lang or ""), keywords=escape(", ".join(facts.keywords)), version=version,
                      program=escape(facts.generator or ""), dates=dates).encode()


def html_to_pdf(html: str, *, has_signature_field: bool, remarks: list[str]) -> bytes:
    """Returns the PDF/A-1b of a report's HTML."""
    os.environ["SOURCE_DATE_EPOCH"] = "0"  # date inside fonts; the PDF date is in the HTML
    try:
        import pydyf
        import weasyprint
        from weasyprint.pdf.pdfa import pdfa
    except ImportError as error:
        raise PaperError(f"cannot load WeasyPrint ({error}); install the Debian package weasyprint") from error
    logging.getLogger("weasyprint").disabled = True

    def finish(document: Any, pdf: Any) -> None:
        pdfa(pdf, document.metadata, document, [], 1)
        metadata = pdf.objects[int(pdf.catalog["Metadata"].split()[0])]
        metadata.stream = [make_xmp(document.metadata, weasyprint.__version__)]
        add_glyph_sets(pdf, pydyf)
        pdf.version = b"1.4"
        pdf.catalog["PageMode"] = "/UseOutlines"
        pdf.catalog["ViewerPreferences"] = pydyf.Dictionary({"DisplayDocTitle": "true"})
        if has_signature_field:
            add_signature_field(pdf, pydyf)

    remarks += check_fonts(unescape(re.sub(r"<(style|script)\b.*?</\1>|<[^>]*>", "", html, flags=re.DOTALL)))
    printed = prepare_for_print(keep_words_whole(html))
    page = weasyprint.HTML(string=printed, url_fetcher=lambda url, **_: fetch(url, remarks))
    sheet = weasyprint.CSS(string=Path(__file__).with_name("paper.css").read_text())
    digest = hashlib.sha256(html.encode()).hexdigest()[:32]
    return page.write_pdf(stylesheets=[sheet], finisher=finish, identifier=digest.encode())


def main(arguments: list[str]) -> int:
    """Runs the command line described above."""
    remarks: list[str] = []
    try:
        given, out = Path(arguments[1]).read_text(encoding="utf-8"), Path(arguments[2])
        if arguments[0] == "png":
            out.write_bytes(figure_to_png(given, int(arguments[3])))
        else:
            out.write_bytes(html_to_pdf(given, has_signature_field="--signature-field" in arguments, remarks=remarks))
    except (PaperError, OSError, UnicodeDecodeError) as error:
        print(error)
        return 1
    for remark in dict.fromkeys(remarks):
        print(remark)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
