// SPDX-License-Identifier: Apache-2.0
#include "report/temperature_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/text.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kZeroCelsius = 273.15;
constexpr double kLargestTemperature = 1e5;
/// Values of a hybrid in two units may differ by their rounding, K.
constexpr double kHybridRounding = 0.06;
/// Difference between a stated probability and that of the coverage factor: k = 2 is usually called 95 %.
constexpr double kProbabilityRounding = 0.01;

using Words = std::vector<std::string_view>;

/// A unit of temperature: kelvins = value · scale, above −273.15 °C if it is not Celsius.
struct TemperatureUnit {
  double scale = 1;
  bool is_celsius{};
};

std::optional<TemperatureUnit> parse_temperature_unit(std::string_view text) {
  TemperatureUnit unit;
  for (const auto& [prefix, scale] : {std::pair<std::string_view, double>{"\\milli", 1e-3}, {"\\micro", 1e-6}})
    if (text.starts_with(prefix)) {
      unit.scale = scale;
      text.remove_prefix(prefix.size());
      break;
    }
  unit.is_celsius = text == "\\degreecelsius";
  return unit.is_celsius || text == "\\kelvin" ? std::optional(unit) : std::nullopt;
}

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_whole = error == std::errc{} && end == text.data() + text.size();
  return is_whole && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

/// Returns the share of a normal distribution within ±k standard deviations.
double normal_coverage(double k) { return std::erf(k / std::numbers::sqrt2); }

/// Returns the share of Student's distribution with one degree of freedom within ±k.
double cauchy_coverage(double k) { return 2 / std::numbers::pi * std::atan(k); }

/// Names of the parts of an uncertainty, without the suffix of a list.
struct UncertaintyForm {
  /// Elements around the parts.
  const char *outer, *inner;
  const char* value;
  bool is_expanded;
};
constexpr UncertaintyForm kForms[] = {
    {"measurementUncertaintyUnivariate", "expandedMU", "valueExpandedMU", true},
    {"measurementUncertaintyUnivaraite", "expandedMU", "valueExpandedMU", true},  // spelt so in D-SI 2
    {"listMeasurementUncertaintyUnivariate", "expandedMU", "valueExpandedMU", true},
    {"measurementUncertaintyUnivariate", "standardMU", "valueStandardMU", false},
    {"measurementUncertaintyUnivaraite", "standardMU", "valueStandardMU", false},
    {"listMeasurementUncertaintyUnivariate", "standardMU", "valueStandardMU", false},
    {"measurementUncertaintyUnivariate", "coverageIntervalMU", "valueStandardMU", false},
    {"listUnivariateUnc", "expandedUnc", "uncertainty", true},
    {nullptr, "expandedUnc", "uncertainty", true},
    {nullptr, "coverageInterval", "standardUnc", false}};

class ValueReader {
 public:
  ValueReader(const XmlElement& quantity, std::string file, bool are_differences)
      : quantity_(quantity), file_(std::move(file)), are_differences_(are_differences) {}

  Result<TemperatureValues> read() const {
    const XmlElement* found = nullptr;
    for (const XmlElement& child : quantity_.children) {
      if (child.space != kDsiSpace) continue;
      if (found != nullptr) return refused(child, "has more than one value");
      found = &child;
    }
    if (found == nullptr) return refused(quantity_, "has no value in the notation of D-SI");
    return found->name == "hybrid" ? read_hybrid(*found) : read_one(*found);
  }

 private:
  static constexpr std::string_view kDsiSpace = "https://ptb.de/si";

  tl::unexpected<Fault> refused(const XmlElement& at, std::string what) const {
    return failure(FaultKind::bad_file, fmt::format("{}:{}", file_, at.line), std::move(what));
  }

