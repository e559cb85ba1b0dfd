// SPDX-License-Identifier: Apache-2.0
#include "drivers/supply/safety_relay.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "core/deadline.hpp"
#include "core/toml_text.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/modbus.hpp"
#include "drivers/line/text_exchange.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr Duration kConnectRelayWithin = std::chrono::seconds(1);
constexpr Duration kRelayAnswerWithin = std::chrono::seconds(1);
constexpr Duration kRelayPause = std::chrono::milliseconds(100);
constexpr int kRelayReadings = 20;
constexpr Duration kSwitchRelayWithin = std::chrono::seconds(3);
constexpr Duration kLongestRelayPause = std::chrono::milliseconds(500);
constexpr Duration kShortestAfter = std::chrono::seconds(2), kLongestAfter = std::chrono::minutes(10);
constexpr const char* kRtuOverTcp = "rtu_over_tcp";

class ModbusRelay final : public SafetyRelay {
 public:
  ModbusRelay(const Line& line, const RelaySettings& settings) : settings_(settings) {
    ModbusLink link;
    if (std::holds_alternative<SerialLine>(line) || settings.is_rtu_over_tcp) link.framing = ModbusLink::Framing::rtu;
    registers_ = make_modbus(line, apply_settings(link, settings.link));
  }

  Result<RelayPosition> read() override {
    registers_->end_rest();
    const auto function = is_coil() ? ReadFunction::coils : ReadFunction::holding_registers;
    const auto words = registers_->read(function, settings_.address, 1);
    if (!words) return failure(words.error());
    if (words->front() == settings_.open_value) return RelayPosition::open;
    if (words->front() == settings_.closed_value) return RelayPosition::closed;
    return failure(FaultKind::mismatch, "relay",
                   fmt::format("reads {}, expected {} (open) or {} (closed)", words->front(), settings_.open_value,
                               settings_.closed_value));
  }

  Result<void> command(RelayPosition position) override {
    registers_->end_rest();
    const std::array<std::uint16_t, 1> words{position == RelayPosition::open ? settings_.open_value
                                                                             : settings_.closed_value};
    return registers_->write(is_coil() ? WriteFunction::coil : WriteFunction::one_register, settings_.address, words);
  }

 private:
  [[nodiscard]] bool is_coil() const { return settings_.kind == RelayKind::coil; }

  RelaySettings settings_;
  std::unique_ptr<Registers> registers_;
};

class TextRelay final : public SafetyRelay {
 public:
  TextRelay(const Line& line, const RelaySettings& settings)
      : texts_(settings.texts),
        after_write_(settings.link.after_write.value_or(Duration{})),
        after_read_(settings.link.after_read.value_or(Duration{})),
        exchange_(open_stream(line, settings.link), {.question_end = "\n",
                                                     .answer_end = "\n",
                                                     .within = settings.link.timeout.value_or(kRelayAnswerWithin),
                                                     .is_only_instrument = true}) {}

  Result<RelayPosition> read() override {
    exchange_.end_rest();
    auto answer = exchange_.query(texts_.ask);
    exchange_.rest_before_next(after_read_);
    if (!answer) return failure(answer.error().kind, "relay", answer.error().what);
    if (answer->ends_with('\r')) answer->pop_back();
    if (*answer == texts_.is_open) return RelayPosition::open;
    if (*answer == texts_.is_closed) return RelayPosition::closed;
    return failure(FaultKind::mismatch, "relay",
                   fmt::format("answers \"{}\", expected \"{}\" (open) or \"{}\" (closed)", *answer, texts_.is_open,
                               texts_.is_closed));
  }

  Result<void> command(RelayPosition position) override {
    exchange_.end_rest();
    auto sent = exchange_.send(position == RelayPosition::open ? texts_.tell_open : texts_.tell_close);
    exchange_.rest_before_next(after_write_);
    if (!sent) return failure(sent.error().kind, "relay", sent.error().what);
    return {};
  }

 private:
  static std::unique_ptr<ByteStream> open_stream(const Line& line, const LinkSettings& link) {
    auto stream = make_stream(line, {}, kConnectRelayWithin);
    return link.echo.value_or(false) ? make_echo_stream(std::move(stream)) : std::move(stream);
  }

  RelayTexts texts_;
  Duration after_write_, after_read_;
  TextExchange exchange_;
};

void read_modbus_relay(const TomlTable& table, RelaySettings& settings) {
  const std::int64_t most = settings.kind == RelayKind::coil ? 1 : 0xFFFF;
  if (settings.kind == RelayKind::coil)
    settings.address = whole<std::uint16_t>(table, "coil", 0, 0xFFFF);
  else
    settings.address = whole<std::uint16_t>(table, "register", 0, 0xFFFF);
  settings.open_value = whole<std::uint16_t>(table, "open", 0, most, 0);
  settings.closed_value = whole<std::uint16_t>(table, "closed", 0, most, 1);
  if (settings.open_value == settings.closed_value)
    table.note_error("open", "the values of both positions are equal, expected different ones");
  settings.is_rtu_over_tcp = table.choice("framing", {"default", kRtuOverTcp}, "default") == kRtuOverTcp;
}

