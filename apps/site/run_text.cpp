// SPDX-License-Identifier: Apache-2.0
#include "apps/site/run_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "acquisition/record/row.hpp"
#include "acquisition/record/status.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/text.hpp"

namespace gyrotherm::site {
namespace {

constexpr std::array kDocumentKinds{"calibration", "model", "report"};
constexpr std::size_t kMaxDocumentBytes = 32'000'000;

template <class Words>
std::vector<std::string> list_keywords(const Words& values) {
  std::vector<std::string> words;
  for (const auto value : values) words.emplace_back(name(value));
  return words;
}

/// Describes a column that every record has.
StoredChannel common_channel(std::string_view column) {
  StoredChannel channel{.name = std::string(column)};
  if (column.ends_with("_ns")) channel.unit = "ns";
  if (column.ends_with("_c")) channel.unit = "°C";
  channel.measures = column.starts_with("chamber") ? "chamber" : "program";
  if (column == "phase") channel.keywords = list_keywords(kPhases);
  if (column == "state") channel.keywords = list_keywords(kRunStates);
  return channel;
}

StoredChannel unit_channel(const record::ChannelColumn& column, const record::RunInfo& info) {
  StoredChannel channel{.name = column.name, .measures = record::name(column.measures)};
  if (column.measures == record::Measures::temperature) {
    channel.thermometer = &info.thermometers[column.index];
    channel.unit = channel.thermometer->unit;
    channel.unit_under_test = channel.thermometer->unit_under_test;
    return channel;
  }
  if (is_of_chamber(column.measures)) {
    channel.unit = column.measures == record::Measures::humidity ? "%" : "°C";
    return channel;
  }
  const auto& unit = info.units[column.unit];
  channel.unit_under_test = unit.name;
  switch (column.measures) {
    case record::Measures::rotation:
      channel.unit = unit.axes[column.index].kind == record::GyroKind::pulse_count ? "pulses" : "";
      break;
    case record::Measures::interval: channel.unit = "ns"; break;
    case record::Measures::value: channel.unit = unit.values[column.index].unit; break;
    case record::Measures::true_bias: channel.unit = "°/h"; break;
    case record::Measures::humidity:
    case record::Measures::dew_point:
    case record::Measures::temperature: break;
  }
  return channel;
}

Json day_or_empty(const std::optional<std::chrono::sys_days>& day) {
  return day ? Json(record::format_day(*day)) : Json("");
}

Json calibration_as_json(const record::Channel& thermometer) {
  Json calibration{{"instrument", thermometer.instrument},
                   {"offset_k", thermometer.offset.value},
                   {"polynomial", thermometer.polynomial},
                   {"certificate", thermometer.certificate},
                   {"calibrated", day_or_empty(thermometer.uncertainty.calibrated)},
                   {"due", day_or_empty(thermometer.due)}};
  if (const auto u = thermometer.uncertainty.calibration) calibration["standard_uncertainty_k"] = u->value;
  if (const auto drift = thermometer.uncertainty.drift_in_a_year) calibration["drift_k_per_year"] = drift->value;
  return calibration;
}

Json channel_as_json(const StoredChannel& channel) {
  Json json{{"name", channel.name},
            {"unit", channel.unit},
            {"measures", channel.measures},
            {"unit_under_test", channel.unit_under_test}};
  if (!channel.keywords.empty()) json["words"] = channel.keywords;
  if (channel.thermometer != nullptr) json["calibration"] = calibration_as_json(*channel.thermometer);
  return json;
}

Json unit_as_json(const record::UnitInfo& unit) {
  Json axes = Json::array();
  for (const auto& axis : unit.axes) {
    const bool counts = axis.kind == record::GyroKind::pulse_count;
    Json one{{"name", axis.name}, {counts ? "arcsec_per_pulse" : "deg_per_h_per_number", axis.scale}};
    if (axis.earth_rate) one["earth_rate_deg_per_h"] = axis.earth_rate->value;
    axes.push_back(std::move(one));
  }
  return {{"label", unit.name}, {"serial_number", unit.serial_number}, {"model", unit.model}, {"axes", axes}};
}

Json make_segments_json(const record::RunInfo& info) {
  Json segments = Json::array();
  for (const auto& segment : info.segments)
    segments.push_back({{"name", segment.name},
                        {"hold", segment.hold},
                        {"target_c", segment.target.value},
                        {"rate_c_per_min", segment.rate.value},
                        {"cycle", segment.cycle}});
  return segments;
}

void append_cell(std::string& text, const record::Statement& row, int column, const StoredChannel& channel) {
  if (row.null(column)) {
    text += "NULL";
  } else if (!channel.keywords.empty()) {
    const auto word = row.text(column);
    const auto found = std::ranges::find(channel.keywords, word);
    if (found == channel.keywords.end())
      text += "NULL";
    else
      fmt::format_to(std::back_inserter(text), "{}", found - channel.keywords.begin());
  } else if (const auto cell = row.cell(column); const auto* whole = std::get_if<std::int64_t>(&cell)) {
    fmt::format_to(std::back_inserter(text), "{}", *whole);
  } else {
    fmt::format_to(std::back_inserter(text), "{}", row.real(column));
  }
}

Json text_or_null(const record::Statement& row, int column) {
  return row.null(column) ? Json() : Json(std::string(row.text(column)));
}

/// Returns the UTC of the last sample, or `start` if there is none. The last file may have only events.
Result<std::int64_t> read_last_utc(const record::RecordFiles& files, Duration start) {
  auto utc_ns = start.count();
  // SQLite takes the other columns from the row with the maximum.
  return record::each_row(files, {.what = "max(slot), utc_ns", .order = "1"},
                          [&](const record::Statement& row) {
                            if (!row.null(1)) utc_ns = row.integer(1);
                            return true;
                          })
      .map([&] { return utc_ns; });
}

/// Returns the sum of the row counts of all files.
Result<std::int64_t> count_rows(const record::RecordFiles& files, const char* table, const char* key) {
  std::int64_t sum = 0;
  return record::each_row(files, {.what = "count(*)", .table = table, .key = key, .order = "1", .first = -1},
                          [&](const record::Statement& row) {
                            sum += row.integer(0);
                            return true;
                          })
      .map([&] { return sum; });
}

}  // namespace

std::vector<StoredChannel> stored_channels(const record::RunInfo& info) {
  const auto own = record::channel_columns(info);
  std::vector<StoredChannel> channels;
  record::SampleColumns(info).each([&](std::string_view column, std::string_view) {
    if (column == "slot" || column == "utc_ns") return;
    const auto found = std::ranges::find(own, column, &record::ChannelColumn::name);
    if (found == own.end()) return channels.push_back(common_channel(column));
    if (found->measures != record::Measures::true_bias || info.virtual_rig)
      channels.push_back(unit_channel(*found, info));
  });
  return channels;
}

std::string run_as_json(const record::RunInfo& info) {
  Json channels = Json::array();
  for (const auto& channel : stored_channels(info)) channels.push_back(channel_as_json(channel));
  Json units = Json::array();
  for (const auto& unit : info.units) units.push_back(unit_as_json(unit));
  Json json{{"started_ns", info.started_utc.count()},
            {"profile", info.profile_name},
            {"simulated", record::is_simulated(info)},
            {"imported", info.imported},
            {"program_version", info.program_version},
            {"rig_file", info.rig_name},
            {"profile_text", info.profile_text},
            {"rig_text", info.rig_text},
            {"seed", info.seed},
            {"days_later", info.days_later},
            {"chamber", info.chamber_instrument},
            {"cycles", info.cycles},
            {"segments", make_segments_json(info)},
            {"units", units},
            {"channels", channels}};
  // Only a run with an order has the key: the text of every other run is as in versions without orders.
  if (!info.order_number.empty()) json["order_number"] = info.order_number;
  return json_text(json);
}

std::string segments_as_json(const record::RunInfo& info) { return json_text(make_segments_json(info)); }

Result<RowBatch> read_rows(const record::RecordFiles& files, const std::vector<StoredChannel>& channels,
                           std::int64_t after, std::int64_t most) {
  std::string what = "slot, utc_ns";
  for (const auto& channel : channels) what += fmt::format(", \"{}\"", channel.name);
  RowBatch batch{.after = after, .last = after};
  const auto add = [&](const record::Statement& row) {
    const char* comma = batch.rows == 0 ? "" : ",";
    batch.last = row.integer(0);
    fmt::format_to(std::back_inserter(batch.slots), "{}{}", comma, batch.last);
    if (row.null(1))
      fmt::format_to(std::back_inserter(batch.utcs), "{}NULL", comma);
    else
      fmt::format_to(std::back_inserter(batch.utcs), "{}{}", comma, row.integer(1));
    fmt::format_to(std::back_inserter(batch.numbers), "{}\"{{", comma);
    for (std::size_t i = 0; i < channels.size(); ++i) {
      if (i > 0) batch.numbers += ',';
      append_cell(batch.numbers, row, static_cast<int>(i) + 2, channels[i]);
    }
    batch.numbers += "}\"";
    ++batch.rows;
    return true;
  };
  const auto read = record::each_row(files, {.what = what, .first = after + 1, .most = most}, add);
  if (!read) return failure(read.error());
  for (auto* text : {&batch.slots, &batch.utcs, &batch.numbers}) *text += '}';
  return batch;
}

Result<JsonBatch> read_events(const record::RecordFiles& files, std::int64_t after) {
  JsonBatch batch{.last = after};
  Json events = Json::array();
  const record::RowQuery query{.what = "id, slot, utc_ns, kind, interlock, reaction, segment, channel, text",
                               .table = fmt::format("(SELECT * FROM event WHERE id > {})", after),
                               .order = "id",
                               .first = -1,
                               .most = kBatchRows};
  const auto read = record::each_row(files, query, [&](const record::Statement& row) {
    events.push_back({{"number", row.integer(0)},
                      {"slot", row.integer(1)},
                      {"utc_ns", row.integer(2)},
                      {"kind", std::string(row.text(3))},
                      {"interlock", text_or_null(row, 4)},
                      {"reaction", text_or_null(row, 5)},
                      {"segment", row.null(6) ? Json() : Json(row.integer(6))},
                      {"channel", text_or_null(row, 7)},
                      {"text", plain(row.text(8))}});
    batch.last = row.integer(0);
    ++batch.rows;
    return true;
  });
  if (!read) return failure(read.error());
  if (batch.rows > 0) batch.text = json_text(events);
  return batch;
}

Result<JsonBatch> read_gaps(const record::RecordFiles& files, std::int64_t after) {
  JsonBatch batch{.last = after};
  Json gaps = Json::array();
  const record::RowQuery query{.what = "first, last, cause",
                               .table = "gap",
                               .key = "first",
                               .order = "first",
                               .first = after + 1,
                               .most = kBatchRows};
  const auto read = record::each_row(files, query, [&](const record::Statement& row) {
    gaps.push_back({{"first", row.integer(0)}, {"last", row.integer(1)}, {"cause", plain(row.text(2))}});
    batch.last = row.integer(0);
    ++batch.rows;
    return true;
  });
  if (!read) return failure(read.error());
  if (batch.rows > 0) batch.text = json_text(gaps);
  return batch;
}

std::string alarms_as_json(const std::vector<record::Alarm>& alarms) {
  Json list = Json::array();
  for (auto alarm : alarms) {
    for (auto* text : {&alarm.text, &alarm.subject, &alarm.comment, &alarm.acknowledged_by}) *text = plain(*text);
    list.push_back(make_json(alarm));
  }
  return json_text(list);
}

Result<RunEnd> read_end(const record::RunInfo& info, const record::RecordFiles& files) {
  const auto status = record::read_status(files);
  if (!status) return failure(status.error());
  if (status->being_written) return failure(FaultKind::storage, files.path, record::kBeingWritten);
  RunEnd end{.finished = status->finished,
             .state = name(status->overview.state),
             .cause = status->ended_by,
             .alarms = alarms_as_json(status->alarms)};
  auto database = record::open_source(files.parts.back());
  if (!database) return failure(database.error());
  const auto read =
      record::assign_result(end.chain_head, database->query_text("SELECT head FROM frames ORDER BY id DESC LIMIT 1"))
          .and_then([&] { return record::assign_result(end.ended_ns, read_last_utc(files, info.started_utc)); })
          .and_then([&] { return record::assign_result(end.rows, count_rows(files, "sample", "slot")); })
          .and_then([&] { return record::assign_result(end.events, count_rows(files, "event", "slot")); })
          .and_then([&] { return record::assign_result(end.gaps, count_rows(files, "gap", "first")); });
  return read.map([&] { return end; });
}

std::string end_as_json(const RunEnd& end, const std::vector<RunFileDigest>& files) {
  Json list = Json::array();
  for (const auto& file : files) list.push_back({{"name", file.name}, {"sha256", file.sha256}, {"bytes", file.bytes}});
  return json_text({{"state", end.state},
                    {"cause", end.cause},
                    {"alarms", Json::parse(end.alarms)},
                    {"ended_ns", end.ended_ns},
                    {"rows", end.rows},
                    {"events", end.events},
                    {"gaps", end.gaps},
                    {"chain_head", end.chain_head},
                    {"files", list}});
}

Result<std::optional<Document>> read_document(const std::string& path) {
  auto text = read_text_file(path, kMaxDocumentBytes);
  if (!text) return failure(text.error());
  constexpr bool kNoExceptions = false;
  const auto json = Json::parse(*text, nullptr, kNoExceptions);
  if (!json.is_object() || !json.contains("schema") || !json["schema"].is_string() || !is_utf8(*text))
    return std::nullopt;
  const auto schema = json["schema"].get<std::string>();
  for (const std::string kind : kDocumentKinds)
    if (schema.starts_with("gyrotherm-" + kind + "/"))
      return Document{.kind = kind, .name = std::filesystem::path(path).filename().string(), .text = std::move(*text)};
  return std::nullopt;
}

}  // namespace gyrotherm::site
