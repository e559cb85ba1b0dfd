// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/text_file_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <regex>
#include <utility>

#include "core/text.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/link_settings.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::size_t kLongestExpression = 200;

constexpr auto kEncodings = make_vocabulary<TextEncoding::ascii, TextEncoding::latin1>("ascii", "latin1");
constexpr auto kChecksums =
    make_vocabulary<FrameChecksum::none, FrameChecksum::sum>("none", "xor", "negated_sum", "sum");

char read_control_character(const TomlTable& table, const char* key, int fallback) {
  return static_cast<char>(whole<int>(table, key, 0, 127, fallback));
}

TextFrame read_frame(const TomlTable& table) {
  TextFrame frame;
  frame.begin = read_control_character(table, "begin", frame.begin);
  frame.end = read_control_character(table, "end", frame.end);
  frame.high_bit = table.boolean("high_bit", false);
  frame.checksum = one_of(kChecksums, table, "checksum", "none");
  if (auto what = describe_ambiguity(frame); !what.empty())
    table.note_error("end", fmt::format("{}; expected another byte", what));
  return frame;
}

/// Describes the slip if a terminator is spelt with letters, such as "CR", or with an escaped backslash. Returns an
/// empty text for any other terminator.
std::string describe_spelt_terminator(const std::string& end) {
  static const std::map<std::string, std::string> written{{"CR", "\\r"},      {"LF", "\\n"},      {"NL", "\\n"},
                                                          {"CRLF", "\\r\\n"}, {"LFCR", "\\n\\r"}, {"TAB", "\\t"},
                                                          {"NUL", "\\u0000"}, {"ETX", "\\u0003"}, {"EOT", "\\u0004"},
                                                          {"\\r", "\\r"},     {"\\n", "\\n"},     {"\\r\\n", "\\r\\n"}};
  static constexpr std::array kNumbers{"", "one letter", "two letters", "three letters", "four letters"};
  std::string name;
  bool is_spelt = !end.empty();
  for (const char c : end) {
    const bool is_letter = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    const bool separates = c == ' ' || c == '+' || c == '-' || c == '<' || c == '>';
    is_spelt = is_spelt && (is_letter || separates);
    if (is_letter) name += static_cast<char>(c >= 'a' ? c - 'a' + 'A' : c);
  }
  if (name.empty()) is_spelt = false;
  const auto known = written.find(is_spelt ? name : end);
  if (known == written.end() && !is_spelt) return {};
  const auto what = !is_spelt                       ? std::string("a backslash and a letter")
                    : name.size() < kNumbers.size() ? std::string(kNumbers[name.size()])
                                                    : fmt::format("{} letters", name.size());
  if (known != written.end()) return fmt::format("\"{}\" is {}; write \"{}\"", plain(end), what, known->second);
  return fmt::format("\"{}\" is {}, expected the characters that end a line, such as \"\\r\\n\"", plain(end), what);
}

/// Reads the time limit of an answer.
void read_timeout(const TomlTable& table, Duration longest, Duration& timeout) {
  timeout = table.duration("timeout", timeout);
  if (timeout <= Duration{})
    table.note_error("timeout", "expected more than zero");
  else
    check_longest(table, "timeout", timeout, longest);
}

