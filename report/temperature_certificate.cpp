// SPDX-License-Identifier: Apache-2.0
#include "report/temperature_certificate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/sha256.hpp"
#include "core/text.hpp"
#include "report/dcc_text.hpp"
#include "report/temperature_values.hpp"

namespace gyrotherm::report {
namespace {

constexpr std::string_view kDccSpace = "https://ptb.de/dcc";
constexpr int kNewestMinorVersion = 3;
/// A stated correction may differ from that of the rounded temperatures beside it, K.
constexpr double kLargestRounding = 0.1;
constexpr double kOffsetResolution = 1e-9;  // K
constexpr std::string_view kXmlBlanks = " \t\r\n";

using Elements = std::vector<const XmlElement*>;

std::string child_text(const XmlElement& element, std::string_view name) {
  const XmlElement* child = element.only(name);
  return child == nullptr ? "" : std::string(trimmed(child->text, kXmlBlanks));
}

bool has_token(std::string_view list, std::string_view token) {
  const auto tokens = split_xml_list(list);
  return std::ranges::find(tokens, token) != tokens.end();
}

/// Returns the version if it is a DCC's: "3.2.1" → {3, 2}.
std::optional<std::pair<int, int>> parse_version(std::string_view text) {
  int major = 0, minor = 0;
  const char* const end = text.data() + text.size();
  const auto [dot, error] = std::from_chars(text.data(), end, major);
  if (error != std::errc{} || dot == end || *dot != '.') return std::nullopt;
  const auto after = std::from_chars(dot + 1, end, minor);
  if (after.ec != std::errc{} || (after.ptr != end && *after.ptr != '.')) return std::nullopt;
  return std::pair(major, minor);
}

/// What a quantity of a table means.
enum class Role { error, correction, reference, indicated, nominal };
constexpr std::array<std::pair<std::string_view, Role>, 5> kRoles{{{"measurementError", Role::error},
                                                                   {"correction", Role::correction},
                                                                   {"referenceValue", Role::reference},
                                                                   {"measuredValue", Role::indicated},
                                                                   {"nominalValue", Role::nominal}}};

bool is_difference(Role role) { return role == Role::error || role == Role::correction; }

/// Returns the role of a refType, which is a list of tokens; nothing if there is none.
std::optional<Role> find_role(std::string_view ref_type) {
  for (const auto& token : split_xml_list(ref_type))
    for (const std::string_view vocabulary : {"basic_", "temperature_"})
      for (const auto& [name, role] : kRoles)
        if (token.starts_with(vocabulary) && token.substr(vocabulary.size()) == name) return role;
  return std::nullopt;
}

bool is_before_adjustment(const XmlElement& element) {
  return has_token(element.attribute("refType"), "basic_beforeAdjustment");
}

/// The quantities of one table, row by row.
struct ResultTable {
  std::map<Role, std::vector<TemperatureValue>> columns{};
  const XmlElement* element = nullptr;
  /// A quantity that is not a temperature.
  const XmlElement* other = nullptr;
  std::string other_unit{};
};

class CertificateContents {
 public:
  CertificateContents(const XmlElement& dcc, std::string file, std::string serial_number)
      : dcc_(dcc), file_(std::move(file)), serial_number_(std::move(serial_number)) {}

  Result<TemperatureCertificate> read() && {
    const XmlElement* data = dcc_.only("administrativeData");
    const XmlElement* core = data == nullptr ? nullptr : data->only("coreData");
    if (core == nullptr) return refused(dcc_, "has no administrative data");
    if (auto done = read_core(*core); !done) return failure(done.error());
    if (auto done = read_due(*data); !done) return failure(done.error());
    const XmlElement* laboratory = data->only("calibrationLaboratory");
    const XmlElement* contact = laboratory == nullptr ? nullptr : laboratory->only("contact");
    const XmlElement* name = contact == nullptr ? nullptr : contact->only("name");
    if (name != nullptr && !name->children.empty())
      found_.issuer = plain(trimmed(name->children.front().text, kXmlBlanks));
    if (found_.issuer.empty()) return refused(*data, "does not name the calibration laboratory");
    if (auto done = select_item(*data); !done) return failure(done.error());
    if (auto done = read_tables(); !done) return failure(done.error());
    return std::move(found_);
  }

 private:
  tl::unexpected<Fault> refused(const XmlElement& at, std::string what) const {
    return failure(FaultKind::bad_file, fmt::format("{}:{}", file_, at.line), std::move(what));
  }

