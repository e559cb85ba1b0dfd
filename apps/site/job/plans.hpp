// SPDX-License-Identifier: Apache-2.0
/// What a site has many machines for, as jobs: every axis of a lot, many seeds, each unit left out of its type, the
/// price of every thermometer of every axis. All commands are those that a single machine would be given.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "apps/site/job/job.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// Words that are passed on to the command, and what each task may use.
struct PlanOptions {
  std::vector<std::string> words{};
  int threads = 1;
};

/// Every axis of the experiment in the folder `lot`, whose records are there: `qualify --only`, and then `qualify`,
/// which sums up. Fails as read_info() does, or with usage if there is one axis alone.
[[nodiscard]] Result<Job> plan_lot(const std::string& rig, const std::string& lot, const PlanOptions& options);
/// What makes the records ready for that, on this machine.
[[nodiscard]] Step records_of_lot(const std::string& rig, const std::string& lot, const PlanOptions& options);

/// One model a seed, each verified on the same records, into OUT/seed-N/. Fails with usage if there is no seed, or more
/// than any queue takes.
struct Seeds {
  std::vector<std::string> records, verify;
  std::uint64_t first = 1, last = 20;
};
[[nodiscard]] Result<Job> plan_seeds(const Seeds& seeds, const std::string& out, const PlanOptions& options);

/// Each of these records of different units left out of the prior of their type, which then helps a model of its own
/// first hours, which is verified on all the others: into OUT/NAME/, where NAME is the record's. Fails with usage if
/// there are fewer than four, or two of one name.
[[nodiscard]] Result<Job> plan_leave_one_out(const std::vector<std::string>& records, double hours,
                                             const std::string& out, const PlanOptions& options);

/// `placement` of each axis of the first record, into OUT/AXIS.json.
[[nodiscard]] Result<Job> plan_placement(const std::vector<std::string>& records, const std::string& out,
                                         const PlanOptions& options);

}  // namespace gyrotherm::site
