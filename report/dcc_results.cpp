// SPDX-License-Identifier: Apache-2.0
/// Writes the measurement results of the certificate: methods, equipment, conditions, and the tables of each axis.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/dcc.hpp"
#include "report/dcc_text.hpp"
#include "report/dsi.hpp"
#include "report/stored_texts.hpp"

namespace gyrotherm::report {
namespace {

/// A column of a table in the certificate.
struct DccColumn {
  Texts name;
  std::string ref_type;
  std::string unit;
  std::vector<ReportedValue> values;
  /// Unit of each value, if they differ.
  std::vector<std::string> units{};
};

/// A column of texts.
struct DccTexts {
  Texts name;
  std::string ref_type;
  std::vector<std::string> values;
};

struct DccTable {
  std::vector<DccTexts> text_columns;
  std::vector<DccColumn> columns;
  /// Single values that follow the table.
  std::vector<DccColumn> singles{};
  [[nodiscard]] std::size_t rows() const {
    return !columns.empty()       ? columns.front().values.size()
           : text_columns.empty() ? 0
                                  : text_columns.front().values.size();
  }
};

/// Returns the known parts of each column in a row.
std::vector<Certainty> classify_row(const DccTable& table, std::size_t row) {
  std::vector<Certainty> pattern;
  for (const DccColumn& column : table.columns) pattern.push_back(classify_certainty(column.values[row]));
  return pattern;
}

struct EqualRows {
  std::vector<Certainty> pattern;
  std::vector<std::size_t> rows;
};

/// Groups the rows with equal known parts, in the order of their first row. In a D-SI list all columns have the same
/// number of values, and a value must be a number. Unknown values are therefore not written, and rows with and rows
/// without an unknown value form separate lists.
std::vector<EqualRows> group_rows(const DccTable& table) {
  std::vector<EqualRows> groups;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto pattern = classify_row(table, row);
    auto group = std::ranges::find(groups, pattern, &EqualRows::pattern);
    if (group == groups.end()) group = groups.insert(groups.end(), {pattern, {}});
    group->rows.push_back(row);
  }
  return groups;
}

template <class T>
std::vector<T> at(const std::vector<T>& values, const std::vector<std::size_t>& rows) {
  std::vector<T> picked;
  for (const std::size_t row : rows) picked.push_back(values[row]);
  return picked;
}

Texts record_text(const std::string& run) {
  return run.empty() ? Texts() : Texts{"record " + run, "Aufzeichnung " + run};
}

/// Returns the description of a deviation in both languages.
Texts deviation_text(const Deviation& deviation) {
  if (deviation.text.empty() && deviation.translations.empty()) return {};
  if (!deviation.translations.empty())
    return {text_in(Language::english, deviation.translations), text_in(Language::german, deviation.translations)};
  return {deviation.text, translate_event(Language::german, deviation.kind, deviation.text)};
}

/// Returns the refType of a key. Blanks become underscores because they separate the items of a list.
std::string gyrotherm_type(std::string_view key) {
  std::string type = "gyrotherm_";
  for (const char c : key) type += c == ' ' || c == '\n' || c == '\t' ? '_' : c;
  return type;
}

std::string quantity_type(const std::string& quantity) {
  if (quantity == "set_point") return "basic_nominalValue " + gyrotherm_type(quantity);
  return "basic_measuredValue " + gyrotherm_type(quantity);
}

std::string stage_type(Stage stage) {
  switch (stage) {
    case Stage::uncompensated: return "gyrotherm_uncompensated";
    case Stage::as_found: return "basic_beforeAdjustment gyrotherm_as_found";
    case Stage::as_left: return "basic_afterAdjustment gyrotherm_as_left";
  }
  return "";
}

class MeasurementResults {
 public:
  explicit MeasurementResults(DccText& dcc) : report_(dcc.report()), dcc_(dcc), xml_(dcc.xml()) {}

  void write() {
    xml_.element("dcc:measurementResults", [&] {
      xml_.element("dcc:usedMethods", [&] { methods(); });
      xml_.element("dcc:usedSoftware", [&] { software(); });
      if (!report_.equipment.empty()) xml_.element("dcc:measuringEquipments", [&] { equipment(); });
      if (!report_.influences.empty()) xml_.element("dcc:influenceConditions", [&] { influences(); });
      if (!report_.files.empty()) xml_.element("dcc:measurementMetaData", [&] { files(); });
      for (const std::string& axis : axes()) axis_result(axis);
    });
  }