  /// Reads a day, possibly with a time zone. Returns an empty text if the element is missing.
  Result<std::string> read_day_of(const XmlElement& parent, std::string_view name) const {
    const std::string text = child_text(parent, name);
    if (text.empty()) return text;
    const std::string_view zone = std::string_view(text).substr(std::min<std::size_t>(10, text.size()));
    const bool has_zone = zone == "Z" || (zone.size() == 6 && (zone[0] == '+' || zone[0] == '-') && zone[3] == ':');
    const auto day = calendar_day(std::string_view(text).substr(0, 10));
    if (!day || !(zone.empty() || has_zone))
      return refused(*parent.only(name), fmt::format("\"{}\" is not a day", plain(text)));
    return *day;
  }

  Result<void> read_core(const XmlElement& core) {
    found_.number = plain(child_text(core, "uniqueIdentifier"));
    if (found_.number.empty()) return refused(core, "has no number (uniqueIdentifier)");
    auto calibrated = read_day_of(core, "endPerformanceDate"), issued = read_day_of(core, "issueDate");
    if (!calibrated) return failure(calibrated.error());
    if (!issued) return failure(issued.error());
    if (calibrated->empty()) return refused(core, "does not state the day of the calibration (endPerformanceDate)");
    if (!issued->empty() && *issued < *calibrated) return refused(core, "was issued before the end of the calibration");
    found_.calibrated = std::move(*calibrated);
    found_.issued = std::move(*issued);
    return {};
  }

  /// Reads the day of the recalibration.
  Result<void> read_due(const XmlElement& data) {
    const XmlElement* statements = data.only("statements");
    if (statements == nullptr) return {};
    for (const XmlElement* statement : statements->all("statement")) {
      if (!has_token(statement->attribute("refType"), "basic_recalibration")) continue;
      auto due = read_day_of(*statement, "date");
      if (!due) return failure(due.error());
      if (due->empty()) continue;
      if (!found_.due.empty() && found_.due != *due) return refused(*statement, "states two days of recalibration");
      if (*due < found_.calibrated) return refused(*statement, "is due before the day of the calibration");
      found_.due = std::move(*due);
    }
    return {};
  }

  /// Lists an item and the items inside it.
  static void list_items(const XmlElement& item, Elements& all, int& leaves) {
    all.push_back(&item);
    const XmlElement* inside = item.only("subItems");
    const auto parts = inside == nullptr ? Elements{} : inside->all("item");
    if (parts.empty()) ++leaves;
    for (const XmlElement* part : parts) list_items(*part, all, leaves);
  }

  [[nodiscard]] bool has_serial_number(const XmlElement& item) const {
    const XmlElement* identifications = item.only("identifications");
    if (identifications == nullptr) return false;
    return std::ranges::any_of(identifications->all("identification"),
                               [&](const XmlElement* one) { return child_text(*one, "value") == serial_number_; });
  }

  /// Selects the item whose results are read. If there are several, its id must occur at its results.
  Result<void> select_item(const XmlElement& data) {
    const XmlElement* items = data.only("items");
    Elements all;
    int leaves = 0;
    if (items != nullptr)
      for (const XmlElement* item : items->all("item")) list_items(*item, all, leaves);
    if (all.empty()) return refused(data, "does not name the item that was calibrated");
    if (serial_number_.empty() && leaves > 1)
      return refused(*items, fmt::format("has {} items; state the serial_number of the thermometer", leaves));
    if (!serial_number_.empty()) std::erase_if(all, [&](const XmlElement* one) { return !has_serial_number(*one); });
    if (all.empty())
      return refused(*items,
                     fmt::format("is for another item: none has the serial number \"{}\"", plain(serial_number_)));
    if (!serial_number_.empty() && all.size() > 1 && leaves > 1)
      return refused(*items,
                     fmt::format("has {} items with the serial number \"{}\"", all.size(), plain(serial_number_)));
    is_one_of_several_ = leaves > 1;
    item_id_ = all.front()->attribute("id");
    return {};
  }

  [[nodiscard]] bool refers_to_item(const XmlElement& element) const {
    return !item_id_.empty() && has_token(element.attribute("refId"), item_id_);
  }

  Result<void> read_tables() {
    const XmlElement* results = dcc_.only("measurementResults");
    if (results == nullptr) return refused(dcc_, "has no results");
    for (const XmlElement* result : results->all("measurementResult"))
      if (const XmlElement* lists = result->only("results"))
        for (const XmlElement* one : lists->all("result"))
          if (auto done = read_result(*one, !is_one_of_several_ || refers_to_item(*result)); !done) return done;
    if (found_.points.empty() && has_unassigned_)
      return refused(*results, "has several items and does not state which results belong to the thermometer (refId)");
    if (found_.points.empty() && other_ != nullptr) return refused(*other_, unit_refusal(other_unit_));
    if (found_.points.empty())
      return refused(*results, "has no measurement error, correction, or pair of indicated and reference temperature");
    return {};
  }

  Result<void> read_result(const XmlElement& result, bool belongs) {
    const XmlElement* data = result.only("data");
    if (data == nullptr || is_before_adjustment(result)) return {};
    return read_table(*data, belongs || refers_to_item(result));
  }