/// Reads the keys that [link] and [link.tcp] or [link.serial] have in common.
void read_wire(const TomlTable& table, const TemplateReader& templates, Duration longest_timeout, TextWire& wire,
               ModbusLink& settings) {
  const auto line_end = [&](const char* key, std::string& target) {
    if (!table.has(key)) return;
    target = table.text(key);
    if (auto slip = describe_spelt_terminator(target); !slip.empty()) table.note_error(key, std::move(slip));
  };
  line_end("question_end", wire.question_end);
  line_end("answer_end", wire.answer_end);
  read_timeout(table, longest_timeout, settings.timeout);
  const auto time = [&](const char* key, Duration longest, Duration& target) {
    target = table.duration(key, target);
    check_longest(table, key, target, longest);
  };
  time("silence", kLongestTextTimeout, wire.silence);
  time("quiet", kLongestTextTimeout, wire.quiet);
  time("after_read", kMaxPause, wire.after_read);
  time("after_write", kMaxPause, wire.after_write);
  settings.unit = whole<std::uint8_t>(table, "address", 0, 255, settings.unit);
  constexpr std::int64_t kLongest = 65536;
  wire.longest_answer =
      whole<std::size_t>(table, "longest_answer", 8, kLongest, static_cast<std::int64_t>(wire.longest_answer));
  if (table.has("prefix")) wire.prefix = templates.read(table, "prefix", table.text("prefix"));
  wire.answers_have_prefix = table.boolean("answers_have_prefix", wire.answers_have_prefix);
  if (table.has("frame")) wire.frame = read_frame(table.table("frame"));
}

bool is_number(const std::string& text) {
  double value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

/// Returns whether the text is a regular expression without groups, which a short text cannot keep busy for long.
bool is_expression(const std::string& text) {
  if (text.size() > kLongestExpression || text.find_first_of("()") != std::string::npos) return false;
  try {
    return std::regex(text).mark_count() == 0;
  } catch (const std::regex_error&) {
    return false;
  }
}

}  // namespace

std::string format_parameter(double number) { return fmt::format("{:.10g}", number); }

TextParameters read_text_parameters(const TomlTable& table) {
  TextParameters parameters;
  for (const auto& key : table.keys())
    parameters[key] = table.is_text(key) && !table.is_list(key) ? table.text(key) : format_parameter(table.number(key));
  return parameters;
}

std::vector<std::string> texts_at(const TomlTable& table, const char* key) {
  if (!table.has(key)) return {};
  if (table.is_list(key)) return table.texts(key);
  return {table.text(key)};
}

TemplateReader::TemplateReader(const TomlTable& file, TextEncoding encoding, const TextParameters& parameters)
    : encoding_(encoding) {
  const auto table = file.table("parameter");
  for (const auto& key : table.keys()) {
    const bool is_text = table.is_text(key) && !table.is_list(key);
    auto& value = parameters_[key] = is_text ? table.text(key) : format_parameter(table.number(key));
    const auto other = parameters.find(key);
    if (other == parameters.end()) continue;
    value = other->second;
    if (!is_text && !is_number(value))
      table.note_error(key, fmt::format("the parameter is a number, and is replaced by \"{}\"", value));
  }
}

TemplateReader TemplateReader::with(const std::string& name, const std::string& value) const {
  auto reader = *this;
  reader.parameters_[name] = value;
  return reader;
}

TextTemplate TemplateReader::read(const TomlTable& table, const char* key, const std::string& text) const {
  auto made = TextTemplate::parse(with_parameters(text), encoding_);
  if (made) return std::move(*made);
  table.note_error(key, made.error().what);
  return {};
}

std::vector<TextTemplate> TemplateReader::read_all(const TomlTable& table, const char* key) const {
  std::vector<TextTemplate> all;
  for (const auto& text : texts_at(table, key)) all.push_back(read(table, key, text));
  return all;
}

std::string TemplateReader::read_constant(const TomlTable& table, const char* key, const std::string& text) const {
  const auto made = read(table, key, text);
  if (!made.fields().empty())
    table.note_error(key, fmt::format("the field \"{}\" has no value here, expected a [parameter] of that name",
                                      made.fields().front().name));
  return made.format({});
}

std::string TemplateReader::with_parameters(std::string text) const {
  for (const auto& [name, value] : parameters_) {
    const auto field = "{" + name + ":";
    for (auto begin = text.find(field); begin != std::string::npos; begin = text.find(field, begin + value.size())) {
      const auto end = text.find('}', begin);
      if (end == std::string::npos) break;
      text.replace(begin, end - begin + 1, value);
    }
  }
  return text;
}

