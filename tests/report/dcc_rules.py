#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks Digital Calibration Certificates against rules of good practice that a schema cannot express.

PTB has such rules as a Schematron; these are written independently from their published description. Each argument is a
file. Prints a line for each broken rule; the exit code is then 1."""
import re
import sys
import xml.etree.ElementTree as ElementTree

DCC, SI, XSD_LIST = "{https://ptb.de/dcc}", "{https://ptb.de/si}", "XMLList"
PLACEHOLDER_DAY = "0001-01-01"
BASIC = {"basic_measuredValue", "basic_nominalValue", "basic_acceptanceLimitUpper", "basic_acceptanceLimitLower",
         "basic_conformity", "basic_metrologicallyTraceableToSI", "basic_methodMeasurementUncertainty",
         "basic_measurementStandard", "basic_measurementTable", "basic_temperature", "basic_temperatureMin",
         "basic_temperatureMax", "basic_humidityRelative", "basic_humidityRelativeMin", "basic_humidityRelativeMax",
         "basic_beforeAdjustment", "basic_afterAdjustment", "basic_revision", "basic_serialNumber"}
PREFIXES = "nano micro milli centi hecto kilo mega giga".split()
UNITS = ("one percent ppm second minute hour day degree arcminute arcsecond radian kelvin degreecelsius volt ampere watt "
         "tesla pascal bar hertz metre gram kilogram").split()
FACTOR = r"(\\(%s))?\\(%s)(\\tothe\{-?\d+(\.\d+)?\})?" % ("|".join(PREFIXES), "|".join(UNITS))
UNIT = re.compile(r"(%s)+(\\per(%s))?" % (FACTOR, FACTOR))


def texts_of(root):
    return [one for one in root.iter() if one.find(DCC + "content") is not None]


def languages(root):
    used = [one.text for one in root.iter(DCC + "usedLangCodeISO639_1")]
    mandatory = [one.text for one in root.iter(DCC + "mandatoryLangCodeISO639_1")]
    if len(set(used)) != len(used) or not set(mandatory) <= set(used):
        yield "languages %s, mandatory %s" % (used, mandatory)
    seen = set()
    for text in texts_of(root):
        contents = text.findall(DCC + "content")
        codes = [one.get("lang") for one in contents]
        seen |= set(codes)
        if any(not (one.text or "").strip() for one in contents):
            yield "a text of %s is empty" % text.tag
        if len(set(codes)) != len(codes):
            yield "a text of %s is twice in one language" % text.tag
        if None not in codes and not set(mandatory) <= set(codes):
            yield "a text of %s is not in %s: %s" % (text.tag, mandatory, [one.text for one in contents])
    if seen - {None} != set(used):
        yield "languages used %s, named %s" % (seen, used)


def references(root):
    ids = [one.get("id") for one in root.iter() if one.get("id")]
    if len(set(ids)) != len(ids):
        yield "an id is there twice"
    for one in root.iter():
        for reference in (one.get("refId") or "").split():
            if reference not in ids:
                yield "nothing has the id %s" % reference


def reference_types(root):
    spaces = {one.text for one in root.iter(DCC + "namespace")}
    for one in root.iter():
        for kind in (one.get("refType") or "").split():
            if kind.split("_")[0] not in spaces:
                yield "refType %s of no vocabulary" % kind
            if kind.startswith("basic_") and kind not in BASIC:
                yield "refType %s is not PTB's" % kind


def days(root):
    core = root.find(".//" + DCC + "coreData")
    begin, end, issue, receipt = (core.findtext(DCC + name) for name in
                                  ("beginPerformanceDate", "endPerformanceDate", "issueDate", "receiptDate"))
    if begin > end:
        yield "ends before it begins"
    if end != PLACEHOLDER_DAY and issue and end > issue:
        yield "issued before its end"
    if end != PLACEHOLDER_DAY and receipt and receipt > begin:
        yield "begun before the item was there"


def countries(root):
    for one in list(root.iter(DCC + "countryCode")) + list(root.iter(DCC + "countryCodeISO3166_1")):
        if not re.fullmatch("[A-Z]{2}", one.text) or (one.text == "ZZ" and not is_draft(root)):
            yield "country %s" % one.text


def is_draft(root):
    return "(draft" in root.findtext(".//" + DCC + "uniqueIdentifier")


def state(root):
    signers = [one for one in root.iter(DCC + "mainSigner") if one.text == "true"]
    if len(signers) != 1:
        yield "%d main signers" % len(signers)
    states = [one for one in root.iter(DCC + "statement") if one.get("refType") == "gyrotherm_state"]
    valid = [one.findtext(DCC + "valid") for one in states]
    if not valid or len(set(valid)) != 1:
        yield "states %s" % valid
    marked = re.search(r"\((draft|simulated)[^)]*\)$", root.findtext(".//" + DCC + "uniqueIdentifier"))
    if marked and "true" in valid:
        yield "valid, and marked as %s" % marked.group(0)
    traceable = [one.text for one in root.iter(DCC + "traceable")]
    if marked and "true" in traceable:
        yield "traceable, and marked as %s" % marked.group(0)


def length(element):
    """Returns the number of items of a list. Only XML blanks separate items."""
    return len([item for item in re.split("[ \t\r\n]+", element.text or "") if item])


def lists(root):
    for one in root.iter(DCC + "list"):
        lengths = set()
        for quantity in one.findall(DCC + "quantity"):
            chars, numbers = quantity.find(DCC + "charsXMLList"), quantity.find(".//" + SI + "valueXMLList")
            if quantity.find(DCC + "noQuantity") is None:
                lengths.add(length(chars) if chars is not None else length(numbers) if numbers is not None else 1)
        if len(lengths) > 1:
            yield "a list with quantities of %s values" % sorted(lengths)
        if one.find(DCC + "quantity") is None:
            yield "a list of nothing"
    for one in root.iter(SI + "realListXMLList"):
        count = length(one.find(SI + "valueXMLList"))
        for part in one.iter():
            if part.tag.endswith(XSD_LIST) and part.text and part.text.strip() and length(part) not in (1, count):
                yield "%s of %d for %d values" % (part.tag, length(part), count)


def numbers_of(root, name):
    for one in root.iter():
        if one.tag in (SI + name, SI + name + XSD_LIST):
            for text in one.text.split():
                yield text


def numbers(root):
    for name in ("value", "valueExpandedMU", "coverageFactor", "coverageProbability"):
        for text in numbers_of(root, name):
            if not re.fullmatch(r"-?\d+(\.\d+)?(e[-+]\d+)?", text):
                yield "%s %s" % (name, text)
    if any(float(text) < 0 for text in numbers_of(root, "valueExpandedMU")):
        yield "a negative uncertainty"
    if any(float(text) < 1 for text in numbers_of(root, "coverageFactor")):
        yield "a coverage factor below 1"
    if any(float(text) != 0.95 for text in numbers_of(root, "coverageProbability")):
        yield "a coverage probability that is not 0.95"


def units(root):
    for text in numbers_of(root, "unit"):
        if not UNIT.fullmatch(text):
            yield "unit %s" % text


def conformity(root):
    for one in root.iter(DCC + "metaData"):
        if one.get("refType") != "basic_conformity":
            continue
        kinds = [quantity.get("refType") for quantity in one.iter(DCC + "quantity")]
        if "basic_acceptanceLimitUpper" not in kinds or one.find(DCC + "declaration") is None:
            yield "a conformity without limit or rule"


def files(root):
    core = root.find(".//" + DCC + "coreData")
    found = {}
    for one in core.iter(DCC + "identification"):
        if one.get("refType") == "gyrotherm_fileSha256":
            found[one.findtext(DCC + "name/" + DCC + "content")] = one.findtext(DCC + "value")
    if not re.fullmatch("[0-9a-f]{64}", found.get("calibration.json", "")):
        yield "calibration.json is not named"


RULES = (languages, references, reference_types, days, countries, state, lists, numbers, units, conformity, files)


def main(paths):
    broken = ["%s: %s: %s" % (path, rule.__name__, what)
              for path in paths for root in [ElementTree.parse(path).getroot()] for rule in RULES for what in rule(root)]
    print("\n".join(broken))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
