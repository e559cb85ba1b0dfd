#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Small clients, written from public drivers and manual pages, drive the virtual instruments of `gyrotherm simulate`.

    text_clients_test.py GYROTHERM [NAME…]

The clients use no description file. Each one identifies the instrument, reads, writes a set point and reads it back,
starts and stops the chamber, and causes an error. `PUBLISHED` are the bytes that public sources print; the virtual
instruments must answer them byte by byte.
"""
from __future__ import annotations

import os
import pathlib
import re
import select
import socket
import subprocess
import sys
import tempfile
import time
import tty
import unittest
from dataclasses import dataclass

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parents[3]
ANSWERS_WITHIN, SILENCE = 2.0, 0.1  # s until an answer begins, and of the silence that ends it
READ_BACK_WITHIN = 6.0  # s
PORTS = {"weiss_simserv": 2049, "weiss_ascii2": 2049, "espec_p300": 10001, "thermotron_8800": 8888, "cts": 1080,
         "huber": 8101, "watlow_f4t_scpi": 5025}


@dataclass(frozen=True)
class Step:
    """A line, and the regular expression that its whole answer must fit. `eventually`: the unit may lag."""
    sent: bytes
    answer: bytes
    eventually: bool = False
    published: bool = False


def exact(sent: str, answer: str, published: bool = True, eventually: bool = False) -> Step:
    """Returns a step whose answer is exactly these bytes. Both texts are in hexadecimal."""
    return Step(bytes.fromhex(sent), re.escape(bytes.fromhex(answer)), eventually, published)


def line(sent: str, answer: str, end: str, answer_end: str, *, eventually: bool = False,
         published: bool = False) -> Step:
    """Returns a step with lines of text. `answer` is a regular expression; empty if there is no answer."""
    whole = answer.encode("latin-1") + re.escape(answer_end.encode()) if answer else b""
    return Step((sent + end).encode("latin-1"), whole, eventually, published)


def simserv() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\r", "\r\n", **more)
    return [
        ask("99997¶1¶1", "1¶LabEvent T/210/70/5( VIRTUAL1)?", published=True),
        ask("11004¶1¶1", r"1¶-?\d+\.\d+"),
        exact("31 31 30 30 31 B6 31 B6 31 B6 2D 34 30 2E 30 0D", "31 0D 0A"),  # -40 °C
        ask("11002¶1¶1", r"1¶-40(\.0+)?", eventually=True),
        ask("14001¶1¶1¶1", "1", published=True),
        ask("14003¶1¶1", "1¶1", eventually=True),
        ask("10012¶1", "1¶3", eventually=True, published=True),
        ask("19015¶1", "1"),
        ask("14001¶1¶1¶0", "1", published=True),
        ask("10012¶1", "1¶1", eventually=True, published=True),
        ask("11001¶1¶1¶500.0", "-6"),
        ask("12345¶1", "-5", published=True),
    ]


def ascii2() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\r", "\r", **more)
    number = r"-?\d{3,4}\.\d"
    rest = "0000.0 0100.0 0000.0 0000.0 0000.0 0000.0"
    return [
        Step(b"$01?\r", rb"(?s).*ASCII.*PROTOCOL.*\r\n?"),
        ask("$01I", rf"(?:{number} ){{14}}[01]{{32}}", published=True),
        ask(f"$01E -040.0 {rest} 00{30 * '0'}", "", published=True),
        ask("$01I", rf"-040\.0 {number} .*", eventually=True),
        ask(f"$01E 0023.0 {rest} 01{30 * '0'}", ""),
        ask("$01I", rf"0023\.0 .* 01[01]{{30}}", eventually=True),
        ask(f"$01E 0023.0 {rest} 00{30 * '0'}", ""),
        ask("$01I", rf"0023\.0 .* 00[01]{{30}}", eventually=True),
        ask("$02I", ""),
    ]


def espec() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\r\n", "\r\n", **more)
    number = r"-?\d+\.\d"
    return [
        ask("TYPE?", r"T,(T,)?(S2,)?P-?300,\d+\.\d"),
        ask("TEMP?", rf"{number},{number},{number},{number}"),
        ask("TEMP,S25.0", r"OK:TEMP, ?S25\.0"),
        ask("TEMP, S-40.0", r"OK:TEMP, ?S-40\.0", published=True),
        ask("TEMP?", rf"{number},-40\.0,{number},{number}", eventually=True),
        ask("MODE, CONSTANT", "OK:MODE, ?CONSTANT", published=True),
        ask("MON?", rf"{number}, *([^,]*, *)?CONSTANT, *0", eventually=True),
        ask("MODE, STANDBY", "OK:MODE, ?STANDBY", published=True),
        ask("MON?", rf"{number}, *([^,]*, *)?STANDBY, *0", eventually=True),
        ask("TEMP, S500.0", "NA:DATA OUT OF RANGE", published=True),
        ask("JUMP", "NA:.+"),
    ]


def thermotron() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\r", "\n", **more)
    return [
        ask("IDEN?", r".*8[28]00.*"),
        ask("PVAR1?", r"-?\d+\.\d{3}\r?"),
        ask("SETP1,-40", r"0\r?", published=True),
        ask("SETP1?", r"-40\.000\r?", eventually=True),
        ask("RUNM", r"0\r?", published=True),
        ask("SCOD?", r"1\r?", eventually=True, published=True),
        ask("STOP", r"0\r?", published=True),
        ask("SCOD?", r"5\r?", eventually=True, published=True),
        ask("SETP1,-400", r"[1-9]\r?"),
        ask("NONSENSE", r"[1-9]\d*\r?"),
    ]


def cts() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "", "", **more)
    number = r"[-\d]\d\d\.\d"
    return [
        ask("U1", rf"U1 {number} {number}"),
        ask("A0", rf"A0 {number} {number}"),
        ask("a0 -40.0", "a", published=True),
        ask("A0", rf"A0 {number} -40\.0", eventually=True),
        ask("s1 1", "s1", published=True),
        ask("S", r"(?s)S10.*", eventually=True),
        ask("s1 0", "s1", published=True),
        ask("S", r"(?s)S00.*", eventually=True),
        ask("xyz", ""),
    ]


def cts_serial() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return Step(framed(sent.encode("latin-1")), framed_pattern(answer), **more)
    return [
        Step(bytes.fromhex("0281C1B0F003"), framed_pattern(r"A0 [-\d]\d\d\.\d [-\d]\d\d\.\d"), published=True),
        ask("a0 -40.0", "a"),
        exact("02 81 F3 B1 A0 B1 D2 03", framed(b"s1").hex()),
        Step(bytes.fromhex("0281D3D203"), framed_pattern(r"S10......(.|\n)"), eventually=True, published=True),
        exact("02 81 F3 B1 A0 B0 D3 03", framed(b"s1").hex()),
        Step(bytes.fromhex("0281D3D203"), framed_pattern(r"S00......(.|\n)"), eventually=True, published=True),
        Step(bytes.fromhex("0281C1B0F103"), b""),  # wrong checksum
    ]


def framed(text: bytes) -> bytes:
    data = bytes([0x81, *(byte | 0x80 for byte in text)])
    check = 0
    for byte in data:
        check ^= byte
    return bytes([2, *data, check | 0x80, 3])


def framed_pattern(answer: str) -> bytes:
    """Marks a pattern of the text in a frame."""
    return b"framed:" + answer.encode("latin-1")


def huber() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\r\n", "\r\n", **more)
    return [
        ask("{M1B****", r"\{S1B[0-9A-F]{4}"),
        ask("{M01****", r"\{S01[0-9A-F]{4}"),
        exact("7B 4D 30 30 46 30 36 30 0D 0A", "7B 53 30 30 46 30 36 30 0D 0A"),  # -40 °C
        ask("{M00****", r"\{S00F060", eventually=True, published=True),
        ask("{M140001", r"\{S140001", published=True),
        ask("{M14****", r"\{S140001", eventually=True),
        ask("{M140000", r"\{S140000", published=True),
        ask("{M14****", r"\{S140000", eventually=True),
        ask("{X", ""),
    ]


def julabo() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\r", "\n", **more)
    return [
        ask("version", r"JULABO.*\r?"),
        ask("in_pv_00", r"-?\d+\.\d\d\r?"),
        ask("out_sp_00 55.50", "", published=True),
        ask("in_sp_00", r"55\.50\r?", eventually=True),
        ask("out_mode_05 1", "", published=True),
        ask("in_mode_05", r"1\r?", eventually=True, published=True),
        ask("status", r"0?3.*\r?", eventually=True),
        ask("out_mode_05 0", "", published=True),
        ask("in_mode_05", r"0\r?", eventually=True, published=True),
        ask("out_jump 1", ""),
    ]


def lauda() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\r\n", "\r\n", **more)
    return [
        ask("TYPE", r"[A-Z0-9]+.*"),
        ask("IN_PV_00", r" *-?\d+\.\d\d"),
        ask("OUT_SP_00_-40.00", "OK", published=True),
        ask("IN_SP_00", r" *-0*40\.00", eventually=True),
        ask("START", "OK", published=True),
        ask("IN_MODE_02", "0", eventually=True),
        ask("STOP", "OK", published=True),
        ask("IN_MODE_02", "1", eventually=True),
        ask("OUT_SP_00_900.00", "ERR_6"),
        ask("JUMP", r"ERR_\d+"),
    ]


def f4t_scpi() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\n", "\n", **more)
    return [
        ask("*IDN?", r"(?i)[^,]*WATLOW[^,]*,F4T.*"),
        ask(":UNIT:TEMPERATURE?", "C", published=True),
        ask(":SOURCE:CLOOP1:PVALUE?", r"-?\d+(\.\d+)?"),
        ask(":SOURCE:CLOOP1:SPOINT -40.0", "", published=True),
        ask(":SOURCE:CLOOP1:SPOINT?", r"-40(\.0+)?", eventually=True),
        ask(":OUTPUT1:STATE ON", "", published=True),
        ask(":OUTPUT1:STATE?", "ON", eventually=True, published=True),
        ask(":OUTPUT1:STATE OFF", "", published=True),
        ask(":OUTPUT1:STATE?", "OFF", eventually=True, published=True),
        ask("NONSENSE?", ""),
    ]


def keysight() -> list[Step]:
    def ask(sent: str, answer: str, **more: bool) -> Step:
        return line(sent, answer, "\n", "\n", **more)
    number = r"[-+]\d\.\d{8}E[-+]\d\d"
    prepared = ["ABOR", "*CLS", "CONF:TEMP FRTD,85,(@101:108)", "UNIT:TEMP C,(@101:108)", "SENS:TEMP:NPLC 1,(@101:108)",
                "FORM:READ:UNIT OFF", "FORM:READ:TIME OFF", "FORM:READ:CHAN OFF", "FORM:READ:ALAR OFF",
                "TRIG:SOUR IMM", "TRIG:COUN 1", "ROUT:SCAN (@101:108)"]
    return [
        ask("*IDN?", "HEWLETT-PACKARD,34970A,0,.*", published=True),
        ask("INIT;*OPC?;FETC?", ""),  # not prepared yet
        *[ask(command, "", published=command.startswith(("CONF", "ROUT", "ABOR"))) for command in prepared],
        ask("SYST:ERR?", r'\+0,"No error"', published=True),
        ask("INIT;*OPC?;FETC?", rf"1;{number}(,{number}){{7}}"),
    ]


CHAMBERS = {"simserv": ("weiss_simserv", simserv), "ascii2": ("weiss_ascii2", ascii2), "espec": ("espec_p300", espec),
            "thermotron": ("thermotron_8800", thermotron), "cts": ("cts", cts), "cts_serial": ("cts", cts_serial),
            "julabo": ("julabo", julabo), "huber": ("huber", huber), "lauda": ("lauda", lauda),
            "f4t_scpi": ("watlow_f4t_scpi", f4t_scpi)}
SERIAL = {"cts_serial": "19200,8O1", "julabo": "4800,7E1", "lauda": "9600,8N1"}
CHANNELS = ("A", "B", "C", "D", "E", "F", "G", "H", "shell")


def rig(chamber: str, serial: str) -> str:
    address = f"serial:/dev/ttyUSB0?{serial}" if serial else f"tcp://127.0.0.1:{PORTS[chamber]}"
    channels = ", ".join(f'"{name}"' for name in CHANNELS[:8])
    return f'''schema = "gyrotherm-rig/1"
name = "client"

[chamber]
map = "{SOURCE}/profiles/chambers/{chamber}.toml"
line = "{address}"
lowest = "-70 °C"
highest = "90 °C"
fastest_heating = "5 °C/min"
fastest_cooling = "5 °C/min"
safe_set_point = "20 °C"

[[thermometer]]
driver = "text"
description = "{SOURCE}/profiles/thermometers/keysight_34970a.toml"
line = "tcp://127.0.0.1:5025"
channels = [{channels}]

[[thermometer]]
driver = "pt12"
line = "tcp://127.0.0.1:5026"
channels = ["shell"]

[gyro]
line = "tcp://127.0.0.1:5027"
stream = "{SOURCE}/profiles/gyro-streams/pulse-count.toml"
arcsec_per_pulse = 0.1
latitude = 45.0
azimuth = 0.0
elevation = 90.0

[analysis]
gradients = [{channels}]
three_point = ["A", "D", "shell"]
'''


class Simulator:
    """`gyrotherm simulate` with one rig, and the addresses of its instruments."""

    def __init__(self, gyrotherm: pathlib.Path, folder: pathlib.Path, text: str, pty: bool) -> None:
        path = folder / "rig.toml"
        path.write_text(text, encoding="utf-8")
        command = [str(gyrotherm), "simulate", "--rig", str(path), "--json", *["--pty"] * pty]
        self.errors = folder / "errors.txt"
        with self.errors.open("wb") as errors:
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors)
        assert self.process.stdout
        self.lines: dict[str, list[str]] = {}
        printed, descriptor = b"", self.process.stdout.fileno()
        while select.select([descriptor], [], [], 1 if printed else 30)[0]:
            piece = os.read(descriptor, 4096)
            if not piece:
                break
            printed += piece
        for instrument, address in re.findall(r'"instrument": "([^"]+)", "line": "([^"]+)"', printed.decode()):
            self.lines.setdefault(instrument, []).append(address)

    def close(self) -> None:
        self.process.terminate()
        self.process.wait(30)
        assert self.process.stdout
        self.process.stdout.close()


class Wire:
    """A connection to an instrument."""

    def __init__(self, address: str) -> None:
        if address.startswith("serial:"):
            self.socket = None
            self.descriptor = os.open(address.removeprefix("serial:").partition("?")[0], os.O_RDWR | os.O_NOCTTY)
            tty.setraw(self.descriptor)
        else:
            host, _, port = address.removeprefix("tcp://").rpartition(":")
            self.socket = socket.create_connection((host, int(port)), timeout=10)
            self.descriptor = self.socket.fileno()

    def exchange(self, sent: bytes, is_answered: bool) -> bytes:
        """Sends bytes and returns what arrives until a silence."""
        os.write(self.descriptor, sent)
        answer = b""
        while select.select([self.descriptor], [], [], ANSWERS_WITHIN if is_answered and not answer else SILENCE)[0]:
            piece = os.read(self.descriptor, 4096)
            if not piece:
                break
            answer += piece
        return answer

    def close(self) -> None:
        self.socket.close() if self.socket else os.close(self.descriptor)


def fits(step: Step, answer: bytes) -> bool:
    if not step.answer.startswith(b"framed:"):
        return re.fullmatch(step.answer, answer) is not None
    text = bytes(byte & 0x7F for byte in answer[2:-2])
    return answer == framed(text) and re.fullmatch(step.answer.removeprefix(b"framed:"), text) is not None


class Clients(unittest.TestCase):
    gyrotherm: pathlib.Path

    def talk(self, address: str, steps: list[Step]) -> None:
        wire = Wire(address)
        try:
            for step in steps:
                end = time.monotonic() + (READ_BACK_WITHIN if step.eventually else 0)
                answer = wire.exchange(step.sent, bool(step.answer))
                while not fits(step, answer) and time.monotonic() < end:
                    time.sleep(0.3)
                    answer = wire.exchange(step.sent, bool(step.answer))
                self.assertTrue(fits(step, answer), f"{step.sent!r} was answered {answer!r}, not {step.answer!r}")
        finally:
            wire.close()

    def drive(self, name: str) -> None:
        chamber, steps = CHAMBERS[name]
        serial = SERIAL.get(name, "")
        with tempfile.TemporaryDirectory() as folder:
            simulator = Simulator(self.gyrotherm, pathlib.Path(folder), rig(chamber, serial), bool(serial))
            try:
                lines = simulator.lines.get("chamber", [])
                address = next((one for one in lines if one.startswith("serial:") == bool(serial)), "")
                self.assertTrue(address, f"{simulator.lines} {simulator.errors.read_text(errors='replace')}")
                self.talk(address, steps())
                if name == "simserv":
                    self.talk(simulator.lines["thermometer 1"][0], keysight())
            finally:
                simulator.close()
        count = len(steps()) + (len(keysight()) if name == "simserv" else 0)
        published = sum(step.published for step in steps() + (keysight() if name == "simserv" else []))
        print(f"{name:<12} {count} exchanges, {published} of them published", flush=True)


def add_test(name: str) -> None:
    def test(self: Clients) -> None:
        self.drive(name)
    setattr(Clients, f"test_{name}", test)


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if not word.startswith("--")]
    Clients.gyrotherm = pathlib.Path(words[0]).resolve()
    for each in CHAMBERS:
        if not words[1:] or each in words[1:]:
            add_test(each)
    unittest.main(argv=sys.argv[:1])