 private:
  // All axes

  void methods() {
    xml_.element("dcc:usedMethod", {{"refType", "gyrotherm_method"}}, [&] {
      dcc_.text("dcc:name", {"Bias of a gyro at rest over temperature",
                             "Nullpunktabweichung eines ruhenden Kreisels "
                             "über der Temperatur"});
      if (!report_.method.empty()) dcc_.text("dcc:description", report_.method);
      xml_.leaf("dcc:norm", "IEEE Std 952-2020, 6.6");
      xml_.element("dcc:usedMethodQuantities", [&] {
        dcc_.quantity(texts_for("label.cluster_length"), "gyrotherm_clusterLength", "s",
                      {{.value = report_.cluster_length_s}}, "dcc:usedMethodQuantity");
      });
    });
    method("gyrotherm_biasZero", texts_for("label.bias_zero"), join_texts(bias_zero(), ". ", texts_for("say.bias")),
           {});
    method("gyrotherm_stages", texts_for("column.stage"), texts_for("say.stages"), {});
    method("basic_methodMeasurementUncertainty", texts_for("heading.uncertainty"), texts_for("say.coverage"),
           "JCGM 100:2008");
    method("gyrotherm_decisionRule", texts_for("label.rule"),
           texts_for(report_.rule == DecisionRule::simple ? "say.rule_simple" : "say.rule_guard_band"),
           "ILAC-G8:09/2019");
    for (const Deviation& deviation : report_.deviations) deviation_method(deviation);
  }

  void method(const char* ref_type, const Texts& name, const Texts& description, const std::string& norm) {
    xml_.element("dcc:usedMethod", {{"refType", ref_type}}, [&] {
      dcc_.text("dcc:name", name);
      dcc_.text("dcc:description", description);
      if (!norm.empty()) xml_.leaf("dcc:norm", norm);
    });
  }

  /// Writes a deviation from the method (ISO/IEC 17025:2017, 7.8.2.1 n).
  void deviation_method(const Deviation& deviation) {
    xml_.element("dcc:usedMethod", {{"refType", "gyrotherm_deviation " + gyrotherm_type(deviation.kind)}}, [&] {
      dcc_.text("dcc:name", texts_or_key(deviation.kind));
      Texts description = deviation_text(deviation);
      if (const Texts record = record_text(deviation.run); !record.empty())
        description = description.empty() ? record : join_texts(record, ": ", description);
      if (!deviation.utc.empty())
        description =
            description.empty() ? same_text(deviation.utc) : join_texts(same_text(deviation.utc), ": ", description);
      if (!description.empty()) dcc_.text("dcc:description", description);
      if (!std::isfinite(deviation.seconds)) return;
      xml_.element("dcc:usedMethodQuantities", [&] {
        dcc_.quantity(texts_for("duration"), "gyrotherm_duration", "s", {{.value = deviation.seconds}},
                      "dcc:usedMethodQuantity");
      });
    });
  }

  Texts bias_zero() const {
    if (!report_.bias_zero.empty()) return texts_or_key(report_.bias_zero);
    Texts zeros;
    for (const BiasReference& one : report_.bias_zeros) {
      const Texts zero = join_texts(same_text(fmt::format("{}, {}", one.axis, one.run)), ": ", texts_or_key(one.zero));
      zeros = zeros.empty() ? zero : join_texts(zeros, "; ", zero);
    }
    return zeros.empty() ? texts_for("label.not_given") : zeros;
  }

  void software() {
    xml_.element("dcc:software", [&] {
      dcc_.proper_name("dcc:name", "gyrotherm");
      xml_.leaf("dcc:release", text_or_not_given(report_.program_version));
      xml_.leaf("dcc:type", "application");
      dcc_.text("dcc:description", texts_for("say.source_file", text_or_not_given(report_.program_version)));
    });
  }

  void equipment() {
    for (const Equipment& one : report_.equipment)
      xml_.element("dcc:measuringEquipment", {{"refType", equipment_type(one)}}, [&] {
        dcc_.proper_name("dcc:name", one.name);
        dcc_.text("dcc:description", equipment_state(one));
        if (!one.certificate.empty()) xml_.element("dcc:certificate", [&] { certificate(one); });
        if (!one.serial_number.empty() || !one.channel.empty())
          xml_.element("dcc:identifications", [&] { identifications(one); });
        if (std::isfinite(one.standard_uncertainty_k) || std::isfinite(one.drift_k_in_a_year))
          xml_.element("dcc:measuringEquipmentQuantities", [&] { equipment_uncertainty(one); });
      });
  }

