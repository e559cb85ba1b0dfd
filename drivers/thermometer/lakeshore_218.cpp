#include "drivers/thermometer/lakeshore_218.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "drivers/line/deadline.hpp"
#include "drivers/thermometer/lakeshore_218_codec.hpp"

namespace gyrotherm {

namespace {

constexpr std::size_t kLongestLine = 256;
constexpr std::string_view kTerminator = "\r\n";
constexpr std::string_view kWho = "LSCI,MODEL218";

class Lakeshore218 final : public Thermometer {
 public:
  Lakeshore218(std::unique_ptr<ByteStream> line, std::string place, Lakeshore218Timing timing)
      : line_(std::move(line)), place_(std::move(place)), timing_(timing) {}

  Result<std::string> identify() override;
  std::vector<Result<Celsius>> read() override;

 private:
  [[nodiscard]] Result<void> wait_for_silence();
  [[nodiscard]] Result<std::string> ask(std::string_view command);
  [[nodiscard]] Result<std::string> receive_line();
  [[nodiscard]] Fault here(Fault fault) const;

  std::unique_ptr<ByteStream> line_;
  std::string place_;
  Lakeshore218Timing timing_;
};

/// Puts the instrument's own place in front.
Fault Lakeshore218::here(Fault fault) const {
  fault.where = fault.where.empty() ? place_ : fmt::format("{} {}", place_, fault.where);
  return fault;
}

/// Takes away what an older query left on the line.
Result<void> Lakeshore218::wait_for_silence() {
  std::array<std::byte, kLongestLine> stale;
  const Deadline deadline(timing_.within);
  do {
    const auto size = line_->read(stale, timing_.pause);
    if (size) continue;
    if (size.error().kind == FaultKind::timeout) return {};
    return failure(size.error());
  } while (!deadline.over());
  return failure(FaultKind::corrupted, "", "the line does not fall silent");
}

Result<std::string> Lakeshore218::receive_line() {
  std::string text;
  std::array<std::byte, kLongestLine> buffer;
  const Deadline deadline(timing_.within);
  while (true) {
    const auto size = line_->read(std::span(buffer).first(kLongestLine - text.size()), deadline.left());
    if (!size) return failure(size.error());
    text.append(reinterpret_cast<const char*>(buffer.data()), *size);
    if (const auto end = text.find(kTerminator); end != std::string::npos) return text.substr(0, end);
    if (text.size() == kLongestLine) return failure(FaultKind::corrupted, "", "no end of line in 256 bytes");
  }
}

Result<std::string> Lakeshore218::ask(std::string_view command) {
  if (auto silent = wait_for_silence(); !silent) return failure(std::move(silent.error()));
  const auto query = fmt::format("{}{}", command, kTerminator);
  if (auto sent = line_->write(std::as_bytes(std::span(query)), timing_.within); !sent)
    return failure(std::move(sent.error()));
  return receive_line();
}

Result<std::string> Lakeshore218::identify() {
  auto who = ask("*IDN?");
  if (!who) return failure(here(std::move(who.error())));
  if (!who->starts_with(kWho))
    return failure(here({FaultKind::mismatch, "*IDN?", fmt::format("\"{}\" answers, expected {}…", *who, kWho)}));
  return who;
}

std::vector<Result<Celsius>> Lakeshore218::read() {
  auto readings = ask("CRDG? 0").and_then([](const std::string& line) { return decode_crdg(line); });
  if (!readings) return {kLakeshore218Inputs, failure(here(std::move(readings.error())))};
  for (auto& reading : *readings)
    if (!reading) reading.error() = here(std::move(reading.error()));
  return std::move(*readings);
}

}  // namespace

std::unique_ptr<Thermometer> make_lakeshore_218(std::unique_ptr<ByteStream> line, std::string place,
                                                Lakeshore218Timing timing) {
  return std::make_unique<Lakeshore218>(std::move(line), std::move(place), timing);
}

}  // namespace gyrotherm
