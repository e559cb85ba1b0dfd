// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/start_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "core/deadline.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::size_t kAnswerChunk = 4096;
constexpr std::size_t kMostShown = 48;  // bytes of an answer in messages
constexpr std::size_t kMostCommandBytes = 255;

std::string to_hexadecimal(std::string_view bytes) {
  std::string text;
  for (const char byte : bytes)
    text += fmt::format("{}{:02X}", text.empty() ? "" : " ", static_cast<unsigned char>(byte));
  return text;
}

/// Returns a part of the exchange as it is shown in messages.
std::string show(const GyroCommand& command, const std::string& part) {
  return command.is_binary ? to_hexadecimal(part) : first_line(part);
}

std::vector<std::uint32_t> read_messages(const TomlTable& table, const FrameFormat& format) {
  std::vector<std::uint32_t> ids;
  for (const double number : table.numbers("message")) {
    const auto id = static_cast<std::uint32_t>(std::clamp(number, 0.0, 4294967295.0));
    const bool is_listed = std::ranges::any_of(format.variants, [&](const auto& one) { return one.id == id; });
    if (!is_listed || static_cast<double>(id) != number)
      table.note_error("message", fmt::format("no message has the id {}", number));
    ids.push_back(id);
  }
  return ids;
}

/// Searches for a required answer in all bytes received since the command was sent.
class AnswerSearch {
 public:
  AnswerSearch(const GyroCommand& command, const FrameFormat& format) : command_(command), decoder_(format) {
    if (!command.reply.empty()) reply_in_command_ = command.send.find(command.reply);
    if (!command.refusal.empty()) refusal_in_command_ = command.send.find(command.refusal);
  }

  /// Adds received bytes. Returns nothing until the answer is complete.
  [[nodiscard]] std::optional<Result<void>> add(std::span<const std::byte> bytes) {
    received_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (!command_.refusal.empty())
      if (const auto at = find(command_.refusal, refusal_in_command_); at != std::string::npos)
        return failure(FaultKind::refused, "",
                       fmt::format("refusal \"{}\" received after \"{}\"",
                                   show(command_, received_.substr(at, most_shown())), command_name(command_)));
    if (!command_.reply.empty() && find(command_.reply, reply_in_command_) != std::string::npos) return Result<void>();
    if (command_.messages.empty()) return std::nullopt;
    decoder_.feed(bytes);
    while (const auto* frame = decoder_.take())
      if (frame->id && std::ranges::count(command_.messages, *frame->id) > 0) return check_settings();
    return std::nullopt;
  }

  /// Returns whether the reply was received, but after a byte that also begins an echo of the command. That byte may be
  /// the last of a frame instead: one frame in 256 ends in it.
  [[nodiscard]] bool has_echoed_reply() const {
    return !command_.reply.empty() && find(command_.reply, std::string::npos) != std::string::npos;
  }

  /// Returns a description of the received bytes, for a fault without the required answer. Empty if there are none.
  [[nodiscard]] std::string describe_received() const {
    if (received_.empty()) return {};
    if (command_.is_binary)
      return fmt::format("; received {} bytes: {}", received_.size(),
                         to_hexadecimal(std::string_view(received_).substr(0, most_shown())));
    const auto is_text = [](char letter) {
      return std::isprint(static_cast<unsigned char>(letter)) != 0 || letter == '\r' || letter == '\n';
    };
    if (std::ranges::all_of(received_, is_text))
      return fmt::format("; received \"{}\"", first_line(received_.substr(0, kMostShown)));
    return fmt::format("; received {} bytes of frames or noise", received_.size());
  }

 private:
  /// Returns the number of received bytes that fit in a message.
  [[nodiscard]] std::size_t most_shown() const { return command_.is_binary ? kMostShown / 2 : kMostShown; }

  /// Returns the position of `text` in the received bytes, or npos. `in_command` is the position of `text` in the
  /// command. A match inside an echo of the command is skipped, unless `in_command` is 0. If a command of text has a
  /// `text` that ends in a digit, a match followed by another digit is skipped.
  [[nodiscard]] std::size_t find(const std::string& text, std::size_t in_command) const {
    for (auto at = received_.find(text); at != std::string::npos; at = received_.find(text, at + 1)) {
      const bool is_echo = in_command != 0 && in_command != std::string::npos && at >= in_command &&
                           received_.compare(at - in_command, in_command, command_.send, 0, in_command) == 0;
      const auto end = at + text.size();
      const bool number_continues = !command_.is_binary && end < received_.size() &&
                                    std::isdigit(static_cast<unsigned char>(text.back())) != 0 &&
                                    std::isdigit(static_cast<unsigned char>(received_[end])) != 0;
      if (!is_echo && !number_continues) return at;
    }
    return std::string::npos;
  }

