#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks docs/reference/keys.md and docs/reference/schemas.

Each key of a shipped file, or of a file in the documents, is on the page, and each key has a meaning. The written files
are up to date. The schemas are valid, accept the shipped files and refuse wrong ones."""

import copy
import json
import re
import sys
import tomllib
import unittest
from pathlib import Path

try:
    import jsonschema
except ImportError:
    jsonschema = None  # python3-jsonschema; only the tests of the schemas need it

sys.dont_write_bytecode = True
SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "docs/site"))
sys.path.insert(0, str(Path(__file__).parent))
import key_schemas  # noqa: E402
import keys  # noqa: E402
from markdown import DOCS, read_blocks  # noqa: E402

DOCUMENTED_ELSEWHERE = re.compile(r"^(gyro\.frame|metadata|accept|policy|limits\.channel)")  # described on other pages
SCHEMAS = SOURCE / "docs/reference/schemas"
OPENER = re.compile(r"^(of|by|with|without|from|to|as|that|what|which|who|how|why|whether)\b", re.I)


def bare(table: str) -> str:
    return table.split(" ")[0].strip("[]")


def shipped(pattern: str) -> list[Path]:
    return sorted((SOURCE / "profiles").glob(pattern))


def read(path: Path) -> dict:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def files_in_documents(kind: str) -> list[tuple[str, dict]]:
    """Returns the position and the content of each file of a kind in the documents."""
    found = []
    for block in (block for page in sorted(DOCS.rglob("*.md")) for block in read_blocks(page)):
        if block.language == "toml" and f'schema = "gyrotherm-{kind}/1"' in block.lines:
            found.append((block.position, tomllib.loads("\n".join(block.lines))))
    return found


class Keys(unittest.TestCase):
    def check(self, sources, pattern):
        known = {(bare(key.table), key.name) for key in keys.read_keys(sources)}
        files = shipped(pattern)
        self.assertTrue(files)
        for path in files:
            for table, key in keys.written_keys(read(path)):
                if not DOCUMENTED_ELSEWHERE.match(table) and key != "frame":
                    self.assertTrue((table, key) in known, f"{path.name}: [{table}] {key}")
        return known

    def test_profiles(self):
        self.assertGreater(len(self.check(keys.PROFILE, "*.toml")), 25)

    def test_rigs(self):
        self.assertGreater(len(self.check(keys.RIG | keys.VIRTUAL, "rigs/*.toml")), 200)

    def test_files_in_the_documents(self):
        for kind, sources in (("laboratory", keys.LABORATORY), ("order", keys.ORDER), ("site", keys.SITE)):
            known = {(bare(key.table), key.name) for key in keys.read_keys(sources)}
            files = files_in_documents(kind)
            for position, content in files:
                for table, key in keys.written_keys(content):
                    if not re.search(r"^(en|de)$", key) or table == "statement":
                        self.assertIn((table, key), known, position)
            self.assertGreater(len(files), 1, kind)

    def test_defaults_and_required_keys_are_those_of_the_sources(self):
        absent = {
            (bare(key.table), key.name): "required" if key.required else key.default
            for sources in (keys.PROFILE, keys.RIG, keys.VIRTUAL, keys.SITE)
            for key in keys.read_keys(sources)
        }
        for position, expected in (
            (("virtual.thermometers", "noise_k"), "required"),  # the last argument is a lower bound
            (("virtual.thermometers", "gain"), "0"),
            (("virtual.thermal.side_wind", "steady"), "required"),
            (("virtual.thermal.power_growth", "gain_per_k"), "0"),
            (("virtual.bias", "mirror_deg_per_h_per_k"), "required"),  # the last arguments are count and lower bound
            (("virtual.bias.growth", "gas_flow"), "required"),  # another table has a key of this name
            (("virtual.gyro.dead_band", "sags_below"), "required"),  # has() follows the reading
            (("analogue_input.channel", "input"), "required"),
            (("gyro", "latitude"), ""),
            (("limits.channel.NAME", "lowest"), ""),
            (("segment", "count"), ""),
            (("safe", "on_stop"), '"safe"'),
            (("virtual", "plant"), "required"),
            (("limits", "channel"), ""),
            (("notify.rule", "free_gb"), "5"),
            (("limits", "suspend_after"), '"5 s"'),  # the initialiser of a member
            (("limits", "thermometers_highest"), '"100 °C"'),
            (("thermometer.sensor", "a_per_k"), "3.9083e-3"),
            (("virtual.gyro", "instability_to_s"), "1e6"),
            (("segment", "least_step"), '"1 K"'),
        ):
            self.assertEqual(absent[position], expected, position)

    def test_a_function_on_one_line_is_found(self):
        self.assertNotIn(("[virtual.value]", "unit"), {(k.table, k.name) for k in keys.read_keys(keys.VIRTUAL)})

    def test_the_page_is_up_to_date(self):
        written = (SOURCE / "docs/reference/keys.md").read_text(encoding="utf-8")
        self.assertTrue(written == keys.page(), "run docs/site/keys.py")

    def test_each_key_is_documented(self):
        texts = [p.read_text(encoding="utf-8") for p in (SOURCE / "docs").glob("*.md")]
        texts += [p.read_text(encoding="utf-8") for p in (SOURCE / "profiles").rglob("*.toml")]
        texts.append((SOURCE / "sequencer/rig/thermometer_settings.cpp").read_text(encoding="utf-8"))
        whole = "\n".join(texts)
        seen = 0
        for sources in (keys.PROFILE, keys.RIG, keys.VIRTUAL, keys.LABORATORY, keys.ORDER, keys.SITE):
            for key in keys.read_keys(sources):
                in_prose, in_a_file = (
                    rf"`\[*([\w.]+\.)?{key.name}\b",
                    rf"^\s*(# )?{key.name} += |^\[+([\w.]+\.)?{key.name}\]",
                )
                found = re.search(f"{in_prose}|{in_a_file}", whole, re.M)
                self.assertTrue(found, f"{key.position}: {key.name} is not in the documents")
                seen += 1
        self.assertGreater(seen, 300)


class Meanings(unittest.TestCase):
    def test_each_key_has_a_meaning(self):
        seen = 0
        page = (SOURCE / "docs/reference/keys.md").read_text(encoding="utf-8")
        for name in keys.FILES:
            for key in keys.described_keys(name):
                self.assertTrue(f"| `{key.name}` | {key.meaning.text} |" in page, key.position)
                self.assertIsNone(OPENER.match(key.meaning.text), f"{key.name}: {key.meaning.text}")
                seen += 1
        self.assertGreater(seen, 525)

    def test_a_key_without_a_meaning_is_named(self):
        keys_removed = (("profile", "[segment] ramp", "to"), ("rig", "chamber.link", "echo"), ("site", "", "rig"))
        for name, table, key in keys_removed:
            tables = keys.read_meanings(name)
            del tables[table][key]
            faults = keys.find_faults(name, keys.read_keys(keys.FILES[name].sources), tables)
            self.assertTrue(any(f"[{table or 'file'}] {key} has no meaning" in fault for fault in faults), faults)

    def test_a_meaning_without_a_key_is_named(self):
        tables = keys.read_meanings("rig")
        tables["chamber"]["colour"] = {"is": "Colour of the chamber"}
        faults = keys.find_faults("rig", keys.read_keys(keys.RIG), tables)
        self.assertEqual(len(faults), 1, faults)
        self.assertIn("[chamber] colour has a meaning, but no source reads it", faults[0])

    def test_an_optional_key_without_a_default_is_named(self):
        tables = keys.read_meanings("rig")
        del tables["chamber"]["power"]["default"]
        key = next(key for key in keys.read_keys(keys.RIG) if key.name == "power")
        key.default = ""
        faults = keys.find_faults("rig", [k for k in keys.read_keys(keys.RIG) if k.name != "power"] + [key], tables)
        self.assertEqual(len(faults), 1, faults)
        self.assertIn("[chamber] power is optional and has no default", faults[0])


@unittest.skipIf(jsonschema is None, "python3-jsonschema is not installed")
class Schemas(unittest.TestCase):
    def validator(self, name):
        return jsonschema.Draft7Validator(json.loads((SCHEMAS / f"{name}.schema.json").read_text(encoding="utf-8")))

    def assert_accepts(self, validator, content, position):
        errors = [f"{position}: {list(error.path)}: {error.message}" for error in validator.iter_errors(content)]
        self.assertEqual(errors, [])

    def test_the_schemas_are_up_to_date(self):
        texts = key_schemas.schema_texts()
        self.assertEqual({path.name for path in SCHEMAS.iterdir()}, set(texts))
        for name, text in texts.items():
            self.assertTrue((SCHEMAS / name).read_text(encoding="utf-8") == text, f"{name}: run docs/site/keys.py")

    def test_the_schemas_are_valid(self):
        seen = 0
        for path in SCHEMAS.iterdir():
            schema = json.loads(path.read_text(encoding="utf-8"))
            self.assertEqual(schema["$schema"], "http://json-schema.org/draft-07/schema#")
            jsonschema.Draft7Validator.check_schema(schema)
            seen += 1
        self.assertEqual(seen, 5)

    def test_each_key_is_in_its_schema_with_its_meaning(self):
        seen = 0
        for name in keys.FILES:
            text = (SCHEMAS / f"{'rig' if name == 'virtual' else name}.schema.json").read_text(encoding="utf-8")
            for key in keys.described_keys(name):
                self.assertTrue(f'"{key.name}": {{' in text, key.name)
                self.assertTrue(json.dumps(key.meaning.text, ensure_ascii=False)[1:-1] in text, key.name)
                seen += 1
        self.assertGreater(seen, 525)

    def test_shipped_files_are_accepted(self):
        for name, pattern, least in (("profile", "*.toml", 10), ("rig", "rigs/*.toml", 10)):
            files = shipped(pattern)
            self.assertGreaterEqual(len(files), least)
            for path in files:
                self.assert_accepts(self.validator(name), read(path), path.name)

    def test_files_in_the_documents_are_accepted(self):
        for name, least in (("profile", 5), ("rig", 2), ("laboratory", 2), ("order", 2), ("site", 2)):
            files = files_in_documents(name)
            self.assertGreaterEqual(len(files), least, name)
            for position, content in files:
                self.assert_accepts(self.validator(name), content, position)

    def test_site_file_of_queries_needs_only_the_store(self):
        content = {"schema": "gyrotherm-site/1", "store": {"address": "host=db user=ada", "passfile": "pgpass"}}
        self.assert_accepts(self.validator("site"), content, "[store] alone")

    def test_examples_are_accepted(self):
        seen = 0
        for name in keys.FILES:
            for key in keys.described_keys(name):
                if key.meaning.example:
                    value = tomllib.loads(f"value = {key.meaning.example}")["value"]
                    form = key_schemas.value_schema(key)
                    self.assert_accepts(jsonschema.Draft7Validator(form), value, f"[{key.table}] {key.name}")
                    seen += 1
        self.assertGreater(seen, 35)

    def test_wrong_files_are_refused(self):
        profile, rig = read(shipped("random.toml")[0]), read(shipped("rigs/example-f4t*.toml")[0])
        dcon, hard = read(shipped("rigs/example-binder*.toml")[0]), read(shipped("rigs/virtual-hard.toml")[0])
        reference = read(shipped("rigs/virtual-reference.toml")[0])
        laboratory = files_in_documents("laboratory")[0][1]
        order, site = files_in_documents("order")[0][1], files_in_documents("site")[0][1]
        wrong = [
            ("profile", profile, "an unknown key", lambda f: f.update(colour="red")),
            ("profile", profile, "another schema", lambda f: f.update(schema="gyrotherm-rig/1")),
            ("profile", profile, "a missing name", lambda f: f.pop("name")),
            ("profile", profile, "no segment", lambda f: f.update(segment=[])),
            ("profile", profile, "an unknown kind of segment", lambda f: f["segment"][0].update(kind="soak")),
            ("profile", profile, "a duration without a unit", lambda f: f["segment"][0].update(time="600")),
            ("profile", profile, "a duration that is a number", lambda f: f["segment"][0].update(time=600)),
            ("profile", profile, "a key of another kind of segment", lambda f: f["segment"][0].update(seed=1)),
            ("profile", profile, "a temperature in kelvins", lambda f: f["segment"][0].update(at="293 K")),
            ("profile", profile, "a temperature below absolute zero", lambda f: f["segment"][0].update(at=-300)),
            ("profile", profile, "a negative seed", lambda f: f["segment"][1].update(seed=-1)),
            ("profile", profile, "a range of one rate", lambda f: f["segment"][1].update(rates=["1 °C/min"])),
            ("rig", rig, "a missing line", lambda f: f["chamber"].pop("line")),
            ("rig", rig, "an unknown byte order", lambda f: f["chamber"].update(word_order="dcab")),
            ("rig", rig, "a limiter without a limit", lambda f: f["chamber"].update(limiter={"class": "2"})),
            ("rig", rig, "an unknown interlock", lambda f: f["policy"].update(window="warn")),
            ("rig", rig, "a fixed interlock", lambda f: f["policy"].update(air_limit="warn")),
            ("rig", rig, "a unit outside the bus", lambda f: f["chamber"]["link"].update(unit=256)),
            ("rig", rig, "modules of a Lake Shore 218", lambda f: f["thermometer"][0].update(addresses=[1])),
            ("rig", rig, "a coverage factor alone", lambda f: f["thermometer"][1].pop("uncertainty")),
            ("rig", rig, "a program without a command", lambda f: f["thermometer"][0].update(driver="process")),
            ("rig", rig, "a gyro without frames", lambda f: f["gyro"].pop("stream")),
            ("rig", rig, "a gyro without a line", lambda f: f["gyro"].pop("line")),
            ("rig", rig, "a name of the only gyro", lambda f: f["gyro"].update(name="u1")),
            ("rig", rig, "two thermometers for three", lambda f: f["analysis"].update(three_point=["A", "D"])),
            ("rig", rig, "a polynomial of one number", lambda f: f["thermometer"][0]["calibration"][1].update(
                polynomial=[1])),
            ("rig", rig, "limits of a channel with an unknown key", lambda f: f["limits"].update(
                channel={"A": {"low": 3}})),
            ("rig", dcon, "an address above 255", lambda f: f["thermometer"][0].update(addresses=[256])),
            ("rig", dcon, "a resistance of a thermocouple", lambda f: f["thermometer"][1].update(
                sensor={"kind": "thermocouple", "type": "T", "r0_ohm": 100})),
            ("rig", hard, "a missing mirror", lambda f: f["virtual"]["bias"].update(mirror_deg_per_h_per_k=[1, 2, 3])),
            ("rig", hard, "a network of the twin", lambda f: f["virtual"].update(network={})),
            ("rig", hard, "no thermal body of the twin", lambda f: f["virtual"].pop("thermal")),
            ("rig", hard, "a bias of the reference", lambda f: f["virtual"]["bias"].update(scale=1)),
            ("rig", hard, "films of the twin", lambda f: f["virtual"]["spread"].update(film=0.1)),
            ("rig", hard, "eight of nine time constants", lambda f: f["virtual"]["thermometers"].update(
                time_constant_s=[8] * 8)),
            ("rig", hard, "a time constant below 1 s", lambda f: f["virtual"]["plant"].update(sensor_s=0.5)),
            ("rig", hard, "spikes of a dead thermometer", lambda f: f["virtual"]["thermometers"].update(
                failing=[{"channel": "A", "how": "dead", "from": "1 h", "spikes_per_h": 1}])),
            ("rig", reference, "mirrors of the reference", lambda f: f["virtual"]["bias"].update(
                mirror_deg_per_h_per_k=[1, 2, 3, 4])),
            ("rig", reference, "no films of the reference", lambda f: f["virtual"]["spread"].pop("film")),
            ("laboratory", laboratory, "a country in words", lambda f: f.update(country="Germany")),
            ("laboratory", laboratory, "an unknown role", lambda f: f["person"][0].update(role="signer")),
            ("order", order, "a day of another form", lambda f: f.update(issued="25.11.2026")),
            ("order", order, "a limit of 0", lambda f: f["limit"][0].update(at_most=0)),
            ("site", site, "an address without a way", lambda f: f.update(notify={"address": [{"name": "day"}]})),
            ("site", site, "a rig without a store", lambda f: (f.pop("store", None), f.update(rig="r"))),
            ("site", site, "folders without a rig", lambda f: (f.pop("rig", None), f.update(folders=["runs"]))),
            ("site", site, "an archive without a rig", lambda f: (f.pop("rig", None), f.pop("folders", None), f.update(
                store={"address": "host=db"}, archive={"folder": "kept"}))),
        ]  # fmt: skip
        for name, good, what, change in wrong:
            self.assertTrue(self.validator(name).is_valid(good), what)
            changed = copy.deepcopy(good)
            change(changed)
            self.assertFalse(self.validator(name).is_valid(changed), f"{name}: {what} is accepted")


if __name__ == "__main__":
    unittest.main()
