# SPDX-License-Identifier: Apache-2.0
"""Independent Modbus client of a virtual F4T: chamber_peer.py tcp|rtu PORT|DEVICE WORD_ORDER.

Reads the air, moves the set point to where the air then goes, and asks for what must be refused.
"""
import sys
import time

from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.constants import Endian
from pymodbus.payload import BinaryPayloadBuilder, BinaryPayloadDecoder

CONTROL_MODE, AUTO, SET_POINT, AIR = 2730, 10, 2782, 2820
kind, place, order = sys.argv[1:4]
byte_order = Endian.Big if order in ("abcd", "cdab") else Endian.Little
word_order = Endian.Big if order in ("abcd", "badc") else Endian.Little
client = (ModbusTcpClient("127.0.0.1", port=int(place), timeout=2) if kind == "tcp" else
          ModbusSerialClient(port=place, baudrate=9600, timeout=2))
assert client.connect()


def read(address):
    reply = client.read_holding_registers(address, 2, slave=1)
    assert not reply.isError(), reply
    return BinaryPayloadDecoder.fromRegisters(reply.registers, byteorder=byte_order, wordorder=word_order).decode_32bit_float()


def exception(reply):
    assert reply.isError(), reply
    return reply.exception_code


began = read(AIR)
assert 15 < began < 25, began
builder = BinaryPayloadBuilder(byteorder=byte_order, wordorder=word_order)
builder.add_32bit_float(-40.25)
assert not client.write_registers(SET_POINT, builder.to_registers(), slave=1).isError()
assert read(SET_POINT) == -40.25
assert not client.write_register(CONTROL_MODE, AUTO, slave=1).isError()
deadline = time.monotonic() + 30
while read(AIR) > began - 2:
    assert time.monotonic() < deadline, "the air does not follow the set point"
    time.sleep(0.1)

if kind == "tcp":  # on a serial line the frame's end is unknown
    assert exception(client.read_exception_status(slave=1)) == 1
assert exception(client.write_coil(0, True, slave=1)) == 2
assert exception(client.read_holding_registers(5, 1, slave=1)) == 2
assert exception(client.write_register(AIR, 1, slave=1)) == 2
assert exception(client.write_register(CONTROL_MODE, 11, slave=1)) == 3
print("agreed")
