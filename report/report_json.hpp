/// Assembles report.json (schema "gyrotherm-report/1"), the only source of every view of the report.
///
/// Equal inputs give equal bytes: nothing in it varies from run to run of the same experiment, so no wall time, no
/// thread count and no path of the machine. Numbers have the fewest digits that give back the same double; NaN is null.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/data/hold_noise.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/model.hpp"
#include "analysis/model/verification.hpp"

namespace gyrotherm {

inline constexpr const char* kReportSchema = "gyrotherm-report/1";

/// One record and how each of the three models does on it. The verifications are of exactly these clusters.
struct ReportedRun {
  const Dataset& dataset;
  const Clusters& clusters;
  const Verification& three_point;
  const Verification& multi_point;
  const Verification& multi_point_t;
  std::string record_sha256;
  std::string profile_sha256;
  HoldNoise noise;              ///< of the dataset
  HoldNoise compensated_noise;  ///< the same of what multi_point_t leaves
};

/// All three are SVRs, trained on the rate run.
struct ReportedModels {
  const Model& three_point;
  const Model& multi_point;
  const Model& multi_point_t;
};

/// Who reads a channel, and how its readings were corrected, in words.
struct ReportedThermometer {
  std::string channel;
  std::string instrument;
  std::string calibration;  ///< "offset 0.01 K, certificate 2026-0123, due 2027-03-01", "none"
};

struct ReportedRig {
  std::string name;
  std::string title;
  std::string gyro;    ///< in words: "pulse counts, 0.1 arcsec each"
  std::string sha256;  ///< of the rig file
  bool is_virtual{};
  std::string gyro_model = {};         ///< the thermal model that a virtual gyro stands on; may be empty
  std::string gyro_film = {};          ///< how the air moves around it: "chamber", "still"
  std::string gyro_model_sha256 = {};  ///< of the model's file
  std::vector<ReportedThermometer> thermometers = {};
};

/// A method on the same records as the others.
struct ComparedMethod {
  std::string name;  ///< "linear-multi-point-t": the key of its row
  std::string inputs;
  std::string method;
  Figures in_sample;
  Figures leave_cycle_out;
  Figures random;
  std::optional<Figures> nested = {};  ///< leave-cycle-out with the parameters chosen without the held-out cycle too
  int stored_numbers{};                ///< its size in a navigation computer; 0: not known
  double effective_parameters{};       ///< 0: not known
  std::string title = {};              ///< "PSO-SVM"
  std::string citation = {};           ///< of its published form
};

/// The numbers that the model's function, the scaling of its inputs and its target store.
[[nodiscard]] int stored_numbers(const Model& model);

/// The row of a model, with what the table of methods says of it. `in_sample` and `random` are what verify() found.
[[nodiscard]] ComparedMethod compared_method(std::string name, const Model& model, const Figures& in_sample,
                                             const Figures& random);

/// One limit of the profiles' [accept] tables and the figure held against it.
struct AcceptedLimit {
  std::string figure;  ///< its key in the report: "random.multi_point_t.std_deg_per_h"
  double limit{};
  double value{};
  bool passed{};
};

struct ReportInput {
  ReportedRig rig;
  ReportedRun rate;
  ReportedRun random;
  ReportedModels models;
  const Correlation& correlation;  ///< of the rate run's clusters, over the gradient thermometers
  std::vector<ComparedMethod> compared;
  std::vector<AcceptedLimit> accept;  ///< empty: the profiles set no limit
  std::string program_version;
  std::uint64_t seed{};
  std::vector<std::string> warnings;  ///< the program's own, beside those of models and verifications
};

/// The text of report.json, ending in a newline. Asserts that models are SVRs, and that verifications fit their
/// clusters.
[[nodiscard]] std::string report_json(const ReportInput& input);

}  // namespace gyrotherm
