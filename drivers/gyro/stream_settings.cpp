// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/stream_settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace gyrotherm::drivers {
namespace {

constexpr auto kEvidence =
    words_in_order<SettingEvidence::reply, SettingEvidence::nothing>("reply", "message", "frame", "pace", "nothing");

bool is_answered_command(const std::string& line, const std::vector<GyroCommand>& start) {
  return std::ranges::any_of(start,
                             [&](const GyroCommand& one) { return first_line(one.send) == line && is_answered(one); });
}

bool has_settings_message(const FrameFormat& format) {
  return std::ranges::any_of(format.fields, [](const FrameField& field) {
    return std::ranges::any_of(field.rules, [](const auto& rule) { return rule.verdict == StatusMeaning::mismatch; });
  });
}

StreamSetting read_setting(const TomlTable& table, const std::vector<GyroCommand>& start, const FrameFormat& format) {
  StreamSetting setting{.name = table.text("name"),
                        .value = with_rate(table.text("value"), format.rate_hz),
                        .affects = table.choice("affects", {"scale", "content", "rate"}),
                        .evidence = one_of(kEvidence, table, "verified_by"),
                        .note = table.text("note", "")};
  if (setting.evidence == SettingEvidence::reply) {
    const auto command = with_rate(table.text("command"), format.rate_hz);
    if (!is_answered_command(command, start))
      table.mistake("command", fmt::format("no [[start]] sends \"{}\" and requires an answer", command));
  }
  if (setting.evidence == SettingEvidence::message && !has_settings_message(format))
    table.mistake("verified_by", "no field has a rule of the verdict \"mismatch\"");
  if (setting.evidence == SettingEvidence::pace && format.rate_hz <= 0)
    table.mistake("verified_by", "the frames have no \"rate_hz\"");
  if (setting.evidence == SettingEvidence::nothing && setting.note.empty())
    table.mistake("note", "expected the reason why nothing shows this setting");
  return setting;
}

}  // namespace

std::vector<StreamSetting> read_settings(const TomlTable& root, const std::vector<GyroCommand>& start,
                                         const FrameFormat& format) {
  std::vector<StreamSetting> settings;
  for (const auto& table : root.tables("setting")) settings.push_back(read_setting(table, start, format));
  return settings;
}

std::string in_words(const std::vector<StreamSetting>& settings, bool is_asked) {
  std::string verified, others;
  const auto add = [](std::string& list, const std::string& one) { list += (list.empty() ? "" : ", ") + one; };
  for (const auto& [name, value, affects, evidence, note] : settings) {
    const bool needs_command = evidence == SettingEvidence::reply || evidence == SettingEvidence::message;
    if (evidence == SettingEvidence::nothing)
      add(others, fmt::format("{}: {} ({})", name, value, note));
    else if (needs_command && !is_asked)
      add(others, fmt::format("{}: {} (the gyro was not asked)", name, value));
    else
      add(verified, fmt::format("{}: {}", name, value));
  }
  std::string text;
  if (!verified.empty()) text = "settings verified: " + verified;
  if (!others.empty()) text += (text.empty() ? "" : "; ") + ("settings NOT verified: " + others);
  return text;
}

}  // namespace gyrotherm::drivers
