// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "analysis/data/statistics.hpp"
#include "core/text.hpp"

namespace gyrotherm::model {
namespace {

using Terms = std::vector<data::Term>;

/// A keyword of --inputs.
struct Keyword {
  std::string_view name;
  Result<Terms> (*terms)(const data::Dataset&);
  /// True if the terms are candidates for a selection by correlation when no rule is given.
  bool selects = false;
};

Result<void> check_gradients(const data::Dataset& dataset) {
  if (dataset.gradients.size() >= 2) return {};
  return failure(FaultKind::usage, dataset.path,
                 fmt::format("no gradients: the record has fewer than two gradient thermometers{}",
                             dataset.gradients.empty() ? "" : "; use --inputs temperatures"));
}

Result<Terms> gradients(const data::Dataset& dataset) {
  return check_gradients(dataset).map([&] { return data::all_gradients(dataset.gradients); });
}

Result<Terms> differences_to_first(const data::Dataset& dataset) {
  if (const auto checked = check_gradients(dataset); !checked) return failure(checked.error());
  Terms terms;
  for (std::size_t j = 1; j < dataset.gradients.size(); ++j) {
    terms.push_back(data::gradient_term(dataset.gradients.front(), dataset.gradients[j]));
  }
  return terms;
}

Result<Terms> three_points(const data::Dataset& dataset) {
  const auto& points = dataset.three_point;
  if (points.size() != 3) {
    return failure(FaultKind::usage, dataset.path,
                   "three-point needs a cathode, an anode and a shell thermometer, which the record does not name");
  }
  return Terms{data::gradient_term(points[0], points[1]), data::gradient_term(points[0], points[2]),
               data::gradient_term(points[1], points[2])};
}

Result<data::Term> first_temperature(const data::Dataset& dataset) {
  if (!dataset.gradients.empty()) return data::temperature_term(dataset.gradients.front());
  return failure(FaultKind::usage, dataset.path, "no temperature: the record has no gradient thermometer");
}

/// Returns the three-point terms and the temperature. Like multi-point-t, this separates the effect of the temperature
/// from the effect of the points.
Result<Terms> three_points_and_temperature(const data::Dataset& dataset) {
  auto terms = three_points(dataset);
  if (!terms) return terms;
  const auto temperature = first_temperature(dataset);
  if (!temperature) return failure(temperature.error());
  terms->push_back(*temperature);
  return terms;
}

/// Returns one term per gradient thermometer.
template <data::Term (*make)(std::string)>
Result<Terms> term_per_thermometer(const data::Dataset& dataset) {
  Terms terms;
  for (const std::string& name : dataset.gradients) terms.push_back(make(name));
  return terms;
}

/// Returns the differences with the first thermometer; none if there is a single one.
Terms optional_differences(const data::Dataset& dataset) { return differences_to_first(dataset).value_or(Terms{}); }

Result<Terms> polynomial(const data::Dataset& dataset) {
  return first_temperature(dataset).map([&](const data::Term& t) {
    const data::Term rate = data::rate_term(dataset.gradients.front());
    return Terms{t, t * t, t * t * t, rate, t * rate};
  });
}

Result<Terms> temperature_gradient_rate(const data::Dataset& dataset) {
  return first_temperature(dataset).map([&](const data::Term& t) {
    Terms terms = optional_differences(dataset);
    terms.insert(terms.begin(), t);
    terms.push_back(data::rate_term(dataset.gradients.front()));
    return terms;
  });
}

Result<Terms> physics(const data::Dataset& dataset) {
  return first_temperature(dataset).map([&](const data::Term& t) {
    const Terms differences = optional_differences(dataset);
    Terms terms{t, t * t};
    terms.insert(terms.end(), differences.begin(), differences.end());
    for (const data::Term& difference : differences) terms.push_back(t * difference);
    terms.push_back(data::rate_term(dataset.gradients.front()));
    return terms;
  });
}

/// A fast and a slow time constant of a gyro's block, s. The slowest time constant in the reference simulation is 46
/// min.
constexpr std::array kTimeConstantsS = {600, 2400};

Result<Terms> thermal_history(const data::Dataset& dataset) {
  return first_temperature(dataset).map([&](const data::Term& t) {
    Terms terms;
    for (const std::string& name : dataset.gradients) terms.push_back(data::temperature_term(name));
    for (const int time_constant_s : kTimeConstantsS)
      for (const std::string& name : dataset.gradients) terms.push_back(data::lag_term(time_constant_s, name));
    for (const data::Term& term : Terms(terms)) terms.push_back(t * term);
    return terms;
  });
}

/// Time constants from which a state-space model selects, s: in octaves, from less than the time constant of a gyro's
/// fastest part to five hours.
constexpr std::array kBankS = {300, 600, 1200, 2400, 4800, 9600, 19200};

Result<Terms> lag_bank(const data::Dataset& dataset) {
  auto terms = term_per_thermometer<data::temperature_term>(dataset);
  if (!terms) return terms;
  for (const int time_constant_s : kBankS)
    for (const std::string& name : dataset.gradients) terms->push_back(data::lag_term(time_constant_s, name));
  return terms;
}

constexpr std::array kKeywords = {Keyword{"multi-point", gradients, true},
                                  Keyword{"multi-point-t", gradients, true},
                                  Keyword{"three-point", three_points},
                                  Keyword{"three-point-t", three_points_and_temperature},
                                  Keyword{"seven-point", differences_to_first},
                                  Keyword{"gradients", gradients},
                                  Keyword{"temperatures", term_per_thermometer<data::temperature_term>},
                                  Keyword{"rates", term_per_thermometer<data::rate_term>},
                                  Keyword{"polynomial", polynomial},
                                  Keyword{"temperature-gradient-rate", temperature_gradient_rate},
                                  Keyword{"physics", physics},
                                  Keyword{"thermal-history", thermal_history},
                                  Keyword{"lag-bank", lag_bank}};

bool contains(const Terms& terms, const data::Term& term) { return std::ranges::count(terms, term) > 0; }

void add_new(Terms& to, const Terms& terms) {
  for (const data::Term& term : terms) {
    if (!contains(to, term)) to.push_back(term);
  }
}

std::vector<std::string_view> split_at(char separator, std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto at = text.find(separator);
    std::string_view part = text.substr(0, at);
    part.remove_prefix(std::min(part.find_first_not_of(' '), part.size()));
    part.remove_suffix(part.size() - (part.find_last_not_of(' ') + 1));
    parts.push_back(part);
    if (at == text.npos) return parts;
    text.remove_prefix(at + 1);
  }
}

bool is_input(std::string_view part, const data::Dataset& dataset) {
  return std::ranges::count(kKeywords, part, &Keyword::name) > 0 || data::parse_term(part, dataset.thermometers);
}

/// Splits at commas, and at '+' only where the text between two commas is not an input itself, since a name may contain
/// '+'.
std::vector<std::string_view> split_inputs(std::string_view inputs, const data::Dataset& dataset) {
  std::vector<std::string_view> parts;
  for (const std::string_view part : split_at(',', inputs)) {
    if (is_input(part, dataset)) {
      parts.push_back(part);
      continue;
    }
    for (const std::string_view piece : split_at('+', part)) parts.push_back(piece);
  }
  return parts;
}

Result<data::Term> read_term(std::string_view part, const data::Dataset& dataset) {
  auto term = data::parse_term(part, dataset.thermometers);
  if (term) return term;
  std::vector<std::string> keywords;
  for (const Keyword& keyword : kKeywords) keywords.emplace_back(keyword.name);
  const std::string keyword = find_nearest(std::string(part), keywords);
  Fault fault = term.error();
  if (!keyword.empty()) fault.what += fmt::format("; or did you mean \"{}\"?", keyword);
  return failure(fault);
}

}  // namespace

