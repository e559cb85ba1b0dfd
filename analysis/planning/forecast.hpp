// SPDX-License-Identifier: Apache-2.0
/// The uncertainty that a program is expected to give a unit, before the unit has run: from the record of a unit of the
/// type, which may be the same one.
#pragma once

#include "analysis/data/clusters.hpp"
#include "analysis/model/model.hpp"
#include "analysis/planning/program_path.hpp"
#include "analysis/planning/thermal_response.hpp"
#include "core/result.hpp"

namespace gyrotherm::planning {

/// Forecasts of programs that are used on one mission. The model starts without knowledge: each coefficient has the
/// prior N(0, 1) in units of the scaled inputs and the scaled target. A program then gives it the covariance, the
/// trained range and the power-ons of its predicted clusters; see assess(). Noise, sensitivities and the other rows of
/// the budget are those of the reference record. The model form of a program is that of the reference record times √(½
/// + ½ V/V₀), V and V₀ the mean variance on the mission after the program and after the program of the reference
/// record.
class Forecast {
 public:
  /// Trains the recommended model on the reference record. Fails like train() or fit_response().
  [[nodiscard]] static Result<Forecast> make(const data::RecordedRun& reference, const ProgramPath& mission,
                                             const ProgressSink& progress = {});

  /// Returns the expanded uncertainty of a mean over 1 h that is expected on the mission after a program, °/h. The
  /// program must have a cluster with the unit on.
  [[nodiscard]] Result<double> expanded_after(const ProgramPath& program) const;

  /// Returns the expanded uncertainty of the model of the reference record on the mission, °/h.
  [[nodiscard]] double reference_deg_per_h() const { return reference_deg_per_h_; }
  [[nodiscard]] const model::Model& reference() const { return reference_; }
  [[nodiscard]] const ThermalResponse& response() const { return response_; }

 private:
  Forecast(model::Model reference, ThermalResponse response, data::Clusters mission)
      : reference_(std::move(reference)), response_(std::move(response)), mission_(std::move(mission)) {}

  /// The model without knowledge after a program, and its mean variance on the mission, (°/h)².
  struct Learnt {
    model::Model model;
    double on_mission{};
    double in_training{};
  };
  [[nodiscard]] Result<Learnt> learn(const ProgramPath& program) const;

  model::Model reference_;
  ThermalResponse response_;
  data::Clusters mission_;
  double reference_variance_{};
  double reference_deg_per_h_{};
};

}  // namespace gyrotherm::planning