void read_text_relay(const TomlTable& table, RelayTexts& texts) {
  texts = {.tell_open = table.text("tell_open"),
           .tell_close = table.text("tell_close"),
           .ask = table.text("ask"),
           .is_open = table.text("is_open"),
           .is_closed = table.text("is_closed")};
  if (texts.is_open == texts.is_closed && table.has("is_open"))
    table.note_error("is_open", "the answers of both positions are equal, expected different ones");
}

/// Refuses settings that the relay's link does not have.
void check_link(const TomlTable& table, const std::optional<Line>& line, const RelaySettings& settings) {
  ModbusLink modbus;
  if ((line && std::holds_alternative<SerialLine>(*line)) || settings.is_rtu_over_tcp)
    modbus.framing = ModbusLink::Framing::rtu;
  const bool is_text = settings.kind == RelayKind::text;
  const auto fits = is_text ? check_text_settings(settings.link) : check_framing(modbus, settings.link);
  if (!fits) table.note_error(fits.error().where.c_str(), fits.error().what);
  for (const auto& [key, pause] :
       {std::pair("after_write", settings.link.after_write), std::pair("after_read", settings.link.after_read)})
    if (pause.value_or(Duration{}) > kLongestRelayPause)
      table.note_error(key, "is longer than 0.5 s; a relay is read back in two seconds");
  if (is_text && settings.link.unit) table.note_error("unit", "a relay with text commands has no unit number");
}

}  // namespace

RelaySettings read_relay_settings(const TomlTable& table) {
  RelaySettings settings{.line = table.text("line")};
  const auto line = parse_line(settings.line);
  if (!settings.line.empty() && !line) table.note_error("line", line.error().what);
  if (line && !is_byte_line(*line)) table.note_error("line", "expected a tcp:// or serial: line");
  const int kinds = int{table.has("coil")} + int{table.has("register")} + int{table.has("ask")};
  if (kinds != 1) table.note_error("", "expected one of coil, register and ask: how the relay is read");
  settings.kind = table.has("coil")       ? RelayKind::coil
                  : table.has("register") ? RelayKind::one_register
                                          : RelayKind::text;
  if (settings.kind == RelayKind::text)
    read_text_relay(table, settings.texts);
  else
    read_modbus_relay(table, settings);
  const auto link = table.table("link");
  settings.link = read_link_settings(link);
  check_link(link, line ? std::optional(*line) : std::nullopt, settings);
  settings.after = table.duration("after", settings.after);
  if (settings.after < kShortestAfter || settings.after > kLongestAfter)
    table.note_error("after", "\"after\" is out of range, expected 2 s to 10 min");
  return settings;
}

std::string to_toml(const RelaySettings& settings) {
  auto text = fmt::format("{{ line = {}, after = \"{} s\", link = {}", toml_quoted(settings.line),
                          to_seconds(settings.after), to_toml(settings.link));
  if (settings.kind == RelayKind::text) {
    const auto& texts = settings.texts;
    text += fmt::format(", tell_open = {}, tell_close = {}, ask = {}, is_open = {}, is_closed = {}",
                        toml_quoted(texts.tell_open), toml_quoted(texts.tell_close), toml_quoted(texts.ask),
                        toml_quoted(texts.is_open), toml_quoted(texts.is_closed));
  } else {
    text += fmt::format(", {} = {}, open = {}, closed = {}, framing = \"{}\"",
                        settings.kind == RelayKind::coil ? "coil" : "register", settings.address, settings.open_value,
                        settings.closed_value, settings.is_rtu_over_tcp ? kRtuOverTcp : "default");
  }
  return text + " }";
}

std::string describe(const RelaySettings& settings) {
  const auto what = settings.kind == RelayKind::text   ? std::string("the relay at ")
                    : settings.kind == RelayKind::coil ? fmt::format("coil {} of ", settings.address)
                                                       : fmt::format("register {} of ", settings.address);
  return fmt::format("{}{}, opened after {}", what, settings.line, format_duration(settings.after));
}

std::unique_ptr<SafetyRelay> make_safety_relay(const RelaySettings& settings) {
  const auto line = parse_line(settings.line).value();
  if (settings.kind == RelayKind::text) return std::make_unique<TextRelay>(line, settings);
  return std::make_unique<ModbusRelay>(line, settings);
}

Result<void> switch_relay(SafetyRelay& relay, RelayPosition position, const std::function<void(Duration)>& wait) {
  Result<void> commanded = relay.command(position);
  Result<RelayPosition> shown = relay.read();
  const Deadline end(kSwitchRelayWithin);
  for (int i = 1; i < kRelayReadings && (i == 1 || !end.has_passed()) && !(shown && *shown == position); ++i) {
    wait(kRelayPause);
    if (!commanded) commanded = relay.command(position);
    shown = relay.read();
  }
  if (!shown) return failure(shown.error());
  if (*shown == position) return {};
  return failure(FaultKind::mismatch, "relay",
                 fmt::format("was commanded to be {} and reads {}{}", name(position), name(*shown),
                             commanded ? ": it sticks" : "; " + text(commanded.error())));
}

}  // namespace gyrotherm::drivers
