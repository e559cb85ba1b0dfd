# SPDX-License-Identifier: Apache-2.0
"""An independent Modbus server: pymodbus_server.py tcp | pymodbus_server.py rtu DEVICE. Prints READY and its port.

Unit 1. Register a holds (a * 40503) mod 65536; 3000 to 3999 take what is written; 2000 on holds -40.25 in four word orders; a read at
60001 to 60004 is answered by exception 1 to 4. Coils and discrete inputs at multiples of 3 are on.
"""
import asyncio
import sys

from pymodbus.constants import Endian
from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.payload import BinaryPayloadBuilder
from pymodbus.register_read_message import ReadHoldingRegistersRequest
from pymodbus.server.async_io import ModbusSerialServer, ModbusTcpServer

registers = [a * 40503 % 65536 for a in range(60000)]
address = 2000
for byte_order in (Endian.Big, Endian.Little):
    for word_order in (Endian.Big, Endian.Little):
        builder = BinaryPayloadBuilder(byteorder=byte_order, wordorder=word_order)
        builder.add_32bit_float(-40.25)
        registers[address:address + 2] = builder.to_registers()
        address += 2
bits = [a % 3 == 0 for a in range(2000)]
unit = ModbusSlaveContext(
    co=ModbusSequentialDataBlock(0, list(bits)), di=ModbusSequentialDataBlock(0, list(bits)),
    hr=ModbusSequentialDataBlock(0, registers), ir=ModbusSequentialDataBlock(0, list(registers)), zero_mode=True)
context = ModbusServerContext(slaves={1: unit}, single=False)

answer = ReadHoldingRegistersRequest.execute
ReadHoldingRegistersRequest.execute = lambda self, context: (
    self.doException(self.address - 60000) if 60001 <= self.address <= 60004 else answer(self, context))


async def serve():
    if sys.argv[1] == "tcp":
        server = ModbusTcpServer(context, address=("127.0.0.1", 0))
        task = asyncio.ensure_future(server.serve_forever())
        await server.serving
        print("READY", server.server.sockets[0].getsockname()[1], flush=True)
        await task
    server = ModbusSerialServer(context, port=sys.argv[2], baudrate=115200, bytesize=8, parity="N", stopbits=1, timeout=0.005)
    await server.start()
    print("READY 0", flush=True)
    await server.serve_forever()


asyncio.run(serve())
