// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/qualify/gyro_thermal.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>

#include "apps/console/interrupt.hpp"
#include "core/child_process.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/sha256.hpp"
#include "core/shipped.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::app {
namespace {

constexpr auto kTimeout = std::chrono::minutes(5);

/// Name and digest of the gyro file of a reduced model.
struct Origin {
  std::string gyro, sha256;
};

Result<Origin> parse_origin(const simulator::GyroModelUsed& used) {
  const auto root = TomlTable::parse(used.text, used.path);
  if (!root) return failure(root.error());
  for (const auto& key : root->keys()) root->ignore(key);
  Origin origin{root->text("gyro"), root->text("source_sha256")};
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return origin;
}

/// Returns the path of the gyro file with this name and content, next to the reduced model or among the shipped files.
/// Returns an empty string if neither matches.
std::string find_gyro_file(const simulator::GyroModelUsed& used, const Origin& origin) {
  const std::string name = origin.gyro + ".toml";
  const std::string beside = (std::filesystem::path(used.path).parent_path() / name).string();
  for (const std::string& path : {beside, find_shipped_file(std::string(kShippedGyro.folder) + "/" + name)}) {
    if (path.empty()) continue;
    const auto text = read_text_file(path);
    if (text && sha256(*text) == origin.sha256) return path;
  }
  return {};
}

}  // namespace

Result<report::ReportedThermal> find_thermal_model(const rig::RigFile& rig) {
  if (!rig.simulated) return report::ReportedThermal{};
  const simulator::GyroModelUsed& used = rig.gyro_model;
  if (used.text.empty())
    return report::ReportedThermal{.reason =
                                       "the virtual gyro consists of lumps, which the rig file describes; no "
                                       "finite-element model of it exists"};
  const auto origin = parse_origin(used);
  if (!origin) return report::not_available(origin.error().what);
  const std::string file = find_gyro_file(used, *origin);
  if (file.empty())
    return report::not_available(
        fmt::format("the virtual gyro is a reduced model, and the gyro file \"{}\" that it was made from is missing or "
                    "has changed since",
                    origin->gyro));
  const auto model =
      read_program_output({sibling_program_path("gyrotherm-thermal"), "figure", "--quiet", "--gyro", file}, kTimeout)
          .and_then(
              [](const std::string& out) { return report::read_thermal_figure(out, "gyrotherm-thermal figure"); });
  if (interrupted()) return failure(FaultKind::interrupted, "thermal image", "stopped");
  if (!model) return report::not_available("gyrotherm-thermal " + model.error().what);
  return report::ReportedThermal{.missing = {}, .reason = {}, .model = *model};
}

}  // namespace gyrotherm::app
