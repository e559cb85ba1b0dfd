#include "drivers/thermometer/pt12.hpp"

#include <fmt/format.h>

#include <utility>

#include "drivers/line/text_exchange.hpp"
#include "drivers/thermometer/pt12_codec.hpp"

namespace gyrotherm {

namespace {

constexpr std::string_view kWho = "PT12";

class Pt12 final : public Thermometer {
 public:
  Pt12(std::unique_ptr<ByteStream> line, std::string place, Pt12Timing timing)
      : exchange_(std::move(line), {"\r", "\r\n", timing.within, timing.pause}), place_(std::move(place)) {}

  Result<std::string> identify() override;
  std::vector<Result<Celsius>> read() override;

 private:
  [[nodiscard]] Fault here(Fault fault) const;

  TextExchange exchange_;
  std::string place_;
};

/// Puts the instrument's own place in front.
Fault Pt12::here(Fault fault) const {
  fault.where = fault.where.empty() ? place_ : fmt::format("{} {}", place_, fault.where);
  return fault;
}

Result<std::string> Pt12::identify() {
  auto who = exchange_.ask("ID?");
  if (!who) return failure(here(std::move(who.error())));
  if (*who != kWho)
    return failure(here({FaultKind::mismatch, "ID?", fmt::format("\"{}\" answers, expected {}", *who, kWho)}));
  auto serial = exchange_.ask("SN?");
  if (!serial) return failure(here(std::move(serial.error())));
  return fmt::format("{} {}", kWho, *serial);
}

std::vector<Result<Celsius>> Pt12::read() {
  auto readings = exchange_.ask("T?").and_then([](const std::string& line) { return decode_pt12_temperatures(line); });
  if (!readings) return {kPt12Inputs, failure(here(std::move(readings.error())))};
  for (auto& reading : *readings)
    if (!reading) reading.error() = here(std::move(reading.error()));
  return std::move(*readings);
}

}  // namespace

std::unique_ptr<Thermometer> make_pt12(std::unique_ptr<ByteStream> line, std::string place, Pt12Timing timing) {
  return std::make_unique<Pt12>(std::move(line), std::move(place), timing);
}

}  // namespace gyrotherm