Result<InputPlan> plan_inputs(const std::string& inputs, const data::Dataset& dataset,
                              const std::optional<SelectionRule>& rule) {
  InputPlan plan{.fixed = {}, .candidates = {}, .rule = rule.value_or(SelectionRule{})};
  Terms named;
  for (const std::string_view part : split_inputs(inputs, dataset)) {
    if (const auto keyword = std::ranges::find(kKeywords, part, &Keyword::name); keyword != kKeywords.end()) {
      const auto terms = keyword->terms(dataset);
      if (!terms) return failure(terms.error());
      add_new(rule || keyword->selects ? plan.candidates : plan.fixed, *terms);
      if (keyword->name == "multi-point-t") add_new(plan.fixed, {data::temperature_term(dataset.gradients.front())});
      continue;
    }
    auto term = read_term(part, dataset);
    if (!term) return failure(term.error());
    if (contains(named, *term)) {
      return failure(FaultKind::usage, fmt::format("input \"{}\"", part), "is given twice");
    }
    named.push_back(std::move(*term));
  }
  add_new(plan.fixed, named);
  std::erase_if(plan.candidates, [&](const data::Term& term) { return contains(plan.fixed, term); });
  if (rule && plan.candidates.empty()) {
    return failure(FaultKind::usage, "--select",
                   "no inputs to select from: name gradients, temperatures or rates among the inputs");
  }
  return plan;
}

Result<std::vector<Eigen::Index>> rows_with_inputs(const InputPlan& plan, const data::Clusters& clusters) {
  Terms terms = plan.fixed;
  add_new(terms, plan.candidates);
  return evaluate(terms, clusters).map([](const data::SampleMatrix& values) { return data::finite_rows(values); });
}

Result<ChosenInputs> choose_inputs(const InputPlan& plan, const data::TrainingSet& training_set) {
  ChosenInputs chosen;
  if (!plan.candidates.empty()) {
    auto selection = select_inputs(plan.rule, plan.fixed, plan.candidates, training_set);
    if (!selection) return failure(selection.error());
    chosen.selection = std::move(*selection);
    chosen.terms = chosen.selection.terms;
  }
  chosen.terms.insert(chosen.terms.end(), plan.fixed.begin(), plan.fixed.end());
  if (chosen.terms.empty())
    return failure(FaultKind::usage, "inputs", "no input is left: " + chosen.selection.statement);
  return chosen;
}

}  // namespace gyrotherm::model