  static std::string equipment_type(const Equipment& one) {
    const bool is_standard = one.role == "thermometer" || one.role == "reference";
    return (is_standard ? "basic_measurementStandard " : "") + gyrotherm_type(one.role);
  }

  static Texts equipment_state(const Equipment& one) {
    Texts text = texts_or_key(one.role);
    if (!one.calibrated.empty())
      text = join_texts(text, "; ", join_texts(texts_for("column.calibrated"), " ", same_text(one.calibrated)));
    if (!one.due.empty()) text = join_texts(text, "; ", join_texts(texts_for("column.due"), " ", same_text(one.due)));
    return one.overdue ? join_texts(text, "; ", texts_for("label.overdue")) : text;
  }

  /// Writes a reference to the instrument's certificate. The schema requires a hash, which only a certificate file has.
  void certificate(const Equipment& one) {
    dcc_.text("dcc:referral", texts_for("column.certificate"));
    xml_.leaf("dcc:referralID", text_or_not_given(one.certificate));
    xml_.leaf("dcc:procedure", one.certificate_sha256.empty() ? "not given" : "SHA-256");
    xml_.leaf("dcc:value", text_or_not_given(one.certificate_sha256));
    xml_.leaf("dcc:inValidityRange", one.overdue ? "false" : "true");
  }

  void identifications(const Equipment& one) {
    if (!one.serial_number.empty())
      dcc_.identification("manufacturer", one.serial_number, texts_for("label.serial_number"),
                          {{"refType", "basic_serialNumber"}});
    if (!one.channel.empty()) dcc_.identification("other", one.channel, texts_for("column.channel"));
  }

  void equipment_uncertainty(const Equipment& one) {
    const auto kelvins = [&](const Texts& name, const char* ref_type, double value) {
      if (std::isfinite(value))
        dcc_.quantity(name, ref_type, "K", {{.value = value}}, "dcc:measuringEquipmentQuantity");
    };
    kelvins({"Standard uncertainty of its calibration (k = 1)", "Standardmessunsicherheit der Kalibrierung (k = 1)"},
            "gyrotherm_standardUncertainty", one.standard_uncertainty_k);
    kelvins({"Standard uncertainty of its drift in a year (k = 1)",
             "Standardmessunsicherheit der Drift in einem Jahr (k = 1)"},
            "gyrotherm_driftInAYear", one.drift_k_in_a_year);
  }

  void influences() {
    for (const Influence& influence : report_.influences) {
      const std::string type = influence_type(influence.key);
      xml_.element("dcc:influenceCondition", {{"refType", type}}, [&] {
        dcc_.text("dcc:name",
                  influence.key.empty() && !influence.name.empty() ? influence.name : texts_or_key(influence.key));
        xml_.element("dcc:data", [&] {
          bound(texts_for("column.low"), type + "Min", influence.unit, influence.low);
          bound(texts_for("column.high"), type + "Max", influence.unit, influence.high);
        });
      });
    }
  }

  static std::string influence_type(const std::string& key) {
    if (key.ends_with("_temperature")) return "basic_temperature";
    if (key == "relative_humidity") return "basic_humidityRelative";
    return key.empty() ? "gyrotherm_influence" : gyrotherm_type(key);
  }

  void bound(const Texts& name, const std::string& ref_type, const std::string& unit, double value) {
    std::isfinite(value) ? dcc_.quantity(name, ref_type, unit, {{.value = value}})
                         : dcc_.quantity_as_text(name, ref_type, unit, value);
  }

  void files() {
    for (const UsedFile& file : report_.files)
      xml_.element("dcc:metaData", {{"refType", "gyrotherm_file " + gyrotherm_type(file.role)}}, [&] {
        dcc_.text("dcc:name", texts_or_key(file.role));
        Texts description = same_text(text_or_not_given(file.name));
        const auto add = [&](const Texts& more) {
          if (!more.empty()) description = join_texts(description, "; ", more);
        };
        add(record_text(file.id));
        add(same_text(file.started_utc));
        if (!file.program_version.empty()) add(same_text("gyrotherm " + file.program_version));
        if (file.role == "record")
          add(file.chain_verified ? Texts{"chain verified", "Kette geprüft"}
                                  : Texts{"chain not verified", "Kette nicht geprüft"});
        dcc_.text("dcc:description", description);
        if (!file.sha256.empty()) xml_.leaf("dcc:reference", "SHA-256 " + file.sha256);
      });
  }

