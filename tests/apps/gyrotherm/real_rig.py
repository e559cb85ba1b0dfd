# SPDX-License-Identifier: Apache-2.0
"""Turns the virtual rig's file into a real one with the instruments at the given lines. A number is a port of this
machine."""
import os
import re
import sys

text = open(sys.argv[1], encoding="utf-8").read()
text = re.split(r"^\[virtual", text, flags=re.M)[0]
lines = iter("tcp://127.0.0.1:" + line if line.isdigit() else line for line in sys.argv[2:])
text = re.sub(r'^(line\s*=\s*)"virtual"', lambda m: '%s"%s"' % (m.group(1), next(lines)), text, flags=re.M)
# Observation of a run whose chamber is made safe, short enough for a test.
text += '\n[safe]\nobserve = "%s"\n' % os.environ.get("GYROTHERM_TEST_OBSERVE", "2 s")
# A real rig identifies its units.
text = re.sub(r"^\[gyro\]$", '[gyro]\nserial_number = "V-1"', text, flags=re.M)
print(text.replace('"../', '"' + sys.path[0] + "/../../../profiles/"))
