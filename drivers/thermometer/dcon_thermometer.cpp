#include "drivers/thermometer/dcon_thermometer.hpp"

#include <fmt/format.h>

#include <utility>

#include "drivers/line/text_exchange.hpp"

namespace gyrotherm {

namespace {

tl::unexpected<Fault> no_thermocouple(std::uint8_t type, std::string where) {
  return failure(FaultKind::mismatch, std::move(where),
                 fmt::format("set to type {:02X}, expected thermocouple J, K, T or E (0E to 11)", type));
}

class DconThermometer final : public Thermometer {
 public:
  DconThermometer(std::unique_ptr<ByteStream> line, std::string place, DconOptions options)
      : exchange_(std::move(line), {"\r", "\r", options.within, options.pause}),
        place_(std::move(place)),
        options_(options) {}

  Result<std::string> identify() override;
  std::vector<Result<Celsius>> read() override;

 private:
  using Ranges = std::vector<TemperatureRange>;  ///< of each input

  /// The unsealed line that answers.
  [[nodiscard]] Result<std::string> ask(std::string_view question);
  /// What follows the address in the answer to "$AA" and `what`.
  [[nodiscard]] Result<std::string> tell(std::string_view what);
  [[nodiscard]] Result<Ranges> setting();
  [[nodiscard]] Result<Ranges> setting_of_each_input();
  [[nodiscard]] Result<std::vector<Result<Celsius>>> readings();
  [[nodiscard]] Fault here(Fault fault) const;

  TextExchange exchange_;
  std::string place_;
  DconOptions options_;
  Ranges ranges_;  ///< empty: the module has yet to tell
};

/// Puts the instrument's own place in front.
Fault DconThermometer::here(Fault fault) const {
  fault.where = fault.where.empty() ? place_ : fmt::format("{} {}", place_, fault.where);
  return fault;
}

Result<std::string> DconThermometer::ask(std::string_view question) {
  auto answer = exchange_.ask(seal_dcon(std::string(question), options_.checksum)).and_then([&](const auto& line) {
    return unseal_dcon(line, options_.checksum).map([](auto text) { return std::string(text); });
  });
  if (!answer && answer.error().where.empty()) answer.error().where = question;
  return answer;
}

Result<std::string> DconThermometer::tell(std::string_view what) {
  const auto question = dcon_ask(options_.address, what);
  return ask(question).and_then([&](const std::string& line) -> Result<std::string> {
    auto rest = decode_dcon_answer(line, options_.address);
    if (rest) return std::string(*rest);
    rest.error().where = question;
    return failure(std::move(rest.error()));
  });
}

Result<DconThermometer::Ranges> DconThermometer::setting_of_each_input() {
  Ranges ranges;
  for (int input = 0; input < static_cast<int>(kDconInputs); ++input) {
    const auto type =
        tell(fmt::format("8C{}", input)).and_then([&](const auto& text) { return decode_dcon_type(text, input); });
    if (!type) return failure(type.error());
    const auto range = dcon_range(*type);
    if (!range) return no_thermocouple(*type, fmt::format("input {}", input));
    ranges.push_back(*range);
  }
  return ranges;
}

Result<DconThermometer::Ranges> DconThermometer::setting() {
  const auto configuration = tell("2").and_then([](const auto& text) { return decode_dcon_configuration(text); });
  if (!configuration) return failure(configuration.error());
  if (!configuration->in_engineering_units())
    return failure(FaultKind::mismatch, "",
                   fmt::format("set to format {:02X}, expected engineering units", configuration->format));
  if (const auto range = dcon_range(configuration->type)) return Ranges(kDconInputs, *range);
  auto ranges = setting_of_each_input();
  if (!ranges && ranges.error().kind == FaultKind::refused) return no_thermocouple(configuration->type, "");
  return ranges;
}

Result<std::vector<Result<Celsius>>> DconThermometer::readings() {
  if (ranges_.empty()) {
    auto found = setting();
    if (!found) return failure(std::move(found.error()));
    ranges_ = std::move(*found);
  }
  return ask(dcon_read_all(options_.address)).and_then([&](const std::string& line) {
    return decode_dcon_readings(line, options_.address, ranges_);
  });
}

Result<std::string> DconThermometer::identify() {
  ranges_.clear();
  auto name = tell("M");
  if (!name) return failure(here(std::move(name.error())));
  auto ranges = setting();
  if (!ranges) return failure(here(std::move(ranges.error())));
  ranges_ = std::move(*ranges);
  return fmt::format("{} at {:02X}", *name, options_.address);
}

std::vector<Result<Celsius>> DconThermometer::read() {
  auto found = readings();
  if (!found) {
    ranges_.clear();  // who answers next may be another module
    return {kDconInputs, failure(here(std::move(found.error())))};
  }
  for (auto& reading : *found)
    if (!reading) reading.error() = here(std::move(reading.error()));
  return std::move(*found);
}

}  // namespace

std::unique_ptr<Thermometer> make_dcon_thermometer(std::unique_ptr<ByteStream> line, std::string place,
                                                   DconOptions options) {
  return std::make_unique<DconThermometer>(std::move(line), std::move(place), options);
}

}  // namespace gyrotherm
