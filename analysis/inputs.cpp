#include "analysis/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "core/nearest.hpp"

namespace gyrotherm {
namespace {

Term gradient(const std::string& first, const std::string& second) { return {TermKind::gradient, first, second}; }

std::vector<std::string_view> split_at_commas(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto comma = text.find(',');
    std::string_view part = text.substr(0, comma);
    part.remove_prefix(std::min(part.find_first_not_of(' '), part.size()));
    part.remove_suffix(part.size() - (part.find_last_not_of(' ') + 1));
    parts.push_back(part);
    if (comma == text.npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

Result<InputPlan> plan_terms(const std::string& inputs, const Dataset& dataset) {
  static const std::array<std::string, 4> kWords = {"multi-point", "multi-point-t", "three-point", "seven-point"};
  InputPlan plan;
  for (const std::string_view part : split_at_commas(inputs)) {
    const auto term = parse_term(part, dataset.thermometers);
    if (!term) {
      const std::string word = nearest(inputs, kWords);
      Fault fault = term.error();
      if (!word.empty()) fault.what += fmt::format("; or did you mean \"{}\"?", word);
      return failure(fault);
    }
    if (std::ranges::count(plan.fixed, *term) > 0) {
      return failure(FaultKind::usage, fmt::format("input \"{}\"", part), "is given twice");
    }
    plan.fixed.push_back(*term);
  }
  return plan;
}

Result<InputPlan> plan_three_point(const Dataset& dataset) {
  const auto& points = dataset.three_point;
  if (points.size() != 3) {
    return failure(FaultKind::usage, dataset.path,
                   "three-point needs a cathode, an anode and a shell thermometer; the record names none");
  }
  InputPlan plan;
  plan.fixed = {gradient(points[0], points[1]), gradient(points[0], points[2]), gradient(points[1], points[2])};
  return plan;
}

Result<InputPlan> plan_seven_point(const Dataset& dataset) {
  InputPlan plan;
  for (std::size_t j = 1; j < dataset.gradients.size(); ++j) {
    plan.fixed.push_back(gradient(dataset.gradients.front(), dataset.gradients[j]));
  }
  return plan;
}

}  // namespace

Result<InputPlan> plan_inputs(const std::string& inputs, const Dataset& dataset, double threshold) {
  if (inputs == "three-point") return plan_three_point(dataset);
  const bool selecting = inputs == "multi-point" || inputs == "multi-point-t";
  if (!selecting && inputs != "seven-point") return plan_terms(inputs, dataset);
  if (dataset.gradients.size() < 2) {
    return failure(FaultKind::usage, dataset.path, inputs + " needs at least two gradient thermometers");
  }
  if (!selecting) return plan_seven_point(dataset);
  InputPlan plan;
  plan.candidates = dataset.gradients;
  plan.threshold = threshold;
  if (inputs == "multi-point-t") plan.fixed.push_back({TermKind::temperature, dataset.gradients.front(), ""});
  return plan;
}

ChosenInputs choose_inputs(const InputPlan& plan, const Clusters& training) {
  ChosenInputs chosen;
  if (!plan.candidates.empty()) {
    const int least_rank = std::min(2, static_cast<int>(plan.candidates.size()) - 1);
    const Correlation r = correlate(training, plan.candidates);
    chosen.selection = select_pairs(plan.candidates, r.gradient, plan.threshold, least_rank);
    chosen.terms = chosen.selection.terms;
  }
  chosen.terms.insert(chosen.terms.end(), plan.fixed.begin(), plan.fixed.end());
  return chosen;
}

}  // namespace gyrotherm
