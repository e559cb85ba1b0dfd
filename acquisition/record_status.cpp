#include "acquisition/record_status.hpp"

#include <cmath>

#include "acquisition/record_rows.hpp"
#include "acquisition/run_info_rows.hpp"

namespace gyrotherm {
namespace {

std::optional<Celsius> known(double reading_c) {
  return std::isnan(reading_c) ? std::nullopt : std::optional(Celsius{reading_c});
}

}  // namespace

RunStatus first_status(const std::string& path, const RunInfo& info) {
  RunStatus status;
  status.path = path;
  status.id = info.id;
  status.simulated = info.simulated;
  status.segment_count = static_cast<int>(info.segments.size());
  for (const Channel& channel : info.thermometers) status.thermometers.push_back({channel.name, std::nullopt});
  return status;
}

void show_progress(RunStatus& status, const RunInfo& info, const Progress& progress) {
  status.phase = progress.phase;
  status.segment_index = progress.segment;
  const auto segment = static_cast<std::size_t>(progress.segment);
  status.segment = segment < info.segments.size() ? info.segments[segment].name : std::string();
  status.set_point = known(progress.set_point.value);
}

Result<RunStatus> stored_status(Database& database, const std::string& path) {
  const auto info = read_run_info(database);
  if (!info) return failure(info.error());
  RunStatus status = first_status(path, *info);
  const auto finished = is_finished(database);
  if (!finished) return failure(finished.error());
  status.finished = *finished;
  const auto faults = database.ask_integer("SELECT count(*) FROM fault", 0);
  if (!faults) return failure(faults.error());
  status.faults = *faults;
  const auto acknowledged = last_slot(database);
  if (!acknowledged) return failure(acknowledged.error());
  status.acknowledged = *acknowledged;
  const auto row = last_row(database, *info);
  if (!row) return failure(row.error());
  if (!*row) return status;

  status.slot = (*row)->slot;
  show_progress(status, *info, (*row)->progress);
  status.chamber_air = known((*row)->chamber_air_c);
  for (std::size_t i = 0; i < status.thermometers.size(); ++i)
    status.thermometers[i].reading = known((*row)->thermometers_c[i]);
  return status;
}

}  // namespace gyrotherm