  // One axis

  /// Returns the axes of the item and of all results; at least one.
  std::vector<std::string> axes() const {
    std::vector<std::string> all = report_.item.axes;
    const auto add = [&](const std::string& axis) {
      if (std::ranges::find(all, axis) == all.end()) all.push_back(axis);
    };
    for (const ResultTable& table : report_.results) add(table.axis);
    for (const ReportedBudget& budget : report_.budgets) add(budget.axis);
    for (const ComparedModel& model : report_.compared) add(model.axis);
    for (const Conformity& one : report_.conformity) add(one.axis);
    if (all.empty()) all.emplace_back();
    return all;
  }

  void axis_result(const std::string& axis) {
    const auto place = std::ranges::find(report_.item.axes, axis) - report_.item.axes.begin();
    const bool is_item = place < std::ssize(report_.item.axes) && !axis.empty();
    xml_.element("dcc:measurementResult", {{"refId", is_item ? fmt::format("axis-{}", place + 1) : "item"}}, [&] {
      dcc_.text("dcc:name",
                axis.empty() ? texts_for("heading.results_of") : texts_for("heading.axis", text_or_not_given(axis)));
      xml_.element("dcc:results", [&] { axis_results(axis); });
      if (std::ranges::find(report_.conformity, axis, &Conformity::axis) != report_.conformity.end())
        xml_.element("dcc:measurementMetaData", [&] {
          for (const Conformity& one : report_.conformity)
            if (one.axis == axis) write_conformity(dcc_, one, find_result_id(one));
        });
    });
  }

  void axis_results(const std::string& axis) {
    bool any = false;
    const auto result = [&](const std::string& id, const std::string& ref_type, const Texts& name,
                            const Texts& description, const DccTable& content) {
      any = true;
      xml_.element("dcc:result", {{"id", id}, {"refType", ref_type}}, [&] {
        dcc_.text("dcc:name", name);
        if (!description.empty()) dcc_.text("dcc:description", description);
        xml_.element("dcc:data", [&] { table(content); });
      });
    };
    for (std::size_t i = 0; i < report_.results.size(); ++i)
      if (const ResultTable& one = report_.results[i]; one.axis == axis)
        result(fmt::format("result-{}", i + 1), gyrotherm_type(one.key) + " " + stage_type(one.stage), result_name(one),
               describe_result(one), make_table(one));
    for (const ReportedBudget& budget : report_.budgets)
      if (budget.axis == axis)
        result("", "gyrotherm_uncertaintyBudget " + stage_type(budget.stage),
               join_texts({"Uncertainty budget", "Unsicherheitsbudget"}, ", ", texts_for(name(budget.stage))),
               describe_result(budget), make_table(budget));
    if (const DccTable models = compared_models(axis); models.rows() > 0)
      result("", "gyrotherm_comparedModels",
             Texts{"Comparison of models on the same record", "Modelle auf derselben Aufzeichnung"},
             texts_for(models_text_key(report_.compared)), models);
    if (!any) no_results();
  }

  void no_results() {
    xml_.element("dcc:result", [&] {
      dcc_.text("dcc:name", texts_for("heading.results"));
      xml_.element("dcc:data", [&] { dcc_.text("dcc:text", texts_for("say.no_results")); });
    });
  }

  static Texts result_name(const ResultTable& one) {
    const Texts key = texts_or_key(one.key);
    return join_texts(one.detail.empty() ? key : join_texts(key, " ", same_text(one.detail)), ", ",
                      texts_for(name(one.stage)));
  }

  static Texts describe_result(const ResultTable& one) {
    const Texts run = record_text(one.run);
    if (!one.in_sample) return run;
    return join_texts(run, run.empty() ? "" : "; ",
                      {"the model was fitted to this record: not a verification",
                       "das Modell wurde an diese Aufzeichnung angepasst: kein Nachweis seiner Güte"});
  }

  static Texts describe_result(const ReportedBudget& budget) {
    const Texts run = record_text(budget.run);
    return join_texts(run, run.empty() ? "" : "; ", texts_for("say.budget"));
  }

  static DccTable make_table(const ResultTable& one) {
    DccTable table;
    for (const Column& column : one.columns)
      table.columns.push_back(
          {texts_or_key(column.quantity), quantity_type(column.quantity), column.unit, column.values});
    return table;
  }

