"""Turns the virtual rig's file into a real one whose instruments are at the given ports of this machine."""
import re
import sys

text = open(sys.argv[1], encoding="utf-8").read()
text = re.split(r"^\[virtual", text, flags=re.M)[0]
ports = iter(sys.argv[2:])
text = re.sub(r'^(line\s*=\s*)"virtual"', lambda m: '%s"tcp://127.0.0.1:%s"' % (m.group(1), next(ports)), text, flags=re.M)
print(text.replace("../chambers/", sys.path[0] + "/../../profiles/chambers/"))
