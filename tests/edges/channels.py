# SPDX-License-Identifier: Apache-2.0
"""Lost thermometers and channels: they are reported immediately, and the run waits if it needs them (D1)."""
from __future__ import annotations

import functools
import re
import time
from typing import Any, Callable

from attack import Scene, enter
from laboratory import Laboratory
from program import Run, until
from records import wrong_readings
from rig import CHANNELS

REPORTED_WITHIN_S = 3.5  # s
SUSPENDED_WITHIN = 9.0  # s; suspend_after is 5 s
GOES_ON_WITHIN = 30.0  # s; resume_delay is 10 s


def names(text: str, channel: str) -> bool:
    """Returns whether a text names the channel as a separate token."""
    return re.search(rf"(?<![\w.°]){channel}(?![\w.])", text) is not None


def named(text: str, channels: tuple[str, ...]) -> list[str]:
    """Returns the channels that a text names. The fault of a whole instrument names the instrument."""
    if len(channels) > 1 and f"the {len(channels)} channels of thermometer" in text:
        return list(channels)
    return [channel for channel in channels if names(text, channel)]


def state(run: Run) -> str:
    return str(run.status().get("state"))


def expect_reported(scene: Scene, run: Run, before: str, lost: tuple[str, ...], since: float) -> None:
    """Expects the lost channels on standard error and in status."""
    on_stderr = until(lambda: named(run.errors()[len(before):], lost) == list(lost), REPORTED_WITHIN_S)
    scene.expect(on_stderr, f"not named on standard error within {REPORTED_WITHIN_S:g} s, which is no terminal: "
                            f"{run.errors()[len(before):]!r}")
    left = since + REPORTED_WITHIN_S + 1 - time.monotonic()
    in_status = until(lambda: named(" ".join(run.status().get("faults_now", [])), lost) == list(lost), left, 0.3)
    scene.expect(in_status, f"not named in faults_now: {run.status().get('faults_now')}")


def lost_channel(scene: Scene, *, lose: Callable[[Laboratory], Any], find: Callable[[Laboratory], Any],
                 lost: tuple[str, ...], rig: dict[str, Any], suspends: bool) -> None:
    """Loses channels for a while. Each is reported immediately, on standard error, in status and in the record. The
    run waits for channels that its analysis needs, and continues when they are back."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory, rig=rig)
    before, slot, since = run.errors(), run.acknowledged(), time.monotonic()
    lose(laboratory)
    expect_reported(scene, run, before, lost, since)
    if suspends:
        scene.expect(until(lambda: state(run) == "suspended", since + SUSPENDED_WITHIN - time.monotonic(), 0.3),
                     f"not suspended within {SUSPENDED_WITHIN:g} s, but \"{state(run)}\"")
    else:
        time.sleep(max(0.0, since + SUSPENDED_WITHIN - time.monotonic()))
        scene.expect(state(run) == "execute", f"\"{state(run)}\" although it may continue")
    before, found = run.errors(), run.acknowledged()
    find(laboratory)
    scene.expect(until(lambda: state(run) == "execute" and not run.status().get("faults_now"), GOES_ON_WITHIN, 0.5),
                 f"\"{state(run)}\" with {run.status().get('faults_now')}, {GOES_ON_WITHIN:g} s after all was well")
    time.sleep(1.5)
    scene.stop(run)
    record = scene.read(run.record)
    early = " ".join(text for at, kind, text in record.events if slot <= at <= slot + 5 and kind != "recovered")
    late = " ".join(text for at, kind, text in record.events if at >= found and kind == "recovered")
    scene.expect(named(early, lost) == list(lost), f"the record's events do not name {lost}: {early}")
    scene.expect(named(late, lost) == list(lost), f"the record's recoveries do not name {lost}: {late}")
    scene.expect_nothing_lost(record, run.acknowledged())
    wrong = wrong_readings(record, laboratory)
    scene.expect(not wrong, f"{len(wrong)} wrong or old readings: " + "; ".join(wrong[:4]))


def one_input(channel: str) -> dict[str, Any]:
    """One input of the first instrument reads out of range."""
    number = CHANNELS.index(channel)
    return {"lost": (channel,), "lose": lambda laboratory: laboratory.thermometer_1.lose(number),
            "find": lambda laboratory: laboratory.thermometer_1.lose()}


def lose_line(instrument: str, how: str, lost: tuple[str, ...]) -> dict[str, Any]:
    """The whole line of an instrument is lost."""
    return {"lost": lost, "lose": lambda laboratory: setattr(getattr(laboratory, instrument), how, True),
            "find": lambda laboratory: setattr(getattr(laboratory, instrument), how, False)}


WARN = {"policy": {"needed_channel_lost": '"warn"'}}
FEW = {"gradients": ("A", "B")}  # three_point needs A, D and shell, not C and H

CASES: dict[str, dict[str, Any]] = {
    "one_channel_lost": one_input("C") | {"rig": {}, "suspends": True},
    "one_channel_lost_with_warn": one_input("C") | {"rig": WARN, "suspends": False},
    "one_channel_lost_that_is_not_needed": one_input("H") | {"rig": FEW, "suspends": False},
    "channel_of_three_point_lost": one_input("D") | {"rig": FEW, "suspends": True},
    "line_of_eight_gone": lose_line("thermometer_1", "gone", CHANNELS[:8]) | {"rig": {}, "suspends": True},
    "line_of_eight_silent": lose_line("thermometer_1", "silent", CHANNELS[:8]) | {"rig": {}, "suspends": True},
    "line_of_one_gone": lose_line("thermometer_2", "gone", CHANNELS[8:]) | {"rig": {}, "suspends": True},
    "line_of_eight_gone_with_warn": lose_line("thermometer_1", "gone", CHANNELS[:8]) | {"rig": WARN, "suspends": False},
}
SHORT = ("one_channel_lost", "one_channel_lost_with_warn", "one_channel_lost_that_is_not_needed", "line_of_eight_gone")

for _name, _case in CASES.items():
    enter("channels", _name, functools.partial(lost_channel, **_case), long_only=_name not in SHORT)
