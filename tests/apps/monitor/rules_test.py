# SPDX-License-Identifier: Apache-2.0
"""Checks with promtool that the alert rules fire on the metrics of a run. run_answers_test.cpp checks the metrics."""
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

MONITOR = pathlib.Path(__file__).parents[3] / "apps/monitor"
RULES = MONITOR / "prometheus/gyrotherm.rules.yml"
OF_RUN = {"run": "soak", "rig": "oven", "profile": "p", "simulated": "0"}


def series(name: str, values: str, **more: str) -> dict[str, str]:
    labels = ",".join(f'{key}="{value}"' for key, value in (OF_RUN | more).items())
    return {"series": f"{name}{{{labels}}}", "values": values}


def fires(at: str, alert: str, severity: str = "", of: dict[str, str] | None = None, **annotations: str) -> dict:
    """Expects the alert at that time, or without a severity no alert."""
    labels = (OF_RUN if of is None else of) | {"severity": severity}
    alerts = [{"exp_labels": labels, "exp_annotations": annotations}] if severity else []
    return {"eval_time": at, "alertname": alert, "exp_alerts": alerts}


class Rules(unittest.TestCase):
    def judge(self, input_series: list[dict], *alerts: dict) -> None:
        """Runs promtool. Each series has a value every 15 s; "_" is no value."""
        if not shutil.which("promtool"):
            self.skipTest("promtool (prometheus) is not installed")
        test = {"interval": "15s", "input_series": input_series, "alert_rule_test": list(alerts)}
        with tempfile.TemporaryDirectory() as folder:
            told = pathlib.Path(folder) / "test.yml"
            told.write_text(json.dumps({"rule_files": [str(RULES)], "evaluation_interval": "15s", "tests": [test]}))
            judged = subprocess.run(["promtool", "test", "rules", told], capture_output=True, text=True, check=False)
        self.assertEqual(judged.returncode, 0, judged.stdout + judged.stderr)

    def test_aborted_run_is_reported_after_its_program_has_ended(self) -> None:
        self.judge(
            [
                series("gyrotherm_run_up", "1x10 _x200"),
                series("gyrotherm_run_alarms", "0x8 1x120 _x80"),
                series("gyrotherm_run_state", "0x8 1x1 0x119 _x80", state="aborting"),
                series("gyrotherm_run_state", "0x10 1x118 _x80", state="aborted"),
            ],
            fires("1m", "GyrothermRunAborted"),
            fires(
                "3m",
                "GyrothermRunAborted",
                "critical",
                summary="soak on oven was aborted",
                description="The chamber is made safe. This alert remains until another run begins on the rig.",
            ),
            fires(
                "13m",
                "GyrothermAlarmUnacknowledged",
                "warning",
                summary="1 unacknowledged alarms of soak on oven",
            ),
            fires("20m", "GyrothermRunDoesNotAnswer"),
            fires("45m", "GyrothermRunAborted"),
            fires("45m", "GyrothermAlarmUnacknowledged"),
        )

    def test_dead_run_is_not_reported_as_held(self) -> None:
        self.judge(
            [series("gyrotherm_run_up", "1x20 0x200"), series("gyrotherm_run_state", "1x20 _x200", state="held")],
            fires("40m", "GyrothermRunHeld"),
            fires(
                "40m",
                "GyrothermRunDoesNotAnswer",
                "critical",
                summary="soak on oven is unfinished, and no program executes it",
                description="The program or its disk has failed. The guard makes the chamber safe; "
                "gyrotherm resume continues the run.",
            ),
        )

    def test_missing_monitor_is_reported_for_documented_job_name(self) -> None:
        job = re.search(r"job_name: (\w+)", (MONITOR.parents[1] / "docs/monitor.md").read_text())[1]
        of = {"job": job, "instance": "rig:8321"}
        up = {"series": "up{job=\"%s\",instance=\"rig:8321\"}" % job, "values": "1x20 0x40"}
        self.judge(
            [up],
            fires("5m", "GyrothermMonitorDoesNotAnswer"),
            fires(
                "10m",
                "GyrothermMonitorDoesNotAnswer",
                "critical",
                of,
                summary="The monitor at rig:8321 does not respond",
            ),
        )


if __name__ == "__main__":
    unittest.main(verbosity=1)
