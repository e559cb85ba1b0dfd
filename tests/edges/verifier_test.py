#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tests the verifier of these attacks: it finds each removed, added or changed value of a record."""
from __future__ import annotations

import pathlib
import sqlite3
import struct
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from laboratory import AIR, SET_POINT, Chamber, Gyro, Laboratory, Thermometers, join_float, modbus_crc, split_float
from records import Record, holes, lost_seconds, part_path, read_record, wrong_readings
from rig import CHANNELS

SECONDS = 12
BEGAN = 1_800_000_000.0  # UTC of second 0


class Served:
    """The values that a laboratory without lines has served in some seconds."""

    def __init__(self) -> None:
        self.chamber, self.gyro = Chamber(rtu=False, seed=1), Gyro()
        self.thermometer_1, self.thermometer_2 = Thermometers(24.0), Thermometers(26.0)
        count = 0
        for second in range(SECONDS):
            utc = BEGAN + second + 0.05
            self.chamber.airs.append((utc, self.chamber.next_air()))
            for instrument in (self.thermometer_1, self.thermometer_2):
                instrument.readings()
                instrument.served[-1] = (utc, instrument.served[-1][1])
            count += Gyro.pulses_of(second)
            self.gyro.sent.append((utc - 0.5, count))

    def row(self, second: int) -> list[object]:
        temperatures = [float(text) for text in self.thermometer_1.served[second][1]]
        temperatures.append(float(self.thermometer_2.served[second][1][0]))
        before = self.gyro.sent[second - 1][1] if second else None
        pulses = None if before is None else self.gyro.sent[second][1] - before
        return [second, int((BEGAN + second) * 1e9), self.chamber.airs[second][1], *temperatures, pulses,
                None if pulses is None else 10 ** 9, "execute"]


class Verifier(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.served = Served()
        self.copies = 0
        self.begin_anew()

    def begin_anew(self) -> None:
        (self.folder / "run.db").unlink(missing_ok=True)
        self.write("run.db", range(SECONDS))

    def write(self, name: str, seconds: range) -> None:
        database = sqlite3.connect(self.folder / name)
        columns = ", ".join(f'"{c}" REAL' for c in CHANNELS)
        database.executescript(
            f"CREATE TABLE sample(slot INTEGER PRIMARY KEY, utc_ns INTEGER, chamber_air_c REAL, {columns},"
            "pulses INTEGER, interval_ns INTEGER, state TEXT); CREATE TABLE gap(first, last, cause);"
            "CREATE TABLE event(id INTEGER PRIMARY KEY, slot, kind, text); CREATE TABLE fault(slot, channel, what);")
        for second in seconds:
            row = self.served.row(second)
            database.execute(f"INSERT INTO sample VALUES({', '.join('?' * len(row))})", row)
        database.commit()
        database.close()

    def change(self, command: str) -> Record:
        database = sqlite3.connect(self.folder / "run.db")
        database.execute(command)
        database.commit()
        database.close()
        return self.read()

    def read(self) -> Record:
        self.copies += 1
        return read_record(self.folder / "run.db", self.folder / f"copy-{self.copies}")

    def wrong(self, record: Record) -> list[str]:
        laboratory = self.served
        return wrong_readings(record, laboratory)  # type: ignore[arg-type]

    def test_finds_nothing_in_valid_record(self) -> None:
        record = self.read()
        self.assertEqual((len(record.rows), holes(record), lost_seconds(record, SECONDS - 1), self.wrong(record)),
                         (SECONDS, [], [], []))

    def test_finds_values_of_other_second_or_channel(self) -> None:
        for column in ("chamber_air_c", *CHANNELS, "pulses"):
            self.begin_anew()
            record = self.change(f'UPDATE sample SET "{column}" = (SELECT "{column}" FROM sample WHERE slot = 6) '
                                 "WHERE slot = 8")
            self.assertEqual(len(self.wrong(record)), 1, column)
        record = self.change("UPDATE sample SET A = B WHERE slot = 3")
        self.assertTrue(any("second 3: A" in found for found in self.wrong(record)))

    def test_finds_wrong_pulse_sums(self) -> None:
        record = self.change(f"UPDATE sample SET interval_ns = {2 * 10 ** 9} WHERE slot = 5")
        self.assertEqual(len(self.wrong(record)), 1)

    def test_finds_missing_and_duplicate_seconds(self) -> None:
        record = self.change("DELETE FROM sample WHERE slot IN (4, 11)")
        self.assertEqual((holes(record), lost_seconds(record, SECONDS - 1)), ([4], [4, 11]))
        record = self.change("INSERT INTO gap VALUES(4, 5, 'late')")
        self.assertEqual((holes(record), lost_seconds(record, SECONDS - 1)), ([5], [11]))

    def test_reads_all_undamaged_parts(self) -> None:
        self.write("run.2.db", range(6, SECONDS))
        with open(self.folder / "run.db", "r+b") as file:
            file.write(bytes(200))
        record = self.read()
        self.assertEqual((sorted(record.rows), list(record.damaged)), (list(range(6, SECONDS)), ["run.db"]))
        self.assertEqual(lost_seconds(record, SECONDS - 1), list(range(6)))
        self.assertEqual(part_path(self.folder / "run.db", 3).name, "run.3.db")


class ChamberOfOurs(unittest.TestCase):
    """Golden bytes of the protocol, for errors that client and server could have in common."""

    def ask(self, pdu: bytes) -> bytes:
        return self.chamber.answer(pdu, 0.0, False)

    def setUp(self) -> None:
        self.chamber = Chamber(rtu=False, seed=1)

    def test_has_the_low_word_first(self) -> None:
        self.assertEqual(split_float(-40.25), (0x0000, 0xC221))
        self.assertEqual(self.ask(struct.pack(">BHHBHH", 16, SET_POINT, 2, 4, *split_float(40.5))).hex(), "100ade0002")
        self.assertEqual(self.chamber.set_point, 40.5)

    def test_refuses_unknown_registers_and_values_outside_limits(self) -> None:
        self.assertEqual(self.ask(struct.pack(">BHH", 3, 5, 1)), bytes([0x83, 2]))
        self.assertEqual(self.ask(struct.pack(">BHH", 3, AIR, 3)), bytes([0x83, 2]))
        self.assertEqual(self.ask(struct.pack(">BHHBHH", 16, SET_POINT, 2, 4, *split_float(200.0))), bytes([0x90, 3]))
        self.assertEqual(self.ask(struct.pack(">BHHBHH", 16, AIR, 2, 4, *split_float(20.0))), bytes([0x90, 2]))

    def test_serves_no_air_twice(self) -> None:
        served = [join_float(*struct.unpack(">HH", self.ask(struct.pack(">BHH", 3, AIR, 2))[2:])) for _ in range(900)]
        self.assertEqual(len(set(served)), len(served))

    def test_checks_frames_like_standard(self) -> None:
        self.assertEqual(modbus_crc(bytes.fromhex("010300000001")).hex(), "840a")

    def test_serves_on_all_links(self) -> None:
        for link in Laboratory.LINKS:
            laboratory = Laboratory(link)
            self.assertEqual(laboratory.lines["chamber"].split(":")[0], "serial" if link == "rtu" else "tcp")
            laboratory.close()


if __name__ == "__main__":
    unittest.main()