  static std::string unit_refusal(const std::string& unit) {
    return fmt::format("has the unit {}, expected \\degreecelsius or \\kelvin", plain(unit));
  }

  /// Reads the quantities of a table, and the tables inside it.
  Result<void> read_table(const XmlElement& element, bool belongs) {
    ResultTable table{.element = &element};
    for (const XmlElement& child : element.children) {
      if (child.space != kDccSpace || is_before_adjustment(child)) continue;
      const bool child_belongs = belongs || refers_to_item(child);
      if (child.name == "list")
        if (auto done = read_table(child, child_belongs); !done) return done;
      const auto role = child.name == "quantity" ? find_role(child.attribute("refType")) : std::nullopt;
      if (!role) continue;
      if (!child_belongs) {
        has_unassigned_ = true;
        continue;
      }
      if (auto done = add_column(child, *role, table); !done) return done;
    }
    if (table.columns.empty()) {
      if (table.other != nullptr && other_ == nullptr)
        std::tie(other_, other_unit_) = std::pair(table.other, table.other_unit);
      return {};
    }
    if (table.other != nullptr) return refused(*table.other, unit_refusal(table.other_unit));
    return add_points(table);
  }

  Result<void> add_column(const XmlElement& quantity, Role role, ResultTable& table) {
    auto read = read_temperatures(quantity, file_, is_difference(role));
    if (!read) return failure(read.error());
    if (!read->other_unit.empty()) {
      table.other = &quantity;
      table.other_unit = read->other_unit;
      return {};
    }
    auto& column = table.columns[role];
    column.insert(column.end(), read->values.begin(), read->values.end());
    return {};
  }

  Result<void> add_points(const ResultTable& table) {
    const std::size_t rows = table.columns.begin()->second.size();
    for (const auto& [role, column] : table.columns)
      if (column.size() != rows)
        return refused(*table.element, fmt::format("has a table with {} and {} values", rows, column.size()));
    const auto value = [&](Role role, std::size_t row) -> const TemperatureValue* {
      const auto found = table.columns.find(role);
      return found == table.columns.end() ? nullptr : &found->second[row];
    };
    const bool has_error = table.columns.contains(Role::error) || table.columns.contains(Role::correction);
    const bool has_pair = table.columns.contains(Role::reference) && table.columns.contains(Role::indicated);
    if (!has_error && !has_pair) return {};
    for (std::size_t row = 0; row < rows; ++row) {
      const TemperatureValue *error = value(Role::error, row), *correction = value(Role::correction, row);
      const TemperatureValue *reference = value(Role::reference, row), *indicated = value(Role::indicated, row);
      const TemperatureValue* at = indicated ? indicated : reference ? reference : value(Role::nominal, row);
      if (at == nullptr) return refused(*table.element, "does not state the temperatures at which it was calibrated");
      std::vector<double> corrections;
      if (error != nullptr) corrections.push_back(-error->value);
      if (correction != nullptr) corrections.push_back(correction->value);
      if (has_pair) corrections.push_back(reference->value - indicated->value);
      auto stated = has_error ? stated_uncertainty(error, correction) : combined_uncertainty(reference, indicated);
      if (!stated) return refused(*table.element, "does not state the uncertainty U of each value");
      const auto [least, most] = std::ranges::minmax(corrections);
      if (most - least > std::min(stated->expanded, kLargestRounding))
        return refused(*table.element, fmt::format("contradicts itself: its values give corrections of {:g} and {:g} K "
                                                   "at {:g} °C",
                                                   least, most, at->value));
      found_.points.push_back({.at_c = at->value,
                               .correction_k = corrections.front(),
                               .expanded_k = stated->expanded,
                               .coverage_factor = stated->coverage_factor});
    }
    return {};
  }

  static std::optional<ExpandedUncertainty> stated_uncertainty(const TemperatureValue* error,
                                                               const TemperatureValue* correction) {
    if (error != nullptr && error->uncertainty) return error->uncertainty;
    return correction == nullptr ? std::nullopt : correction->uncertainty;
  }

  /// Returns the uncertainty of the difference of two values, which are independent if both have one.
  static std::optional<ExpandedUncertainty> combined_uncertainty(const TemperatureValue* reference,
                                                                 const TemperatureValue* indicated) {
    const auto &a = reference->uncertainty, &b = indicated->uncertainty;
    if (!a || !b) return a ? a : b;
    const double k = std::max(a->coverage_factor, b->coverage_factor);
    return ExpandedUncertainty{k * std::hypot(a->expanded / a->coverage_factor, b->expanded / b->coverage_factor), k};
  }

