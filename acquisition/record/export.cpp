// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/export.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::record {
namespace {

using Buffer = fmt::memory_buffer;

void add(Buffer& out, std::string_view text) { out.append(text); }

/// A text field, in quotes where it needs them.
void add_field(Buffer& out, std::string_view text) {
  if (text.find_first_of(",\"\r\n#") == std::string_view::npos) return add(out, text);
  out.push_back('"');
  for (const char c : text) {
    if (c == '"') out.push_back('"');
    out.push_back(c);
  }
  out.push_back('"');
}

void add_value(Buffer& out, double value) {
  out.push_back(',');
  if (!std::isnan(value)) fmt::format_to(std::back_inserter(out), "{}", value);
}

void add_text(Buffer& out, std::string_view text) {
  out.push_back(',');
  add_field(out, text);
}

/// The text of a comment must stay on its line, and steer no terminal.
std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return plain(text);
}

void add_comments(Buffer& out, const RunInfo& info, bool finished) {
  if (info.simulated) add(out, "# SIMULATED: the instruments were virtual\n");
  fmt::format_to(std::back_inserter(out), "# run {} of {} on {}{}\n", one_line(info.id), one_line(info.profile_name),
                 one_line(info.rig_name), finished ? "" : ", not finished");
}

std::string gyro_column(const GyroInfo& gyro) {
  if (gyro.kind == GyroKind::pulse_count) return fmt::format("gyro [pulses of {:g} arcsec]", gyro.scale);
  return fmt::format("gyro [{:g} °/h]", gyro.scale);
}

void add_header(Buffer& out, const RunInfo& info) {
  add(out, "slot,time [s],set point [°C],chamber air [°C],chamber set point [°C]");
  for (const Channel& channel : info.thermometers) add_text(out, channel.name + " [°C]");
  add_text(out, gyro_column(info.gyro));
  add(out, ",gyro interval [s],segment,cycle,phase\n");
}

std::string_view name_at(const std::vector<std::string>& names, int index) {
  return index >= 0 && static_cast<std::size_t>(index) < names.size() ? std::string_view(names[index]) : "";
}

void add_progress(Buffer& out, const Record& record, const ProfilePosition& progress,
                  const std::vector<std::string>& segments) {
  add_text(out, name_at(segments, progress.segment));
  add_text(out, name_at(record.info.cycles, progress.cycle));
  add_text(out, record.info.imported ? "" : name(progress.phase));
}

void add_row(Buffer& out, const Record& record, std::size_t row, const std::vector<std::string>& segments) {
  fmt::format_to(std::back_inserter(out), "{}", record.slot[row]);
  add_value(out, record.time_s[row]);
  add_value(out, record.set_point_c[row]);
  add_value(out, record.chamber_air_c[row]);
  add_value(out, record.chamber_set_point_c[row]);
  for (const auto& readings_c : record.thermometers_c) add_value(out, readings_c[row]);
  add_value(out, record.gyro[row]);
  add_value(out, record.gyro_interval_s[row]);
  add_progress(out, record, record.progress[row], segments);
  out.push_back('\n');
}

}  // namespace

std::string to_csv(const Record& record) {
  std::vector<std::string> segments;
  for (const auto& segment : record.info.segments) segments.push_back(segment.name);
  Buffer out;
  add_comments(out, record.info, record.finished);
  add_header(out, record.info);
  for (std::size_t row = 0; row < record.slot.size(); ++row) add_row(out, record, row, segments);
  return fmt::to_string(out);
}

Result<void> export_record(const std::string& record_path, const std::string& csv_path) {
  const auto record = read_record(record_path);
  if (!record) return failure(record.error());
  return replace_text_file(csv_path, to_csv(*record));
}

}  // namespace gyrotherm::record