  [[nodiscard]] Result<void> check_settings() const {
    const auto differ = decoder_.differing_settings();
    if (!differ || differ->empty()) return {};
    return failure(FaultKind::mismatch, "", fmt::format("{}", fmt::join(*differ, "; ")));
  }

  const GyroCommand& command_;
  FrameDecoder decoder_;
  std::size_t reply_in_command_ = std::string::npos, refusal_in_command_ = std::string::npos;
  std::string received_;
};

std::string required_answer(const GyroCommand& command) {
  if (!command.reply.empty())
    return fmt::format("reply \"{}\"", command.is_binary ? to_hexadecimal(command.reply) : command.reply);
  std::string ids;
  for (const auto id : command.messages) ids += fmt::format("{}{:#x}", ids.empty() ? "" : " or ", id);
  return "message " + ids;
}

/// Sends a command and searches the bytes that follow. Returns nothing if no answer arrives within the command's wait.
std::optional<Result<void>> search_answer(const GyroCommand& command, AnswerSearch& search, ByteStream& line,
                                          Duration within, const Clock* clock) {
  if (auto sent = line.write(std::as_bytes(std::span(command.send)), within); !sent) return sent;
  std::array<std::byte, kAnswerChunk> chunk;
  for (const Deadline deadline(command.wait, clock); !deadline.has_passed();) {
    const auto size = line.read(chunk, deadline.left());
    if (!size && size.error().kind == FaultKind::timeout) break;
    if (!size) return failure(size.error());
    if (auto found = search.add(std::span(chunk).first(*size))) return found;
  }
  return std::nullopt;
}

Result<void> missing_answer(const GyroCommand& command, const AnswerSearch& search) {
  const auto waited = std::chrono::duration_cast<std::chrono::milliseconds>(command.wait);
  return failure(FaultKind::timeout, "",
                 fmt::format("no {} to \"{}\" in {} ms{}", required_answer(command), command_name(command),
                             waited.count(), search.describe_received()));
}

std::string read_binary(const TomlTable& table, const char* key) {
  const auto bytes = read_bytes(table, key, kMostCommandBytes);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

GyroCommand read_command(const TomlTable& table, const FrameFormat& format) {
  GyroCommand command;
  command.wait = table.duration("wait", Duration::zero());
  command.is_binary = table.has("send_bytes");
  if (command.is_binary) {
    command.send = read_binary(table, "send_bytes");
    command.reply = read_binary(table, "reply_bytes");
    command.refusal = read_binary(table, "refusal_bytes");
  } else {
    command.send = substitute_rate(table.text("send"), format.rate_hz);
    command.reply = substitute_rate(table.text("reply", ""), format.rate_hz);
    command.refusal = table.text("refusal", "");
  }
  command.messages = read_messages(table, format);
  if (table.has("then")) command.then_silent = table.choice("then", {"silent", "sends"}) == "silent";
  if (command.send.empty())
    table.note_error(command.is_binary ? "send_bytes" : "send", "empty, expected the command to send");
  if (requires_answer(command) && command.wait <= Duration::zero())
    table.note_error("wait", "the time to wait for a reply is zero, expected a positive duration");
  return command;
}

}  // namespace

std::string substitute_rate(std::string text, double rate_hz) {
  constexpr std::string_view kRate = "{rate_hz}";
  for (auto at = text.find(kRate); at != std::string::npos; at = text.find(kRate))
    text.replace(at, kRate.size(), fmt::format("{:g}", rate_hz));
  return text;
}

bool requires_answer(const GyroCommand& command) { return !command.reply.empty() || !command.messages.empty(); }

std::string command_name(const GyroCommand& command) { return show(command, command.send); }

std::string first_line(const std::string& text) { return text.substr(0, text.find_first_of("\r\n")); }

std::vector<GyroCommand> read_commands(const TomlTable& root, const char* key, const FrameFormat& format) {
  std::vector<GyroCommand> commands;
  for (const auto& table : root.tables(key)) commands.push_back(read_command(table, format));
  return commands;
}

Result<void> send_command(const GyroCommand& command, const FrameFormat& format, ByteStream& line, Duration within,
                          const Clock* clock) {
  for (bool is_repeated = false;; is_repeated = true) {
    AnswerSearch search(command, format);
    if (auto found = search_answer(command, search, line, within, clock)) return std::move(*found);
    if (!requires_answer(command)) return {};
    if (is_repeated || !search.has_echoed_reply()) return missing_answer(command, search);
  }
}