  const XmlElement& dcc_;
  std::string file_, serial_number_;
  bool is_one_of_several_ = false, has_unassigned_ = false;
  std::string item_id_;
  const XmlElement* other_ = nullptr;
  std::string other_unit_;
  TemperatureCertificate found_;
};

/// Fails with bad_file at the second of two elements that have the same id. References in such a document are ambiguous
/// (XML 1.0, 3.3.1). DCC writes the attribute as `id`, XML signatures as `Id`.
Result<void> check_ids(const XmlElement& element, const std::string& file, std::map<std::string, std::int64_t>& lines) {
  for (const auto& [name, value] : element.attributes) {
    if (name != "id" && name != "Id" && name != "ID" && name != "xml:id") continue;
    const auto [first, is_new] = lines.emplace(trimmed(value, kXmlBlanks), element.line);
    if (!is_new)
      return failure(FaultKind::bad_file, fmt::format("{}:{}", file, element.line),
                     fmt::format("has the id \"{}\" of the element in line {}, expected an id that occurs once",
                                 plain(first->first), first->second));
  }
  for (const XmlElement& child : element.children)
    if (auto unique = check_ids(child, file, lines); !unique) return unique;
  return {};
}

Result<void> check_ids(const XmlElement& root, const std::string& file) {
  std::map<std::string, std::int64_t> lines;
  return check_ids(root, file, lines);
}

}  // namespace

double TemperatureCertificate::offset_k() const {
  const double sum = std::accumulate(points.begin(), points.end(), 0.0,
                                     [](double so_far, const auto& one) { return so_far + one.correction_k; });
  // Rounding errors of a double must not become an offset.
  return std::round(sum / static_cast<double>(points.size()) / kOffsetResolution) * kOffsetResolution + 0.0;
}

double TemperatureCertificate::standard_uncertainty_k() const {
  const double mean = offset_k();
  double squares = 0;
  for (const CalibrationPoint& one : points) squares += (one.correction_k - mean) * (one.correction_k - mean);
  return std::hypot(most_uncertain().standard_uncertainty_k(), std::sqrt(squares / static_cast<double>(points.size())));
}

const CalibrationPoint& TemperatureCertificate::most_uncertain() const {
  return *std::ranges::max_element(points, {}, &CalibrationPoint::standard_uncertainty_k);
}

double TemperatureCertificate::lowest_c() const { return std::ranges::min(points, {}, &CalibrationPoint::at_c).at_c; }
double TemperatureCertificate::highest_c() const { return std::ranges::max(points, {}, &CalibrationPoint::at_c).at_c; }

Result<XmlElement> read_foreign_dcc(std::string_view dcc, const std::string& file) {
  auto document = read_xml(dcc, file, kLargestForeignDcc);
  if (!document) return failure(document.error());
  XmlElement& root = document->root;
  const auto refused = [&](std::string what) {
    return failure(FaultKind::bad_file, fmt::format("{}:{}", file, root.line), std::move(what));
  };
  if (!root.is(kDccSpace, "digitalCalibrationCertificate"))
    return refused("is not a digital calibration certificate (DCC)");
  const std::string_view stated = root.attribute("schemaVersion");
  const auto version = parse_version(stated);
  if (!version || version->first != 3 || version->second < 0 || version->second > kNewestMinorVersion)
    return refused(fmt::format("is a DCC of version \"{}\", expected 3.0 to 3.{}", plain(stated), kNewestMinorVersion));
  if (auto unique = check_ids(root, file); !unique) return failure(unique.error());
  return std::move(root);
}

std::optional<std::string> find_issue_day(const XmlElement& dcc) {
  const XmlElement* data = dcc.only("administrativeData");
  const XmlElement* core = data == nullptr ? nullptr : data->only("coreData");
  if (core == nullptr) return std::nullopt;
  const std::string issued = child_text(*core, "issueDate"), ended = child_text(*core, "endPerformanceDate");
  return calendar_day((issued.empty() ? ended : issued).substr(0, 10));
}

Result<TemperatureCertificate> read_temperature_certificate(const XmlElement& dcc, const std::string& file,
                                                            const std::string& serial_number) {
  return CertificateContents(dcc, file, serial_number).read();
}

Result<VerifiedCertificate> verify_temperature_certificate(std::string_view dcc, const std::string& file,
                                                           const std::string& serial_number, const Trust& trust) {
  const auto root = read_foreign_dcc(dcc, file);
  if (!root) return failure(root.error());
  Trust on_issue = trust;
  if (!on_issue.on_day)
    if (const auto day = find_issue_day(*root)) on_issue.on_day = day;
  auto signer = verify_foreign_dcc(dcc, *root, file, on_issue);
  if (!signer) return failure(signer.error());
  auto certificate = read_temperature_certificate(*root, file, serial_number);
  if (!certificate) return failure(certificate.error());
  return VerifiedCertificate{std::move(*certificate), std::move(*signer), sha256(std::string(dcc))};
}

}  // namespace gyrotherm::report
