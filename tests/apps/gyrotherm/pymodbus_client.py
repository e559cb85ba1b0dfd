# SPDX-License-Identifier: Apache-2.0
"""Independent Modbus client: reads the virtual chamber's air and moves its set point."""
import re
import sys
import time

from pymodbus.client import ModbusTcpClient
from pymodbus.constants import Endian
from pymodbus.payload import BinaryPayloadBuilder, BinaryPayloadDecoder

port, map_file = int(sys.argv[1]), sys.argv[2]
text = open(map_file, encoding="utf-8").read()


def address(item):
    return int(re.search(r'name = "%s".*\n(?:.+\n)*?address = (\d+)' % item, text).group(1))


def read(client, item):
    reply = client.read_holding_registers(address(item), 2, slave=1)
    assert not reply.isError(), reply
    return BinaryPayloadDecoder.fromRegisters(reply.registers, byteorder=Endian.Big, wordorder=Endian.Big).decode_32bit_float()


client = ModbusTcpClient("127.0.0.1", port=port, timeout=2)
assert client.connect()
assert 15 < read(client, "air_temperature") < 25
builder = BinaryPayloadBuilder(byteorder=Endian.Big, wordorder=Endian.Big)
builder.add_32bit_float(35.25)
assert not client.write_registers(address("set_point"), builder.to_registers(), slave=1).isError()
assert read(client, "set_point") == 35.25
assert not client.write_register(address("control_mode"), 1, slave=1).isError()
deadline = time.monotonic() + 30
while read(client, "air_temperature") < 22:
    assert time.monotonic() < deadline, "the air does not follow the set point"
    time.sleep(0.2)
