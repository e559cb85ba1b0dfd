# SPDX-License-Identifier: Apache-2.0
"""A rig around one of the controllers: thermometers in its air, a gyro, the rig file, and the programs."""
from __future__ import annotations

import pathlib
from dataclasses import dataclass
from typing import Callable

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parents[3]

import program  # starts programs, shared with tests/edges
from families import (F4, F4T, F4T_MANUAL, F4T_RUNNING, BinderMb1, BinderMb2, Chamber, Ezt570i, F4TCascade,
                      F4TMap2, F4TMap3, Temi, Tt5166, Umc1200, X100, Yinhe)
from loop_controllers import EZ_MANUAL, Eurotherm3504, EzZonePm, Nanodac
from modbus_server import Gyro, ModbusTcp, RtuInTcp, RtuOnTerminal, Thermometers, high_first

SAFE = 22.0  # °C, the safe set point of every rig
HOT = 40.0  # °C, set point of the runs
CHANNELS = ("A", "B", "C", "D", "E", "F", "G", "H", "shell")


@dataclass(frozen=True)
class Fake:
    """A controller, its link, its register map, and the lines that the rig file adds to `[chamber]`."""
    make: Callable[[], Chamber]
    server: type
    map: str
    keys: str = ""
    verifies: str = ""  # text that `check --connect` must print as verified


F4T_PLAIN = "Watlow F4T, control loops without cascade"
F4T_WITH_CASCADE = "Watlow F4T with cascade control"
AIR_CONTROL = "the set point is that of the air (cascade off)"
EZ_MAP_1 = "data map 1 (register 1880 holds a control mode)"
HIGH_WORD = 'word_order = "abcd"'

FAKES: dict[str, Fake] = {
    "f4t_celsius_event_power": Fake(lambda: F4T(power="event_1", limit_card=True), ModbusTcp, "watlow_f4t",
                                    'power = "event_1"', F4T_PLAIN),
    "f4t_fahrenheit_key_power": Fake(
        lambda: F4T(in_fahrenheit=True, words=high_first, rtu=True, power="key_1", part="F4T1A1DAA1B1ABA", lag=1.0,
                    lowest=-20, highest=60, mode=F4T_MANUAL, profile=F4T_RUNNING, refuses_while_off=True),
        RtuInTcp, "watlow_f4t", f'power = "key_1"\n{HIGH_WORD}', F4T_PLAIN),
    "cascade_beside_a_loop": Fake(lambda: F4TCascade(limit_card=True), ModbusTcp, "watlow_f4t_cascade",
                                  verifies=AIR_CONTROL),
    "cascade_alone_fahrenheit": Fake(
        lambda: F4TCascade(part="F4T1A1DAA1B6ABA", in_fahrenheit=True, rtu=True, words=high_first, lag=1.0,
                           mode=F4T_MANUAL), RtuOnTerminal, "watlow_f4t_cascade", HIGH_WORD, F4T_WITH_CASCADE),
    "map_2_celsius": Fake(F4TMap2, ModbusTcp, "watlow_f4t_map2"),
    "map_2_fahrenheit_profile": Fake(lambda: F4TMap2(in_fahrenheit=True, decimals=1, profile=True, lag=1.0), RtuInTcp,
                                     "watlow_f4t_map2"),
    "map_3_celsius": Fake(F4TMap3, ModbusTcp, "watlow_f4t_map3"),
    "map_3_fahrenheit_profile": Fake(lambda: F4TMap3(in_fahrenheit=True, decimals=1, part_decimals=0, profile=True),
                                     RtuInTcp, "watlow_f4t_map3"),
    "f4_celsius": Fake(F4, RtuInTcp, "watlow_f4", verifies="Watlow F4"),
    "f4_fahrenheit_profile": Fake(
        lambda: F4(in_fahrenheit=True, decimals=2, profile=True, lag=1.0, serial=815, lowest=0, highest=60,
                   cascade=True, only_one=True), RtuOnTerminal, "watlow_f4", verifies="Watlow F4"),
    "mb1_manual_at_1581": Fake(lambda: BinderMb1(reply_function=4, other_bits=0x0001), RtuInTcp, "binder_mb1"),
    "mb1_manual_at_156f": Fake(
        lambda: BinderMb1(manual_at=0x156F, active_at=0x1177, mode=0x0400, lag=1.0, busy_every=7), RtuInTcp,
        "binder_mb1"),
    "mb2_idle": Fake(lambda: BinderMb2(contacts=2 | 0x20), RtuInTcp, "binder_mb2"),
    "mb2_program": Fake(
        lambda: BinderMb2(contacts=0x82, program=True, lag=1.0, denies=True, reply_function=4, busy_every=9), RtuInTcp,
        "binder_mb2"),
    "ezt_off": Fake(lambda: Ezt570i(events=0x102), RtuInTcp, "csz_ezt570i",
                    verifies="the set point is that of the air (product control off)"),
    "ezt_held_profile": Fake(lambda: Ezt570i(events=1, profile=2, product_control=4, lowest=-20, highest=60), RtuInTcp,
                             "csz_ezt570i", verifies="the set point is that of the air (product control off)"),
    "temp1000_stopped": Fake(Temi, RtuInTcp, "samwon_temi"),
    "temp2500_program": Fake(lambda: Temi(in_force_at=2, running=True, fix=False), RtuOnTerminal, "samwon_temi"),
    "x100_stopped": Fake(lambda: X100(panel=0), RtuOnTerminal, "samwon_x100"),
    "x100_program": Fake(lambda: X100(state=X100.PROGRAM, lag=1.3), RtuInTcp, "samwon_x100"),
    "tt5166_plain": Fake(Tt5166, RtuInTcp, "tt5166"),
    "tt5166_zeros": Fake(lambda: Tt5166(zero_every=5, ignores_while_off=True), RtuOnTerminal, "tt5166"),
    "umc1200_miscounting": Fake(Umc1200, ModbusTcp, "umc1200"),
    "umc1200_zeros": Fake(lambda: Umc1200(miscounts=False, zero_every=6), ModbusTcp, "umc1200"),
    "yinhe_plain": Fake(lambda: Yinhe(air=25.0), ModbusTcp, "yinhe"),
    "yinhe_slow_zeros": Fake(lambda: Yinhe(zero_every=6, period=0.18), ModbusTcp, "yinhe"),
    "ez_zone_fahrenheit": Fake(EzZonePm, RtuOnTerminal, "watlow_ez_zone_pm", verifies=EZ_MAP_1),
    "ez_zone_celsius_high_word": Fake(lambda: EzZonePm(in_fahrenheit=False, words=high_first, mode=EZ_MANUAL),
                                      ModbusTcp, "watlow_ez_zone_pm", HIGH_WORD, EZ_MAP_1),
    "nanodac_inhibited": Fake(Nanodac, ModbusTcp, "eurotherm_nanodac"),
    "nanodac_manual": Fake(lambda: Nanodac(inhibit=False, manual=True, lowest=0, highest=60), ModbusTcp,
                           "eurotherm_nanodac"),
    "eurotherm_3504": Fake(Eurotherm3504, ModbusTcp, "eurotherm_3504"),
    "eurotherm_3504_manual": Fake(lambda: Eurotherm3504(manual=True), RtuOnTerminal, "eurotherm_3504"),
}
IDENTITY_MAPS = {"watlow_f4t": ("tcp", "rtu", "rtu_over_tcp"), "watlow_f4t_cascade": ("tcp", "rtu", "rtu_over_tcp"),
                 "watlow_f4": ("rtu", "rtu_over_tcp")}


