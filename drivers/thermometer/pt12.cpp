// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/pt12.hpp"

#include <fmt/format.h>

#include <utility>

#include "drivers/line/text_exchange.hpp"
#include "drivers/thermometer/placed_readings.hpp"
#include "drivers/thermometer/pt12_codec.hpp"

namespace gyrotherm::drivers {

namespace {

constexpr std::string_view kPt12 = "PT12";
const ResyncQuery kPt12Resync{.question = "ID?", .answer_begins = "PT12"};

class Pt12 final : public Thermometer {
 public:
  Pt12(std::unique_ptr<ByteStream> line, std::string place, Pt12Timing timing)
      : exchange_(std::move(line), {.question_end = "\r",
                                    .answer_end = "\r\n",
                                    .within = timing.within,
                                    .pause = timing.pause,
                                    .alone = true,
                                    .clock = timing.clock}),
        place_(std::move(place)) {}

  Result<std::string> identify() override;
  std::vector<Result<Celsius>> read() override;

 private:
  TextExchange exchange_;
  std::string place_;
};

Result<std::string> Pt12::identify() {
  auto who = exchange_.ask(kPt12Resync.question, kPt12Resync);
  if (!who) return failure(at_instrument(place_, std::move(who.error())));
  if (*who != kPt12)
    return failure(
        at_instrument(place_, {FaultKind::mismatch, "ID?", fmt::format("\"{}\" answers, expected {}", *who, kPt12)}));
  auto serial = exchange_.ask("SN?", kPt12Resync);
  if (!serial) return failure(at_instrument(place_, std::move(serial.error())));
  return fmt::format("{} {}", kPt12, *serial);
}

std::vector<Result<Celsius>> Pt12::read() {
  return readings_at(place_, kPt12Inputs, exchange_.ask("T?", kPt12Resync).and_then([](const auto& line) {
    return decode_pt12_temperatures(line);
  }));
}

}  // namespace

std::unique_ptr<Thermometer> make_pt12(std::unique_ptr<ByteStream> line, std::string place, Pt12Timing timing) {
  return std::make_unique<Pt12>(std::move(line), std::move(place), timing);
}

}  // namespace gyrotherm::drivers