IdentityQuery read_identity_query(const TomlTable& table) {
  IdentityQuery query{.send = table.text("send"),
                      .wait = table.duration("wait", Duration::zero()),
                      .begins = table.text("begins"),
                      .ends = table.text("ends", "\r\n")};
  if (query.begins.empty()) table.note_error("begins", "empty, expected the text before the identity");
  if (query.ends.empty()) table.note_error("ends", "empty, expected the text after the identity");
  if (query.wait <= Duration::zero()) table.note_error("wait", "expected a positive duration");
  return query;
}

Result<std::string> query_identity(const IdentityQuery& query, ByteStream& line, Duration within, const Clock* clock) {
  if (auto sent = line.write(std::as_bytes(std::span(query.send)), within); !sent) return failure(sent.error());
  std::string received;
  std::array<std::byte, kAnswerChunk> chunk;
  for (const Deadline deadline(query.wait, clock); !deadline.has_passed();) {
    const auto size = line.read(chunk, deadline.left());
    if (!size && size.error().kind == FaultKind::timeout) break;
    if (!size) return failure(size.error());
    received.append(reinterpret_cast<const char*>(chunk.data()), *size);
    const auto begin = received.find(query.begins);
    if (begin == std::string::npos) continue;
    const auto from = begin + query.begins.size();
    const auto end = received.find(query.ends, from);
    if (end != std::string::npos) return received.substr(from, end - from);
  }
  return std::string();
}

namespace {

constexpr auto kEvidenceKeywords =
    make_vocabulary<SettingEvidence::reply, SettingEvidence::nothing>("reply", "message", "frame", "pace", "nothing");

bool is_answered_command(const std::string& line, const std::vector<GyroCommand>& start) {
  return std::ranges::any_of(start,
                             [&](const GyroCommand& one) { return command_name(one) == line && requires_answer(one); });
}

bool has_settings_message(const FrameFormat& format) {
  return std::ranges::any_of(format.fields, [](const FrameField& field) {
    return std::ranges::any_of(field.rules, [](const auto& rule) { return rule.verdict == StatusMeaning::mismatch; });
  });
}

StreamSetting read_setting(const TomlTable& table, const std::vector<GyroCommand>& start, const FrameFormat& format) {
  StreamSetting setting{.name = table.text("name"),
                        .value = substitute_rate(table.text("value"), format.rate_hz),
                        .affects = table.choice("affects", {"scale", "content", "rate"}),
                        .evidence = one_of(kEvidenceKeywords, table, "verified_by"),
                        .note = table.text("note", "")};
  if (setting.evidence == SettingEvidence::reply) {
    const auto command = substitute_rate(table.text("command"), format.rate_hz);
    if (!is_answered_command(command, start))
      table.note_error("command", fmt::format("no [[start]] command sends \"{}\" and requires an answer", command));
  }
  if (setting.evidence == SettingEvidence::message && !has_settings_message(format))
    table.note_error("verified_by", "no field has a rule with the verdict \"mismatch\"");
  if (setting.evidence == SettingEvidence::pace && format.rate_hz <= 0)
    table.note_error("verified_by", "the frames have no \"rate_hz\"");
  if (setting.evidence == SettingEvidence::nothing && setting.note.empty())
    table.note_error("note", "expected the reason why this setting cannot be verified");
  return setting;
}

}  // namespace

std::vector<StreamSetting> read_settings(const TomlTable& root, const std::vector<GyroCommand>& start,
                                         const FrameFormat& format) {
  std::vector<StreamSetting> settings;
  for (const auto& table : root.tables("setting")) settings.push_back(read_setting(table, start, format));
  return settings;
}

std::string describe(const std::vector<StreamSetting>& settings, bool is_queried) {
  std::string verified, unverified;
  const auto add = [](std::string& list, const std::string& one) { list += (list.empty() ? "" : ", ") + one; };
  for (const auto& [name, value, affects, evidence, note] : settings) {
    const bool needs_command = evidence == SettingEvidence::reply || evidence == SettingEvidence::message;
    if (evidence == SettingEvidence::nothing)
      add(unverified, fmt::format("{}: {} ({})", name, value, note));
    else if (needs_command && !is_queried)
      add(unverified, fmt::format("{}: {} (the gyro was not queried)", name, value));
    else
      add(verified, fmt::format("{}: {}", name, value));
  }
  std::string text;
  if (!verified.empty()) text = "settings verified: " + verified;
  if (!unverified.empty()) text += (text.empty() ? "" : "; ") + ("settings NOT verified: " + unverified);
  return text;
}

}  // namespace gyrotherm::drivers
