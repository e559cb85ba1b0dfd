// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/lakeshore_218.hpp"

#include <fmt/format.h>

#include <utility>

#include "drivers/line/text_exchange.hpp"
#include "drivers/thermometer/lakeshore_218_codec.hpp"
#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {

namespace {

constexpr const char* kTerminator = "\r\n";
constexpr std::string_view kWho = "LSCI,MODEL218";
const ResyncQuery kResync{.question = "*IDN?", .answer_begins = "LSCI,"};

class Lakeshore218 final : public Thermometer {
 public:
  Lakeshore218(std::unique_ptr<ByteStream> line, std::string place, Lakeshore218Timing timing)
      : exchange_(std::move(line), {.question_end = kTerminator,
                                    .answer_end = kTerminator,
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

Result<std::string> Lakeshore218::identify() {
  auto who = exchange_.ask(kResync.question, kResync);
  if (!who) return failure(at_instrument(place_, std::move(who.error())));
  if (!who->starts_with(kWho))
    return failure(
        at_instrument(place_, {FaultKind::mismatch, "*IDN?", fmt::format("\"{}\" answers, expected {}…", *who, kWho)}));
  return who;
}

std::vector<Result<Celsius>> Lakeshore218::read() {
  return readings_at(place_, kLakeshore218Inputs,
                     exchange_.ask("CRDG? 0", kResync).and_then([](const auto& line) { return decode_crdg(line); }));
}

}  // namespace

std::unique_ptr<Thermometer> make_lakeshore_218(std::unique_ptr<ByteStream> line, std::string place,
                                                Lakeshore218Timing timing) {
  return std::make_unique<Lakeshore218>(std::move(line), std::move(place), timing);
}

}  // namespace gyrotherm::drivers