class Bench:
    """Serves a controller, its thermometers and its gyro, in a folder of its own."""

    def __init__(self, gyrotherm: pathlib.Path, folder: pathlib.Path, fake: Fake, air: float | None = None) -> None:
        self.programs, self.folder, self.fake = program.Programs(gyrotherm, folder), folder, fake
        self.chamber = fake.make()
        if air is not None:
            self.chamber.air = air
        self.server = fake.server(self.chamber)
        self.thermometers, self.gyro = Thermometers(self.chamber), Gyro()

    def rig(self, map_name: str = "", *, keys: str = "", more: str = "", name: str = "rig.toml") -> pathlib.Path:
        own = not map_name
        framing = f'framing = "{self.server.framing}"\n' if self.server.framing else ""
        path = self.folder / name
        path.write_text(f"""schema = "gyrotherm-rig/1"
name = "peer"

[chamber]
map = "{SOURCE}/profiles/chambers/{map_name or self.fake.map}.toml"
line = "{self.server.line}"
{framing}{self.fake.keys if own else keys}
lowest = "5 °C"
highest = "55 °C"
fastest_heating = "30 °C/min"
fastest_cooling = "30 °C/min"
safe_set_point = "{SAFE:g} °C"

[[thermometer]]
driver = "pt12"
line = "{self.thermometers.line}"
channels = [{", ".join(f'"{name}"' for name in CHANNELS)}]

[gyro]
serial_number = "T-1"
line = "{self.gyro.line}"
stream = "{SOURCE}/profiles/gyro-streams/pulse-count.toml"
arcsec_per_pulse = 0.1
latitude = 45.0
azimuth = 0.0
elevation = 90.0

[analysis]
gradients = ["A", "B", "C", "D", "E", "F", "G", "H"]
three_point = ["A", "D", "shell"]

[safe]
observe = "4 s"

[limits]
chamber_lag = "10 s"
follow_time = "10 s"
{more}""", encoding="utf-8")
        return path

    def check(self, rig: pathlib.Path) -> program.Ran:
        return self.programs.finish([self.programs.gyrotherm, "check", self.profile(), "--rig", rig, "--connect"], 60)

    def profile(self, seconds: int = 600) -> pathlib.Path:
        path = self.folder / "profile.toml"
        path.write_text('schema = "gyrotherm-profile/1"\nname = "hot"\n\n[[segment]]\nkind = "hold"\n'
                        f'at = "{HOT:g} °C"\ntime = "{seconds} s"\n', encoding="utf-8")
        return path

    def run(self, rig: pathlib.Path, record: str = "run.db") -> program.Run:
        path = self.folder / record
        return program.start(self.programs, ["run", self.profile(), "--rig", rig, "--out", path, "--json"], path,
                             name=path.stem)

    def close(self) -> None:
        program.sweep(self.folder)
        for instrument in (self.server, self.thermometers, self.gyro):
            instrument.close()
