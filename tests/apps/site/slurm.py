# SPDX-License-Identifier: Apache-2.0
"""A Slurm of a test's own: a controller and node daemons, all on this machine, in a folder, ended with the test."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

PROGRAMS = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol"]


def missing() -> list[str]:
    return [program for program in PROGRAMS if not shutil.which(program, path="/usr/sbin:/usr/bin:/sbin:/bin")]


def _free_port() -> int:
    with socket.socket() as line:
        line.bind(("127.0.0.1", 0))
        return line.getsockname()[1]


class SlurmCluster:
    def __init__(self, folder: Path, nodes: int = 2, cores: int = 1):
        self.folder = folder
        self.daemons: dict[str, subprocess.Popen] = {}
        folder.mkdir(parents=True, exist_ok=True)
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        folder.chmod(0o755)
        names = [f"node{i + 1}" for i in range(nodes)]
        for name in ("state", *names):
            (folder / name).mkdir()
        host = socket.gethostname()
        lines = ["ClusterName=test", f"SlurmctldHost={host}(127.0.0.1)", "SlurmUser=root", "AuthType=auth/munge",
                 f"AuthInfo=socket={folder}/munge.socket", "CredType=cred/munge", f"SlurmctldPort={_free_port()}",
                 f"StateSaveLocation={folder}/state", f"SlurmdSpoolDir={folder}/%n",
                 f"SlurmctldPidFile={folder}/ctld.pid",
                 f"SlurmdPidFile={folder}/%n.pid", f"SlurmctldLogFile={folder}/ctld.log",
                 f"SlurmdLogFile={folder}/%n.log", "ProctrackType=proctrack/linuxproc", "TaskPlugin=task/none",
                 "SelectType=select/cons_tres", "SelectTypeParameters=CR_CPU", "SchedulerType=sched/backfill",
                 "SchedulerParameters=batch_sched_delay=0,sched_min_interval=1000,sched_interval=1,bf_interval=1",
                 "JobAcctGatherType=jobacct_gather/none",
                 "AccountingStorageType=accounting_storage/none", "MpiDefault=none", "ReturnToService=2",
                 "SlurmdTimeout=10", "SlurmctldTimeout=30", "JobRequeue=1", "KillWait=2", "MailProg=/bin/true"]
        lines += [f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={_free_port()} CPUs={cores}"
                  for name in names]
        lines.append(f"PartitionName=lab Nodes={','.join(names)} Default=YES MaxTime=INFINITE State=UP")
        (folder / "slurm.conf").write_text("\n".join(lines) + "\n")
        (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
        self._start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket",
                    f"--pid-file={folder}/munge.pid", f"--log-file={folder}/munge.log",
                    f"--seed-file={folder}/munge.seed")
        self._wait(lambda: (folder / "munge.socket").exists(), "munged")
        self._start("slurmctld", "-D")
        for name in names:
            self.start_node(name)
        self._wait(lambda: self.command("sinfo", "-h", "-o", "%T %D").startswith(f"idle {nodes}"), "the nodes")

    def start_node(self, name: str) -> None:
        self._start("slurmd", "-D", "-N", name, key=name)

    def _start(self, *command: str, key: str | None = None) -> None:
        self.daemons[key or command[0]] = subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL,
                                                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                                           start_new_session=True)

    def _wait(self, is_there, what: str) -> None:
        for _ in range(300):
            if is_there():
                return
            time.sleep(0.1)
        raise RuntimeError(f"{what} did not come: {(self.folder / 'ctld.log').read_text()[-2000:]}")

    def command(self, *words: str) -> str:
        return subprocess.run(words, env=self.environment, capture_output=True, text=True, check=False).stdout

    def kill(self, node: str) -> None:
        """The machine is gone: its daemon, and all that it had begun."""
        log = str(self.folder / f"{node}.log")
        for process in Path("/proc").glob("[0-9]*"):
            try:
                begun = f"SLURMD_NODENAME={node}\0".encode() in (process / "environ").read_bytes()
                if begun or any(os.readlink(line) == log for line in (process / "fd").iterdir()):
                    os.kill(int(process.name), signal.SIGKILL)
            except OSError:
                continue
        self.daemons.pop(node).wait()

    def end(self) -> None:
        for daemon in reversed(list(self.daemons.values())):
            daemon.send_signal(signal.SIGTERM)
        for daemon in self.daemons.values():
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        self.daemons.clear()

    def __enter__(self) -> SlurmCluster:
        return self

    def __exit__(self, *_) -> None:
        self.end()
