#include "rig/thermometer_sensor.hpp"

#include "core/toml_reader.hpp"

namespace gyrotherm {
namespace {

enum class SensorKind { rtd, thermocouple, thermistor, semiconductor };
constexpr Vocabulary<SensorKind, 4> kKinds{{{"rtd", SensorKind::rtd},
                                            {"thermocouple", SensorKind::thermocouple},
                                            {"thermistor", SensorKind::thermistor},
                                            {"semiconductor", SensorKind::semiconductor}}};
constexpr Vocabulary<MccWires, 2> kWires{{{"2-wire", MccWires::two_wire_two_sensors}, {"4-wire", MccWires::four_wire}}};
using Type = MccThermocoupleType;
constexpr Vocabulary<Type, 8> kTypes{{{"J", Type::j},
                                      {"K", Type::k},
                                      {"T", Type::t},
                                      {"E", Type::e},
                                      {"R", Type::r},
                                      {"S", Type::s},
                                      {"B", Type::b},
                                      {"N", Type::n}}};

float number(const TomlTable& table, const char* key) { return static_cast<float>(table.number(key)); }
float number(const TomlTable& table, const char* key, float fallback) {
  return table.has(key) ? number(table, key) : fallback;
}

}  // namespace

MccSensor read_sensor(const TomlTable& table) {
  switch (one_of(kKinds, table, "kind", "rtd")) {
    case SensorKind::thermocouple: return MccThermocouple{one_of(kTypes, table, "type")};
    case SensorKind::thermistor:
      return MccThermistor{.wires = one_of(kWires, table, "wires", "2-wire"),
                           .a = number(table, "a"),
                           .b = number(table, "b"),
                           .c = number(table, "c")};
    case SensorKind::semiconductor:
      return MccSemiconductor{.differential = table.boolean("differential", false),
                              .offset = number(table, "offset"),
                              .scale = number(table, "scale")};
    case SensorKind::rtd: break;
  }
  MccRtd rtd{.wires = one_of(kWires, table, "wires", "2-wire")};
  rtd.r0_ohm = number(table, "r0_ohm", rtd.r0_ohm);
  rtd.a_per_k = number(table, "a_per_k", rtd.a_per_k);
  rtd.b_per_k2 = number(table, "b_per_k2", rtd.b_per_k2);
  rtd.c_per_k4 = number(table, "c_per_k4", rtd.c_per_k4);
  if (!(rtd.r0_ohm > 0)) table.mistake("r0_ohm", "expected a resistance above zero");
  return rtd;
}

}  // namespace gyrotherm
