// SPDX-License-Identifier: Apache-2.0
/// Writes the description of an exported model as the comment at the head of its C program.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "analysis/model/export_parts.hpp"

namespace gyrotherm::model {
namespace {

std::string describe_means(const data::Figures& f) {
  return fmt::format("{} deg/h over {} means", data::format_figures(f), f.count);
}

std::string describe_record(const TrainingRecord& record) {
  return fmt::format("Trained on {}{}{} (run {}, profile {}), {} means of {:.0f} to {:.0f} s.",
                     record.simulated ? "SIMULATED data: " : "",
                     is_named(record.of) ? qualified_name(record.of) + " of " : "", record.path, record.run_id,
                     record.profile_name, record.clusters, record.from_s, record.to_s);
}

std::string describe_reduction(const ReducedSetSummary& reduction) {
  return fmt::format(
      "Reduced from {} to {} vectors: changes of at most {:.3g} deg/h, rms {:.3g}, on {} training means, bound {:.3g}; "
      "the residuals below belong to the full function.",
      reduction.vectors_before, reduction.vectors, reduction.max_change_deg_per_h, reduction.rms_change_deg_per_h,
      reduction.clusters, reduction.bound_deg_per_h);
}

std::string describe_range(const Model& model, Eigen::Index input) {
  const bool rate = has_rate(model.terms[static_cast<std::size_t>(input)]);
  return fmt::format("  {}: {:.6g} to {:.6g}{}", to_string(model.terms[static_cast<std::size_t>(input)]),
                     model.input_min(input), model.input_max(input), rate ? " (rates in degC/min)" : "");
}

}  // namespace

std::string c_provenance(const Model& model) {
  std::vector<std::string> lines;
  lines.push_back("Compensation of a gyro's temperature bias, written by gyrotherm " + model.program_version + ".");
  const bool simulated = std::ranges::any_of(model.trained_on, &TrainingRecord::simulated);
  if (simulated) lines.emplace_back("SIMULATED: the model was trained on data of a virtual gyro.");
  lines.push_back(fmt::format("Method {}, inputs {}; means of {:g} s.{}", model.method, model.inputs,
                              model.cluster_length_s, model.quick ? " Tuned with a small swarm, for a trial." : ""));
  if (model.reduction) lines.push_back(describe_reduction(*model.reduction));
  for (const TrainingRecord& record : model.trained_on) lines.push_back(describe_record(record));
  lines.push_back("Bias as trained: mean " +
                  fmt::format("{:.6g}, std {:.6g} deg/h.", model.target_mean_deg_per_h, model.target_std_deg_per_h));
  lines.push_back("Residual in-sample (not a verification): " + describe_means(model.in_sample) + ".");
  lines.push_back(fmt::format("Residual held out, {}: {}.", model.folds, describe_means(model.leave_cycle_out)));
  for (const std::string& warning : model.warnings) lines.push_back("Warning: " + warning + ".");
  if (const auto block = trained_block(model.trained_on))
    lines.push_back(fmt::format("Trained range of the block: {:.1f} to {:.1f} degC.", block->low_c, block->high_c));
  lines.emplace_back("Trained range of each input, degC:");
  for (Eigen::Index i = 0; i < model.input_min.size(); ++i) lines.push_back(describe_range(model, i));
  std::string text;
  for (const std::string& line : lines) text += ' ' + c_comment(line) + '\n';
  return text;
}

}  // namespace gyrotherm::model