  static DccTable make_table(const ReportedBudget& budget) {
    const auto whole = model::combined(budget.budget.rows);
    DccTexts source{texts_for("column.source"), "gyrotherm_source", {}},
        of{texts_for("column.channel"), "gyrotherm_of", {}}, type{texts_for("column.type"), "gyrotherm_evaluation", {}},
        distribution{texts_for("column.distribution"), "gyrotherm_distribution", {}},
        basis{texts_for("label.assumed"), "gyrotherm_assumed", {}},
        freedom{texts_for("column.nu_i"), "gyrotherm_degreesOfFreedom", {}};
    DccColumn uncertainty{texts_for("column.u_i"), "gyrotherm_standardUncertainty", "1", {}},
        sensitivity{texts_for("column.c_i"), "gyrotherm_sensitivity", "1", {}},
        contribution{texts_for("column.u_i_y"), "gyrotherm_contribution", "°/h", {}};
    for (const model::BudgetRow& row : budget.budget.rows) {
      source.values.emplace_back(name(row.source));
      of.values.push_back(row.of.empty() ? "-" : row.of);
      type.values.emplace_back(name(row.evaluation));
      distribution.values.emplace_back(name(row.distribution));
      basis.values.emplace_back(row.assumed ? "yes" : row.chosen_on_these_folds ? "chosen_on_these_folds" : "no");
      const std::string unit = row_unit(row);
      uncertainty.values.push_back({.value = row.standard_uncertainty});
      uncertainty.units.push_back(unit);
      sensitivity.units.push_back(sensitivity_unit(unit));
      sensitivity.values.push_back({.value = row.sensitivity});
      contribution.values.push_back({.value = contribution_deg_per_h(row)});
      const bool finite = std::isfinite(row.degrees_of_freedom);
      freedom.values.push_back(finite ? dsi_number(row.degrees_of_freedom) : "infinite");
    }
    return {{source, of, type, distribution, basis, freedom},
            {uncertainty, sensitivity, contribution},
            {{{"Averaging time", "Mittelungsdauer"},
              "gyrotherm_averagingTime",
              "s",
              {{.value = budget.budget.averaging_s}}},
             {texts_for("budget.combined"),
              "gyrotherm_combinedStandardUncertainty",
              "°/h",
              {{.value = whole.standard_deg_per_h}}},
             {{"Expanded uncertainty U", "Erweiterte Messunsicherheit U"},
              "gyrotherm_expandedUncertainty",
              "°/h",
              {{.value = whole.expanded_deg_per_h}}},
             {{"Coverage factor k", "Erweiterungsfaktor k"},
              "gyrotherm_coverageFactor",
              "1",
              {{.value = whole.coverage_factor}}}}};
  }

  DccTable compared_models(const std::string& axis) const {
    DccTexts inputs{texts_for("column.inputs"), "gyrotherm_inputs", {}},
        method{texts_for("column.method"), "gyrotherm_modelMethod", {}},
        roles_text{texts_for("column.model_role"), "gyrotherm_standing", {}};
    DccColumn rmse{texts_for("rmse"), "gyrotherm_rmse", "°/h", {}}, std{texts_for("std"), "gyrotherm_std", "°/h", {}},
        expanded{same_text("U"), "gyrotherm_expandedUncertainty", "°/h", {}};
    for (const ComparedModel& model : report_.compared) {
      if (model.axis != axis) continue;
      std::vector<const char*> roles;
      if (model.left) roles.push_back("left");
      if (model.recommended) roles.push_back("recommended");
      if (model.simple) roles.push_back("simple");
      inputs.values.push_back(model.inputs);
      method.values.push_back(model.method);
      roles_text.values.push_back(roles.empty() ? "-" : fmt::format("{}", fmt::join(roles, ",")));
      rmse.values.push_back({.value = model.rmse_deg_per_h});
      std.values.push_back({.value = model.std_deg_per_h});
      expanded.values.push_back({.value = model.expanded_deg_per_h});
    }
    return {.text_columns = {inputs, method, roles_text}, .columns = {rmse, std, expanded}};
  }

  // Tables

