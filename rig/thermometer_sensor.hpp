/// [thermometer.sensor] of a rig file: what hangs on the inputs of a USB-TEMP.
#pragma once

#include "core/toml_reader.hpp"
#include "drivers/thermometer/mcc_usb_temp_setup.hpp"

namespace gyrotherm {

/// `kind` = "rtd" (the default: platinum, 100 Ω, IEC 60751; `r0_ohm`, `a_per_k`, `b_per_k2`, `c_per_k4`),
/// "thermocouple"
/// (`type`), "thermistor" (Steinhart–Hart `a`, `b`, `c`) or "semiconductor" (`offset`, `scale`, `differential`).
/// `wires`, of the first and the third: "2-wire" (the default) or "4-wire", which let every input have a sensor.
[[nodiscard]] MccSensor read_sensor(const TomlTable& table);

}  // namespace gyrotherm