  /// Reads the first alternative in a unit of temperature, and compares the others with it.
  Result<TemperatureValues> read_hybrid(const XmlElement& hybrid) const {
    TemperatureValues first;
    for (const XmlElement& child : hybrid.children) {
      auto read = read_one(child);
      if (!read) return read;
      if (read->values.empty()) {
        if (first.values.empty() && first.other_unit.empty()) first.other_unit = read->other_unit;
        continue;
      }
      if (first.values.empty()) {
        first = std::move(*read);
        continue;
      }
      const auto agree = [](const TemperatureValue& a, const TemperatureValue& b) {
        return std::abs(a.value - b.value) <= kHybridRounding;
      };
      if (!std::ranges::equal(first.values, read->values, agree))
        return refused(child, "contradicts the value in another unit");
    }
    if (first.values.empty() && first.other_unit.empty()) return refused(hybrid, "has no value");
    return first;
  }

  Result<TemperatureValues> read_one(const XmlElement& element) const {
    if (element.name == "real") return read_values(element, "", true);
    if (element.name == "realListXMLList") return read_values(element, "XMLList", false);
    if (element.name == "list") return read_list(element);
    return refused(element, fmt::format("has the form \"{}\", expected real, realListXMLList, list or hybrid",
                                        plain(element.name)));
  }

  /// Reads a list of si:real. Its unit and uncertainty may be stated once for all.
  Result<TemperatureValues> read_list(const XmlElement& list) const {
    TemperatureValues all;
    for (const XmlElement* real : list.all("real")) {
      XmlElement one = *real;
      const XmlElement* unit = list.only("listUnit");
      if (one.only("unit") == nullptr && unit != nullptr) {
        one.children.push_back(*unit);
        one.children.back().name = "unit";
      }
      for (const char* name : {"listMeasurementUncertaintyUnivariate", "listUnivariateUnc"})
        if (const XmlElement* common = list.only(name)) one.children.push_back(*common);
      auto read = read_values(one, "", true);
      if (!read) return read;
      if (read->values.empty()) return read;
      all.values.push_back(read->values.front());
    }
    if (all.values.empty()) return refused(list, "is empty");
    return all;
  }

  /// Reads the texts of a list, or of a single value. A text that is stated once applies to all `count` values.
  Result<Words> read_words(const XmlElement& parent, const std::string& name, std::size_t count) const {
    const XmlElement* element = parent.only(name);
    if (element == nullptr) return refused(parent, fmt::format("has no {}", name));
    Words words = split_xml_list(element->text);
    if (words.size() == 1 && count > 1) words.resize(count, words.front());
    if (words.size() != count)
      return refused(*element, fmt::format("{} has {} entries for {} values", name, words.size(), count));
    return words;
  }