  void table(const DccTable& table) {
    bool any = false;
    for (const EqualRows& group : group_rows(table)) {
      const bool known = !std::ranges::all_of(group.pattern, [](Certainty one) { return one == Certainty::nothing; });
      if (!known && table.text_columns.empty()) continue;
      any = true;
      xml_.element("dcc:list", {{"refType", "basic_measurementTable"}}, [&] { list(table, group); });
    }
    for (const DccColumn& one : table.singles)
      if (classify_certainty(one.values.front()) != Certainty::nothing)
        dcc_.quantity(one.name, one.ref_type, one.unit, one.values);
    if (!any) dcc_.text("dcc:text", texts_for("label.not_known"));
  }

  void list(const DccTable& table, const EqualRows& group) {
    Texts unknown;
    for (std::size_t i = 0; i < table.columns.size(); ++i)
      if (group.pattern[i] == Certainty::nothing)
        unknown = unknown.empty() ? table.columns[i].name : join_texts(unknown, ", ", table.columns[i].name);
    if (!unknown.empty()) dcc_.text("dcc:description", join_texts(texts_for("label.not_known"), ": ", unknown));
    for (const DccTexts& column : table.text_columns)
      dcc_.quantity_of_texts(column.name, column.ref_type, at(column.values, group.rows));
    for (std::size_t i = 0; i < table.columns.size(); ++i)
      if (const DccColumn& column = table.columns[i]; group.pattern[i] != Certainty::nothing)
        column.units.empty()
            ? dcc_.quantity(column.name, column.ref_type, column.unit, at(column.values, group.rows))
            : dcc_.quantity(column.name, column.ref_type, at(column.units, group.rows), at(column.values, group.rows));
  }

  std::string find_result_id(const Conformity& one) const {
    for (std::size_t i = 0; i < report_.results.size(); ++i) {
      const ResultTable& table = report_.results[i];
      const std::string_view quantity = one.quantity;
      const bool is_it = table.axis == one.axis && table.stage == one.stage && table.run == one.run &&
                         quantity.starts_with(table.key + ".") &&
                         find_column(table, quantity.substr(table.key.size() + 1)) != nullptr;
      if (is_it) return fmt::format("result-{}", i + 1);
    }
    return {};
  }

  const CalibrationReport& report_;
  DccText& dcc_;
  XmlText& xml_;
};

/// Returns the name of a limit: "compensated_mean.compensated_bias" becomes "Mean compensated bias, …".
Texts limit_name(const Conformity& one) {
  const auto dot = one.quantity.find('.');
  const std::string key = one.quantity.substr(0, dot);
  const std::string quantity = dot == std::string::npos ? "" : one.quantity.substr(dot + 1);
  const Texts name_of_key = texts_or_key(key);
  return join_texts(quantity.empty() ? name_of_key : join_texts(name_of_key, ": ", texts_or_key(quantity)), ", ",
                    texts_for(name(one.stage)));
}

}  // namespace

const char* dcc_verdict(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass: return "pass";
    case Verdict::conditional_pass: return "conditionalPass";
    case Verdict::conditional_fail: return "conditionalFail";
    case Verdict::fail: return "fail";
    case Verdict::not_known: return "";
  }
  return "";
}

void write_conformity(DccText& dcc, const Conformity& conformity, const std::string& result_id) {
  XmlText& xml = dcc.xml();
  xml.element("dcc:metaData", {{"refId", result_id}, {"refType", "basic_conformity"}}, [&] {
    dcc.text("dcc:name", limit_name(conformity));
    dcc.text("dcc:declaration", join_texts(texts_for(name(conformity.verdict)), ". ",
                                           texts_for(conformity.rule == DecisionRule::simple ? "say.rule_simple"
                                                                                             : "say.rule_guard_band")));
    if (*dcc_verdict(conformity.verdict) != '\0') xml.leaf("dcc:conformity", dcc_verdict(conformity.verdict));
    xml.element("dcc:data", [&] {
      if (classify_certainty(conformity.value) != Certainty::nothing)
        dcc.quantity(texts_for("column.value"), "basic_measuredValue", conformity.unit, {conformity.value});
      const Texts limit = texts_for("column.limit");
      dcc.quantity(limit, "basic_acceptanceLimitUpper", conformity.unit, {{.value = conformity.limit}});
      dcc.quantity(limit, "basic_acceptanceLimitLower", conformity.unit, {{.value = -conformity.limit}});
      if (std::isfinite(conformity.probability))
        dcc.quantity(texts_for("column.probability"), "gyrotherm_probabilityWithin", "1",
                     {{.value = conformity.probability}});
    });
  });
}

void write_measurement_results(DccText& dcc) { MeasurementResults(dcc).write(); }

}  // namespace gyrotherm::report
