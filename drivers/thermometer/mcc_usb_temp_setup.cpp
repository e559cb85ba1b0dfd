#include "drivers/thermometer/mcc_usb_temp_setup.hpp"

#include <cassert>

namespace gyrotherm {

namespace {

enum class SensorCode : std::uint8_t { rtd, thermistor, thermocouple, semiconductor };
enum class Excitation : std::uint8_t { off, ten_ua, two_hundred_ten_ua };

template <class Code>
MccRequest set(std::uint8_t input, MccItem item, Code code) {
  return mcc_set_item(input, item, static_cast<std::uint8_t>(code));
}

std::vector<MccRequest> setup(std::uint8_t input, const MccRtd& rtd) {
  return {set(input, MccItem::sensor, SensorCode::rtd),
          set(input, MccItem::connection, rtd.wires),
          set(input, MccItem::excitation, Excitation::two_hundred_ten_ua),
          set(input, MccItem::gain, 2),
          mcc_set_item(input, MccItem::coefficient_0, rtd.r0_ohm),
          mcc_set_item(input, MccItem::coefficient_1, rtd.a_per_k),
          mcc_set_item(input, MccItem::coefficient_2, rtd.b_per_k2),
          mcc_set_item(input, MccItem::coefficient_3, rtd.c_per_k4)};
}

std::vector<MccRequest> setup(std::uint8_t input, const MccThermistor& thermistor) {
  return {set(input, MccItem::sensor, SensorCode::thermistor),
          set(input, MccItem::connection, thermistor.wires),
          set(input, MccItem::excitation, Excitation::ten_ua),
          set(input, MccItem::gain, 0),
          mcc_set_item(input, MccItem::coefficient_0, thermistor.a),
          mcc_set_item(input, MccItem::coefficient_1, thermistor.b),
          mcc_set_item(input, MccItem::coefficient_2, thermistor.c)};
}

std::vector<MccRequest> setup(std::uint8_t input, const MccSemiconductor& semiconductor) {
  return {set(input, MccItem::sensor, SensorCode::semiconductor),
          set(input, MccItem::connection, semiconductor.differential),
          set(input, MccItem::excitation, Excitation::off),
          set(input, MccItem::gain, 1),
          mcc_set_item(input, MccItem::coefficient_0, semiconductor.offset),
          mcc_set_item(input, MccItem::coefficient_1, semiconductor.scale)};
}

std::vector<MccRequest> setup(std::uint8_t input, const MccThermocouple& thermocouple) {
  return {set(input, MccItem::sensor, SensorCode::thermocouple), set(input, MccItem::excitation, Excitation::off),
          set(input, MccItem::thermocouple, thermocouple.type)};
}

constexpr TemperatureRange kOther{{-273.15}, {200}};
TemperatureRange range(const MccRtd&) { return {{-200}, {850}}; }
TemperatureRange range(const MccThermistor&) { return kOther; }
TemperatureRange range(const MccSemiconductor&) { return kOther; }
TemperatureRange range(const MccThermocouple& thermocouple) {
  switch (thermocouple.type) {
    case MccThermocoupleType::j: return {{-210}, {1200}};
    case MccThermocoupleType::k: return {{-270}, {1372}};
    case MccThermocoupleType::t: return {{-270}, {400}};
    case MccThermocoupleType::e: return {{-270}, {1000}};
    case MccThermocoupleType::r:
    case MccThermocoupleType::s: return {{-50}, {1768.1}};
    case MccThermocoupleType::b: return {{0}, {1820}};
    case MccThermocoupleType::n: return {{-270}, {1300}};
  }
  return kMccWidest;
}

}  // namespace

std::vector<MccRequest> mcc_setup(std::uint8_t input, const MccSensor& sensor) {
  assert(input < kMccInputs);
  return std::visit([input](const auto& kind) { return setup(input, kind); }, sensor);
}

TemperatureRange mcc_range(const MccSensor& sensor) {
  return std::visit([](const auto& kind) { return range(kind); }, sensor);
}

}  // namespace gyrotherm
