# SPDX-License-Identifier: Apache-2.0
"""Limits that are passed while readings are lost, or by the controller's own profile."""
from __future__ import annotations

import functools
import threading
import time
from typing import Any, Callable

from attack import Scene, attack, enter
from laboratory import Laboratory
from program import until
from rig import SAFE, hold, ramp

SAFE_WITHIN = 6.0  # s after the limit, with two readings of three lost


class Flicker(threading.Thread):
    """Loses something in every other second."""

    def __init__(self, lose: Callable[[bool], None]) -> None:
        super().__init__(daemon=True)
        self.lose, self.ends = lose, threading.Event()
        self.start()

    def run(self) -> None:
        began = time.monotonic()
        number = 0
        while not self.ends.wait(max(0.0, began + number - time.monotonic())):
            self.lose(number % 2 == 1)
            number += 1
        self.lose(False)


def lose_line(instrument: str) -> Callable[[Laboratory], Callable[[bool], None]]:
    return lambda laboratory: functools.partial(setattr, getattr(laboratory, instrument), "silent")


def input_a(laboratory: Laboratory) -> Callable[[bool], None]:
    thermometer = laboratory.thermometer_1
    return lambda lost: thermometer.lose(*([0] if lost else []))


def hot_air(laboratory: Laboratory) -> None:
    laboratory.chamber.shown_air = 130.0


def hot_article(laboratory: Laboratory) -> None:
    laboratory.thermometer_1.base = 100.0


def beyond_its_limit(scene: Scene, *, flickers: Callable[[Laboratory], Callable[[bool], None]],
                     heat: Callable[[Laboratory], None]) -> None:
    """A limit is passed while its quantity is read only every other second. The chamber is made safe."""
    laboratory = scene.laboratory()
    run = scene.hot_run(laboratory, rig={"limits": {"thermometers_highest": '"80 °C"'}})
    flicker = Flicker(flickers(laboratory))
    time.sleep(4)
    since = time.monotonic()
    heat(laboratory)
    scene.expect_safe(laboratory, since, SAFE_WITHIN, "outside its limit, every other reading lost")
    flicker.ends.set()
    laboratory.chamber.shown_air = None  # run ends when the air approaches the safe set point
    code = run.wait()
    scene.expect(code == 6, f"exit {code}, expected 6")


for _name, _flickers, _heat in (("air_beyond_its_limit_in_every_other_second", lose_line("chamber"), hot_air),
                                ("article_beyond_its_limit_in_every_other_second", lose_line("thermometer_1"),
                                 hot_article),
                                ("loose_contact_beyond_its_limit", input_a, hot_article)):
    enter("limits", _name, functools.partial(beyond_its_limit, flickers=_flickers, heat=_heat))


@attack("limits")
def air_that_stands_still_now_and_then_unread(scene: Scene) -> None:
    """The chamber's air does not follow a ramp, and every other reading of it is lost. The run is suspended."""
    laboratory = scene.laboratory(air=30.0)
    rig: dict[str, Any] = {"limits": {"follow_time": '"10 s"', "chamber_lag": '"5 s"'}}
    run = scene.start(scene.profile(hold(30.0, 6), ramp(80.0, 30.0), hold(80.0, 600)), scene.rig(laboratory, **rig))
    scene.need(run.wait_acknowledged(4), f"the run did not begin: {run.errors()[-600:]}")
    laboratory.chamber.shown_air = 30.0
    flicker = Flicker(lose_line("chamber")(laboratory))
    suspended = until(lambda: "does not follow" in str(run.status().get("faults_now")), 60, 0.5)
    flicker.ends.set()
    scene.expect(suspended, f"60 s later: {run.status().get('state')}, {run.status().get('faults_now')}")
    scene.stop(run)


def profile_at_the_panel(scene: Scene, *, aborted: bool, goes_on: bool = False) -> None:
    """A profile is started at the controller's panel and overrules the set point. The run is suspended, and an abort
    ends the profile, too. While the controller acknowledges that and continues the profile, the chamber is not safe."""
    laboratory = scene.laboratory()
    chamber = laboratory.chamber
    run = scene.hot_run(laboratory)
    chamber.break_as(profile_stuck=goes_on)
    chamber.start_profile(80.0 if aborted else 130.0)
    if aborted:
        scene.expect(until(lambda: run.status().get("state") == "suspended", every=0.5),
                     f"15 s later the run is \"{run.status().get('state')}\"")
        scene.expect(run.tell("abort")[0], "the abort was refused")
    if goes_on:
        scene.expect(run.wait(12) is None, "it ended while the profile continued")
        chamber.heal()
    code = run.wait()
    scene.expect(code == 6, f"exit {code}, expected 6")
    scene.expect(chamber.profile_goal is None, "the profile continues although the run reports a safe chamber")
    scene.expect(abs(chamber.set_point - SAFE) < 0.01, f"the set point is {chamber.set_point:g} °C")


enter("limits", "profile_at_the_panel_and_abort", functools.partial(profile_at_the_panel, aborted=True))
enter("limits", "profile_at_the_panel_beyond_a_limit", functools.partial(profile_at_the_panel, aborted=False))
enter("limits", "profile_at_the_panel_that_goes_on",
      functools.partial(profile_at_the_panel, aborted=True, goes_on=True))
