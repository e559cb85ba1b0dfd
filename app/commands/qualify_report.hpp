/// What qualify has made, as a report and as a table for the terminal.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/model/model.hpp"
#include "analysis/model/verification.hpp"
#include "app/recorded_run.hpp"
#include "core/result.hpp"
#include "rig/rig_file.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm {

/// One of the two runs: its plan, its record, and what came of it.
struct QualificationRun {
  std::string stage;  ///< "rate" or "random"
  std::string path;
  Profile profile;
  RecordedRun recorded;
  std::string sha256;  ///< of the record's rows as `export` writes them
};

/// A model of the rate run, and how it does on both.
struct TrainedModel {
  Model model;
  Verification rate, random;
  double training_s{};  ///< wall time
};

struct Qualification {
  const RigFile& rig;
  std::uint64_t seed{};
  const QualificationRun& rate;
  const QualificationRun& random;
  const std::vector<TrainedModel>& models;    ///< three-point, multi-point, multi-point-t
  const std::vector<TrainedModel>& compared;  ///< by other methods
  std::vector<std::string> warnings;          ///< of what could not be compared
};

struct AssembledReport {
  std::string json;
  std::vector<std::string> missed;  ///< limits of the profiles' [accept] tables that a result is beyond
};

/// Asked before anything moves: fails with bad_file if the profile's [accept] table names no figure of the report.
[[nodiscard]] Result<void> check_accept(const Profile& profile, const std::string& file);

/// The profiles' [accept] tables have been checked.
[[nodiscard]] AssembledReport assemble_report(const Qualification& all);

[[nodiscard]] std::string result_table(const Qualification& all);

}  // namespace gyrotherm
