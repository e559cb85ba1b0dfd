#include "acquisition/record/import.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "acquisition/record/foreign_rows.hpp"
#include "acquisition/record/import_map.hpp"
#include "acquisition/record/manifest.hpp"
#include "acquisition/record/run_file.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm {
namespace {

/// FNV-1a, 64 bits (Fowler, Noll, Vo; RFC 9923): the id of an import depends on its input alone.
std::uint64_t fnv1a(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
  return hash;
}

RunInfo describe(const ImportMap& map, std::string_view table, const std::string& table_path,
                 const std::string& program_version) {
  const auto file = plain(std::filesystem::path(table_path).filename().string());
  RunInfo info;
  info.id = fmt::format("{:016x}{:016x}", fnv1a(table), fnv1a(map.text));
  info.program_version = program_version;
  info.profile_name = file;
  info.rig_name = map.name;
  info.rig_text = map.text;
  info.imported = true;
  for (const auto& thermometer : map.thermometers)
    info.thermometers.push_back({.name = thermometer.name, .instrument = "imported from " + file, .offset = {}});
  info.gyro = map.gyro_info;
  info.gradients = map.gradients;
  info.three_point = map.three_point;
  return info;
}

Result<void> insert_silences(RunFile& run, const ForeignRows& rows, const Silences& silences) {
  if (silences.count == 0) return {};
  const Event event{
      {rows.time[silences.first_after], {}},
      EventKind::note,
      fmt::format("{} gaps longer than 10 times the median spacing of {:g} s, {:g} s in all; the first, of "
                  "{:g} s, after row {}",
                  silences.count, to_seconds(silences.median), to_seconds(silences.total), to_seconds(silences.first),
                  silences.first_after)};
  return run.insert_event(static_cast<std::int64_t>(silences.first_after), event);
}

Result<void> insert_rows(RunFile& run, const ForeignRows& rows, const Silences& silences) {
  SampleRow row{.thermometers_c = std::vector<double>(rows.thermometers_c.size())};
  for (std::size_t i = 0; i < rows.gyro.size(); ++i) {
    row.slot = static_cast<std::int64_t>(i);
    row.monotonic = rows.time[i];
    row.interval = rows.interval[i];
    row.gyro = rows.gyro[i];
    for (std::size_t channel = 0; channel < row.thermometers_c.size(); ++channel)
      row.thermometers_c[channel] = rows.thermometers_c[channel][i];
    if (auto inserted = run.insert(row); !inserted) return inserted;
    if (i != silences.first_after) continue;
    if (auto inserted = insert_silences(run, rows, silences); !inserted) return inserted;
  }
  return {};
}

Result<void> write(const std::string& path, const RunInfo& info, const ForeignRows& rows, const Silences& silences) {
  auto run = RunFile::create(path, info);
  if (!run) return failure(run.error());
  auto written = run->begin()
                     .and_then([&] { return insert_rows(*run, rows, silences); })
                     .and_then([&] { return run->replace_frames({}); })
                     .and_then([&] { return run->commit(); })
                     .and_then([&] { return run->finish(); });
  run = failure(FaultKind::storage, path, "closed");
  if (written) written = write_manifest(path, 1);
  if (!written) ::unlink(path.c_str());
  return written;
}

}  // namespace

Result<ImportSummary> import_record(const std::string& table_path, const std::string& map_path,
                                    const std::string& record_path, const std::string& program_version) {
  const auto map = load_import_map(map_path);
  if (!map) return failure(map.error());
  const auto table = read_text_file(table_path, kLargestTable);
  if (!table) return failure(table.error());
  const auto rows = parse_foreign_rows(*table, *map, table_path);
  if (!rows) return failure(rows.error());
  const Silences silences = find_silences(rows->time);
  const RunInfo info = describe(*map, *table, table_path, program_version);
  if (auto written = write(record_path, info, *rows, silences); !written) return failure(written.error());
  return ImportSummary{rows->gyro.size(), rows->time.back(), silences.count};
}

}  // namespace gyrotherm
