// SPDX-License-Identifier: Apache-2.0
#include "tests/drivers/chamber/hostile_text_unit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;

/// Answers of other instruments, and the protocols that could not distinguish them from their own.
struct Foreign {
  std::string answer;
  std::vector<std::string> own{};
};
const std::vector<Foreign>& foreign_answers() {
  static const std::vector<Foreign> kAll{{"1\xB6\x32\x34.4812", {"simserv"}},
                                         {"A0 023.4 025.0", {"cts", "cts_serial"}},
                                         {"{S0109C4", {"huber"}},
                                         {"23.0,85.0,105.0,-45.0", {"espec"}},
                                         {"OK:TEMP,S23.0", {"espec"}},
                                         {"KEYSIGHT TECHNOLOGIES,34401A,MY44012345,13"},
                                         {"NA:CMD ERR", {"espec"}},
                                         {"ERR_3", {"lauda"}},
                                         {"WATLOW,F4", {"f4t_scpi"}},
                                         {"1;+2.0E+01,+2.1E+01"}};
  return kAll;
}

std::vector<std::byte> to_bytes(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

const char* name(TextFault fault) {
  static constexpr std::array<const char*, kTextFaults> kNames{
      "none",     "lost",         "late",         "late_by_one", "doubled",    "repeated",    "partial",
      "rest",     "byte_by_byte", "refused",      "foreign",     "wrong_unit", "comma",       "no_number",
      "overlong", "prefixed",     "unterminated", "closed",      "noise",      "two_answers", "flipped"};
  return kNames.at(static_cast<std::size_t>(fault));
}

/// A triangle between 5 and 35 °C. Rising values have even tenths, falling ones odd tenths.
double TextTruth::next_air() {
  constexpr long kHalf = 150;
  const long step = questions++ % (2 * kHalf);
  const long tenths = step < kHalf ? 50 + 2 * step : 51 + 2 * (2 * kHalf - step);
  air_c = static_cast<double>(tenths) / 10;
  sent_air_c.push_back(air_c);
  return air_c;
}

void TextTruth::scan(std::size_t count) {
  inputs_c.clear();
  const double first = next_air();
  for (std::size_t i = 0; i < count; ++i) inputs_c.push_back(first + 40.0 * static_cast<double>(i));
}

HostileTextUnit::HostileTextUnit(const TextProtocol& protocol, tests::SimulatedLine& line, Times times, unsigned seed)
    : protocol_(protocol), line_(line), times_(times), chance_(seed) {
  line_.heard = [this](std::span<const std::byte> bytes) { hear(bytes); };
}

void HostileTextUnit::hear(std::span<const std::byte> bytes) {
  std::string line(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (protocol_.unframe) {
    line = protocol_.unframe(line);
  } else {
    ASSERT_TRUE(line.ends_with(protocol_.question_end)) << protocol_.name << ": " << line;
    line.resize(line.size() - protocol_.question_end.size());
  }
  const bool has_fault = chance_.below(100) < percent;
  const auto fault = has_fault ? static_cast<TextFault>(1 + chance_.below(kTextFaults - 1)) : TextFault::none;
  if (fault == TextFault::refused) {
    ++made[static_cast<std::size_t>(fault)];
    if (!protocol_.busy.empty()) send(soon(), encode(protocol_.busy));
    return;  // nothing is carried out
  }
  const auto answer = protocol_.respond(truth, line);
  if (!answer) return;
  ++made[static_cast<std::size_t>(fault)];
  answer_with(fault, *answer);
}

std::string HostileTextUnit::encode(const std::string& text) const {
  return protocol_.frame ? protocol_.frame(text) : text + protocol_.answer_end;
}

void HostileTextUnit::send(Duration after, const std::string& bytes) {
  const auto at = std::max(line_.now() + after + slow_by, last_arrival_);
  last_arrival_ = at;
  line_.arrive(at - line_.now(), to_bytes(bytes));
}

void HostileTextUnit::send_in_pieces(const std::string& bytes, std::size_t cut, Duration gap) {
  const auto at = soon();
  send(at, bytes.substr(0, cut));
  send(at + gap, bytes.substr(cut));
}

void HostileTextUnit::answer_with(TextFault fault, const std::string& text) {
  const auto whole = encode(text);
  const auto cut = whole.size() < 2 ? whole.size() : 1 + chance_.below(whole.size() - 1);
  switch (fault) {
    case TextFault::lost: return;
    case TextFault::late: return send(chance_.between(times_.timeout, 4 * times_.timeout), whole);
    case TextFault::late_by_one: return send(times_.timeout + times_.quiet + soon(), whole);
    case TextFault::doubled: return send(soon(), whole + whole);
    case TextFault::repeated: send(soon(), whole); return send(chance_.between({}, times_.quiet), whole);
    case TextFault::partial: return send(soon(), whole.substr(0, cut));
    case TextFault::partial_then_rest:
      return send_in_pieces(whole, cut, chance_.between(times_.silence, 2 * times_.timeout));
    case TextFault::byte_by_byte: {
      auto at = soon();
      for (const char byte : whole) send(at += milliseconds(2), std::string(1, byte));
      return;
    }
    case TextFault::foreign: {
      const auto& other = foreign_answers()[chance_.below(foreign_answers().size())];
      if (std::ranges::find(other.own, protocol_.name) == other.own.end()) send(soon(), encode(other.answer));
      return;
    }
    case TextFault::wrong_unit: return send(soon(), encode(text + (chance_.one_in(2) ? "F" : " K")));
    case TextFault::comma: {
      auto changed = text;
      std::ranges::replace(changed, '.', ',');
      return send(soon(), encode(changed));
    }
    case TextFault::no_number: {
      constexpr std::array kTexts{"nan", "inf", "-inf", "1e999", "NaN", "----", "", "."};
      return send(soon(), encode(with_number(text, kTexts.at(chance_.below(kTexts.size())), true)));
    }
    case TextFault::overlong: return send(soon(), encode(with_number(text, std::string(300, '9'), false)));
    case TextFault::prefixed: {
      constexpr std::string_view kNoise("x#@;~\x07\xFF\0?", 9);
      return send(soon(), std::string(1, kNoise[chance_.below(kNoise.size())]) + whole);
    }
    case TextFault::unterminated: return send(soon(), protocol_.frame ? whole.substr(0, whole.size() - 1) : text);
    case TextFault::closed:
      line_.lose_pending();
      line_.disconnect();
      last_arrival_ = {};
      return;
    case TextFault::noise: send(soon(), noise()); return send(soon(), whole);
    case TextFault::two_answers: {
      auto other = truth;
      const auto more = encode(protocol_.respond(other, protocol_.other_question).value_or(text));
      return send(soon(), chance_.one_in(2) ? whole + more : more + whole);
    }
    case TextFault::flipped: return send(soon(), flip(whole));
    default: return send(soon(), whole);
  }
}

/// Returns the answer with `number` in the place of one of its numbers, or in front of its digits.
std::string HostileTextUnit::with_number(const std::string& text, const std::string& number, bool replaces) {
  constexpr std::string_view kNumber = "+-.0123456789", kDigits = "0123456789";
  std::vector<std::pair<std::size_t, std::size_t>> found;
  for (auto at = text.find_first_of(kDigits); at != std::string::npos; at = text.find_first_of(kDigits, at)) {
    const auto before = text.find_last_not_of(kNumber, at);
    const auto begin = before == std::string::npos ? 0 : before + 1;
    const auto end = std::min(text.find_first_not_of(kNumber, at), text.size());
    found.emplace_back(begin, end);
    at = end;
  }
  if (found.empty()) return text + number;
  const auto [begin, end] = found[chance_.below(found.size())];
  return text.substr(0, begin) + number + (replaces ? "" : text.substr(begin, end - begin)) + text.substr(end);
}

std::string HostileTextUnit::noise() {
  std::string bytes(1024 + chance_.below(4096), '\0');
  for (auto& byte : bytes) byte = static_cast<char>(chance_.byte());
  return bytes;
}

/// Flips one bit of a frame, which its checksum shows, or otherwise bit 7 of a byte, which no answer has.
std::string HostileTextUnit::flip(std::string bytes) {
  const auto at = chance_.below(bytes.size());
  bytes[at] = static_cast<char>(bytes[at] ^ (protocol_.frame ? 1 << chance_.below(8) : 0x80));
  return bytes;
}

}  // namespace gyrotherm::drivers