void check_answer_ends(const TomlTable& table, const std::vector<TextTemplate>& answers, const RegisterMap& unit) {
  const auto can_be_cut = [](const MapLink& link) { return link.text.answer_end.empty() && !link.text.frame; };
  if (std::ranges::none_of(unit.links, can_be_cut)) return;
  if (std::ranges::any_of(answers, &TextTemplate::ends_with_open_number))
    table.note_error("answer",
                     "without \"answer_end\", an answer must not end with a number without decimals, because a "
                     "lost digit is not noticed");
}

TextEncoding read_text_encoding(const TomlTable& link) { return one_of(kEncodings, link, "encoding", "ascii"); }

void read_text_links(const TomlTable& link, const TemplateReader& templates, Duration longest_timeout,
                     RegisterMap& unit) {
  TextWire common;
  ModbusLink settings;
  settings.read_at_most = kTextReadAtMost;
  settings.write_at_most = kTextReadAtMost;
  read_wire(link, templates, longest_timeout, common, settings);
  const auto check_prefix = [](const TomlTable& table, const TextWire& wire) {
    if (wire.answers_have_prefix && !wire.prefix)
      table.note_error("answers_have_prefix", "the link has no \"prefix\" that the answers could begin with");
  };
  unit.holes = true;
  unit.status_every = whole<int>(link, "status_every", 0, 3600, 1);
  const auto add = [&](LinkKind kind, const TomlTable& own) {
    MapLink made{.kind = kind, .modbus = settings, .text = common};
    made.modbus.framing = kind == LinkKind::text_tcp ? ModbusLink::Framing::tcp : ModbusLink::Framing::rtu;
    read_wire(own, templates, longest_timeout, made.text, made.modbus);
    check_prefix(own.has("answers_have_prefix") ? own : link, made.text);
    if (own.has("port")) made.modbus.port = whole<std::uint16_t>(own, "port", 1, 65535);
    if (own.has("settings")) {
      const auto format = parse_serial_format(own.text("settings"));
      if (format)
        made.modbus.serial = *format;
      else
        own.note_error("settings", format.error().what);
    }
    unit.links.push_back(std::move(made));
  };
  if (link.has("tcp")) add(LinkKind::text_tcp, link.table("tcp"));
  if (link.has("serial")) add(LinkKind::text_serial, link.table("serial"));
  if (unit.links.empty()) link.note_error("", "expected [link.tcp] or [link.serial]");
  if (unit.links.empty()) unit.links.push_back({.kind = LinkKind::text_tcp, .modbus = settings, .text = common});
  const auto usual = link.choice("usual", {"tcp", "serial"}, "tcp");
  if (link.has("usual") && !link.has(usual)) link.note_error("usual", fmt::format("this file has no [link.{}]", usual));
  if (usual == "serial") std::ranges::reverse(unit.links);
  unit.link = unit.links.front();
}

void read_text_refusals(const TomlTable& link, const TemplateReader& templates, TextLink& text) {
  text.refused = templates.read_all(link, "refused");
  const auto table = link.table("refusals");
  for (const auto& key : table.keys()) {
    std::int64_t code = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), code);
    if (error != std::errc{} || end != key.data() + key.size())
      table.note_error(key, fmt::format("\"{}\" is not a whole number", key));
    text.refusals[code] = table.text(key);
  }
}

std::string read_identity_pattern(const TomlTable& identity, const TemplateReader& templates) {
  constexpr const char* kAnyText = ".+";
  auto pattern = templates.with_parameters(identity.text("pattern", kAnyText));
  if (is_expression(pattern)) return pattern;
  identity.note_error("pattern", fmt::format("\"{}\" is not a regular expression without groups", pattern));
  return kAnyText;
}

bool fits_expression(const std::string& expression, const std::string& text) {
  return std::regex_search(text, std::regex(expression));
}

}  // namespace gyrotherm::drivers
