// SPDX-License-Identifier: Apache-2.0
/// Makes the report of an experiment from its records and what was trained on them.
#pragma once

#include <cstdint>
#include <string>

#include "analysis/data/clusters.hpp"
#include "analysis/model/qualification.hpp"
#include "report/report.hpp"

namespace gyrotherm::report {

/// A record of the experiment, and what it is known by.
struct ReportSourceRun {
  const data::RecordedRun& recorded;
  std::string record_sha256;
  std::string profile_sha256;
};

struct ReportSource {
  ReportedRig rig;
  ReportSourceRun rate, random;
  const model::Qualification& qualification;  ///< of exactly these records; its three models are SVRs
  std::string program_version;
  std::uint64_t seed{};
};

/// The report without limits. Asserts that models are SVRs, and that verifications fit their clusters.
[[nodiscard]] Report make_report(const ReportSource& source);

}  // namespace gyrotherm::report
