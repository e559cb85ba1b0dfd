# SPDX-License-Identifier: Apache-2.0
"""Rig files and profiles for the laboratory's instruments."""
from __future__ import annotations

import pathlib
from dataclasses import dataclass, field

SOURCE = pathlib.Path(__file__).resolve().parents[2]
MAP = (SOURCE / "profiles/chambers/watlow_f4t.toml").read_text(encoding="utf-8")
SAFE = 22.0  # °C, safe set point of every rig here
OBSERVE = '"3 s"'  # default observation time of the air
CHANNELS = ("A", "B", "C", "D", "E", "F", "G", "H", "shell")

GYRO_FRAME = """
[gyro.frame]
name = "virtual-16"
sync = [0xA5, 0x5A]
length = 16
field = [
  { role = "sequence", type = "u16", offset = 2, endian = "little" },
  { role = "timestamp", type = "u32", offset = 4, endian = "little", unit = "us" },
  { role = "pulse_count", type = "i32", offset = 8, endian = "little" },
  { role = "status", type = "u8", offset = 12, mask = 0xFF, good = 0 },
]

[gyro.frame.check]
kind = "crc16"
from = 0
offset = 14
endian = "little"
polynomial = 0x1021
initial = 0xFFFF
reflected = false
final_xor = 0
"""


@dataclass
class Rig:
    """Content of a rig file. `limits`, `safe` and `policy` are further lines of these tables in TOML."""
    lines: dict[str, str]
    framing: str = ""
    fastest: float = 30.0  # °C/min, both ways
    highest: float = 90.0  # °C
    gradients: tuple[str, ...] = CHANNELS[:8]
    limits: dict[str, str] = field(default_factory=dict)
    safe: dict[str, str] = field(default_factory=dict)
    policy: dict[str, str] = field(default_factory=dict)

    def text(self) -> str:
        framing = f'framing = "{self.framing}"\n' if self.framing else ""
        return f"""schema = "gyrotherm-rig/1"
name = "edges"

[chamber]
map = "watlow_f4t.toml"
line = "{self.lines["chamber"]}"
{framing}lowest = "-45 °C"
highest = "{self.highest:g} °C"
fastest_heating = "{self.fastest:g} °C/min"
fastest_cooling = "{self.fastest:g} °C/min"
safe_set_point = "{SAFE:g} °C"

[chamber.limiter]
class = "3.3"
lowest = "-65 °C"
highest = "110 °C"

[[thermometer]]
driver = "lakeshore_218"
line = "{self.lines["thermometer_1"]}"
channels = ["A", "B", "C", "D", "E", "F", "G", "H"]

[[thermometer]]
driver = "lakeshore_218"
line = "{self.lines["thermometer_2"]}"
channels = ["shell"]

[gyro]
serial_number = "T-1"
line = "{self.lines["gyro"]}"
arcsec_per_pulse = 0.1
latitude = 45.0
azimuth = 0.0
elevation = 90.0
{GYRO_FRAME}
[analysis]
gradients = [{", ".join(f'"{name}"' for name in self.gradients)}]
three_point = ["A", "D", "shell"]

{table("limits", self.limits)}{table("safe", {"observe": OBSERVE} | self.safe)}{table("policy", self.policy)}"""

    def write(self, folder: pathlib.Path, name: str = "rig.toml") -> pathlib.Path:
        """Writes the rig file and its register map."""
        (folder / "watlow_f4t.toml").write_text(MAP, encoding="utf-8")
        path = folder / name
        path.write_text(self.text(), encoding="utf-8")
        return path


def table(name: str, values: dict[str, str]) -> str:
    lines = "".join(f"{key} = {value}\n" for key, value in values.items())
    return f"[{name}]\n{lines}\n" if lines else ""


def profile(*segments: str) -> str:
    return 'schema = "gyrotherm-profile/1"\nname = "edges"\n' + "".join("\n[[segment]]\n" + s for s in segments)


def hold(at: float, seconds: int) -> str:
    return f'kind = "hold"\nat = "{at:g} °C"\ntime = "{seconds} s"\n'


def ramp(to: float, rate: float) -> str:
    return f'kind = "ramp"\nto = "{to:g} °C"\nrate = "{rate:g} °C/min"\n'