  Result<TemperatureValues> read_values(const XmlElement& element, const std::string& suffix, bool is_single) const {
    const XmlElement* values = element.only("value" + suffix);
    if (values == nullptr) return refused(element, fmt::format("has no value{}", suffix));
    const Words numbers = split_xml_list(values->text);
    if (numbers.empty() || (is_single && numbers.size() != 1)) return refused(*values, "expected a number");
    const auto units = read_words(element, "unit" + suffix, numbers.size());
    if (!units) return failure(units.error());
    TemperatureValues read;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto unit = parse_temperature_unit((*units)[i]);
      if (!unit) return TemperatureValues{.other_unit = std::string((*units)[i])};
      const auto number = parse_number(numbers[i]);
      if (!number || std::abs(*number * unit->scale) > kLargestTemperature)
        return refused(*values, fmt::format("\"{}\" is not a temperature", plain(numbers[i])));
      const double offset = are_differences_ || unit->is_celsius ? 0 : -kZeroCelsius;
      read.values.push_back({.value = *number * unit->scale + offset});
      if (!are_differences_ && read.values.back().value < -kZeroCelsius)
        return refused(*values, fmt::format("{} is below absolute zero", plain(numbers[i])));
    }
    if (auto done = add_uncertainties(element, suffix, *units, read.values); !done) return failure(done.error());
    return read;
  }

  /// Adds the uncertainty in one of the forms of D-SI, in the unit of the value.
  Result<void> add_uncertainties(const XmlElement& element, const std::string& suffix, const Words& units,
                                 std::vector<TemperatureValue>& values) const {
    int forms = 0;
    for (const UncertaintyForm& form : kForms) {
      const XmlElement* outer = form.outer == nullptr ? &element : element.only(form.outer + suffix);
      const XmlElement* parts = outer == nullptr ? nullptr : outer->only(form.inner + suffix);
      if (parts == nullptr) continue;
      if (++forms > 1) return refused(*parts, "states a second uncertainty");
      if (auto done = add_form(form, *parts, suffix, units, values); !done) return done;
    }
    return {};
  }

  Result<void> add_form(const UncertaintyForm& form, const XmlElement& parts, const std::string& suffix,
                        const Words& units, std::vector<TemperatureValue>& values) const {
    const std::size_t count = values.size();
    const auto stated = read_words(parts, form.value + suffix, count);
    if (!stated) return failure(stated.error());
    Words factors(count, "1"), probabilities, distributions(count);
    if (form.is_expanded) {
      auto read = read_words(parts, "coverageFactor" + suffix, count);
      if (!read) return failure(read.error());
      factors = std::move(*read);
      if (parts.only("coverageProbability" + suffix) != nullptr) {
        read = read_words(parts, "coverageProbability" + suffix, count);
        if (!read) return failure(read.error());
        probabilities = std::move(*read);
      }
      if (parts.only("distribution" + suffix) != nullptr) {
        read = read_words(parts, "distribution" + suffix, count);
        if (!read) return failure(read.error());
        distributions = std::move(*read);
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto expanded = parse_number((*stated)[i]), factor = parse_number(factors[i]);
      const auto probability = probabilities.empty() ? std::nullopt : parse_number(probabilities[i]);
      if (!expanded) return refused(parts, fmt::format("U is \"{}\", expected a number", plain((*stated)[i])));
      if (!factor) return refused(parts, fmt::format("k is \"{}\", expected a number", plain(factors[i])));
      if (!probabilities.empty() && !probability)
        return refused(parts, fmt::format("the probability is \"{}\", expected a number", plain(probabilities[i])));
      const double kelvins = *expanded * parse_temperature_unit(units[i])->scale;
      if (auto why = uncertainty_refusal(kelvins, *factor, probability, distributions[i]); !why.empty())
        return refused(parts, std::move(why));
      values[i].uncertainty = ExpandedUncertainty{kelvins, *factor};
    }
    return {};
  }

  const XmlElement& quantity_;
  std::string file_;
  bool are_differences_;
};

}  // namespace

std::string uncertainty_refusal(double expanded, double coverage_factor, std::optional<double> probability,
                                std::string_view distribution) {
  if (!(expanded > 0 && expanded < kLargestTemperature))
    return fmt::format("U is {:g} K, expected more than 0", expanded);
  if (!(coverage_factor >= 1 && coverage_factor < kLargestTemperature))
    return fmt::format("k is {:g}, expected 1 or more", coverage_factor);
  if (!probability) return {};
  if (!(*probability > 0 && *probability <= 1))
    return fmt::format("the coverage probability is {:g}, expected 0 to 1", *probability);
  double least = cauchy_coverage(coverage_factor), most = normal_coverage(coverage_factor);
  if (distribution == "normal") least = most;
  if (distribution == "uniform" || distribution == "rectangular")
    least = most = std::min(1.0, coverage_factor / std::numbers::sqrt3);
  if (*probability >= least - kProbabilityRounding && *probability <= most + kProbabilityRounding) return {};
  return fmt::format("k = {:g} contradicts the coverage probability of {:g}", coverage_factor, *probability);
}

std::vector<std::string_view> split_xml_list(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  Words words;
  for (auto begins = text.find_first_not_of(kBlanks); begins != text.npos; begins = text.find_first_not_of(kBlanks)) {
    text.remove_prefix(begins);
    const auto ends = std::min(text.find_first_of(kBlanks), text.size());
    words.push_back(text.substr(0, ends));
    text.remove_prefix(ends);
  }
  return words;
}

Result<TemperatureValues> read_temperatures(const XmlElement& quantity, const std::string& file, bool are_differences) {
  return ValueReader(quantity, file, are_differences).read();
}

}  // namespace gyrotherm::report
