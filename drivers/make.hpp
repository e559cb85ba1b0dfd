/// Every line and every driver that a rig can be made of. Lines connect at first use and again after any fault, with
/// back-off.
#pragma once

#include "drivers/framed_gyro.hpp"
#include "drivers/lakeshore_218.hpp"
#include "drivers/modbus_chamber.hpp"
#include "drivers/modbus_tcp.hpp"
#include "drivers/tcp_stream.hpp"
