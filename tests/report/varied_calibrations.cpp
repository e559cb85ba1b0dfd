// SPDX-License-Identifier: Apache-2.0
#include "tests/report/varied_calibrations.hpp"

#include <fmt/format.h>

#include <array>
#include <functional>
#include <limits>
#include <random>

#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN(), kNoEnd = std::numeric_limits<double>::infinity();

/// Calls `use` with every text that users write.
void for_each_text(CalibrationReport& report, const std::function<void(std::string&)>& use) {
  for (Party* party : {&report.laboratory, &report.customer})
    for (std::string* text : {&party->name, &party->postal_code, &party->city, &party->email, &party->phone})
      use(*text);
  for (Party* party : {&report.laboratory, &report.customer})
    for (std::string& line : party->address) use(line);
  for (Person& person : report.people) use(person.name), use(person.email);
  if (report.authorised) use(report.authorised->name);
  CalibratedItem& item = report.item;
  for (std::string* text : {&item.name, &item.manufacturer, &item.model, &item.serial_number, &item.customers_number,
                            &report.number, &report.program_version, &report.bias_zero})
    use(*text);
  std::vector<Texts*> both{&item.description, &item.condition, &report.title,       &report.place,
                           &report.method,    &report.remarks, &report.traceability};
  for (Texts& statement : report.statements) both.push_back(&statement);
  for (Influence& influence : report.influences) both.push_back(&influence.name);
  for (auto* other : {&report.replaces, &report.replaced_by})
    if (*other) use((*other)->number), use((*other)->sha256), both.push_back(&(*other)->reason);
  for (Texts* texts : both) use(texts->en), use(texts->de);
  for (Equipment& one : report.equipment)
    for (std::string* text : {&one.channel, &one.name, &one.serial_number, &one.certificate, &one.calibrated, &one.due})
      use(*text);
  for (Deviation& one : report.deviations) use(one.text), use(one.utc), use(one.run);
  for (UsedFile& file : report.files)
    for (std::string* text : {&file.name, &file.id, &file.sha256, &file.program_version, &file.started_utc}) use(*text);
  for (std::string& key : report.missing) use(key);
  for (ReportedBudget& budget : report.budgets) use(budget.run);
  for (ReportedBudget& budget : report.budgets)
    for (model::BudgetRow& row : budget.budget.rows) use(row.of);
  for (ComparedModel& one : report.compared) use(one.inputs), use(one.method);
  for (ResultTable& table : report.results) use(table.detail), use(table.run);
  for (ModelVerification& one : report.verifications) use(one.run), use(one.farthest_term), use(one.verdict.statement);
}

void for_each_axis(CalibrationReport& report, const std::function<void(std::string&)>& use) {
  for (std::string& axis : report.item.axes) use(axis);
  for (ResultTable& one : report.results) use(one.axis);
  for (ReportedBudget& one : report.budgets) use(one.axis);
  for (Conformity& one : report.conformity) use(one.axis);
  for (ComparedModel& one : report.compared) use(one.axis);
  for (ModelVerification& one : report.verifications) use(one.axis);
}

void for_each_value(CalibrationReport& report, const std::function<void(ReportedValue&)>& use) {
  for (ResultTable& table : report.results)
    for (Column& column : table.columns)
      for (ReportedValue& value : column.values) use(value);
  for (Conformity& one : report.conformity) use(one.value);
}

CalibrationReport report_with_texts(const std::string& text) {
  CalibrationReport report = sample_calibration();
  report.statements = {{text, text}};
  for_each_text(report, [&](std::string& one) { one = text; });
  for_each_axis(report, [&](std::string& one) { one += text; });
  return report;
}

CalibrationReport full_report() {
  CalibrationReport report = sample_calibration();
  report.simulated = false;
  return report;
}

CalibrationReport report_without_model() {
  CalibrationReport report = full_report();
  std::erase_if(report.results, [](const ResultTable& table) { return table.stage != Stage::uncompensated; });
  report.budgets.clear();
  report.conformity.clear();
  report.compared.clear();
  return report;
}

CalibrationReport report_with_unnamed_axis() {
  CalibrationReport report = full_report();
  report.item.axes = {""};
  std::erase_if(report.results, [](const ResultTable& table) { return table.axis != "u1.x"; });
  std::erase_if(report.budgets, [](const ReportedBudget& budget) { return budget.axis != "u1.x"; });
  std::erase_if(report.conformity, [](const Conformity& one) { return one.axis != "u1.x"; });
  std::erase_if(report.compared, [](const ComparedModel& one) { return one.axis != "u1.x"; });
  for_each_axis(report, [](std::string& axis) { axis.clear(); });
  return report;
}

CalibrationReport report_with_many_axes() {
  CalibrationReport report = full_report();
  const CalibrationReport one = report_with_unnamed_axis();
  report.item.axes.clear();
  report.results.clear();
  for (int i = 0; i < 24; ++i) {
    const std::string axis = fmt::format("u{}.axis {}", i / 3, i % 3);
    report.item.axes.push_back(axis);
    for (ResultTable table : one.results) {
      table.axis = axis;
      report.results.push_back(std::move(table));
    }
  }
  return report;
}

CalibrationReport report_with_changed_values(const std::function<void(ReportedValue&, int)>& change) {
  CalibrationReport report = full_report();
  int count = 0;
  for_each_value(report, [&](ReportedValue& value) { change(value, count++); });
  return report;
}

CalibrationReport superseded_report() {
  CalibrationReport report = full_report();
  report.state = ReportState::superseded;
  report.replaced_by = OtherReport{"C-2027-0001", std::string(64, 'd'), {"error in the limits", ""}};
  return report;
}

CalibrationReport report_only_in_german() {
  CalibrationReport report = full_report();
  for (Texts* texts : {&report.item.description, &report.item.condition, &report.place, &report.method,
                       &report.traceability, &report.remarks, &report.replaces->reason, &report.influences[1].name})
    texts->en.clear();
  return report;
}

CalibrationReport report_with_unusual_units() {
  CalibrationReport report = full_report();
  report.influences = {{.key = "air_pressure", .unit = "hPa", .low = 990, .high = 1013.25},
                       {.name = {"moon", "Mond"}, .unit = "quarters <of> it", .low = 1, .high = 3},
                       {.key = "tilt", .unit = "′", .low = kNoNumber, .high = kNoEnd},
                       {.key = "magnetic_flux_density", .unit = "µT", .low = -48.5, .high = 49}};
  return report;
}

CalibrationReport report_with_every_verdict() {
  CalibrationReport report = full_report();
  const Conformity one = report.conformity.front();
  report.conformity.clear();
  for (const Verdict verdict :
       {Verdict::pass, Verdict::conditional_pass, Verdict::conditional_fail, Verdict::fail, Verdict::not_known})
    for (const DecisionRule rule : {DecisionRule::simple, DecisionRule::guard_band}) {
      Conformity held = one;
      held.verdict = verdict;
      held.rule = rule;
      if (verdict == Verdict::not_known) held.value = {}, held.probability = kNoNumber, held.run = "none";
      report.conformity.push_back(std::move(held));
    }
  return report;
}

}  // namespace

std::vector<VariedReport> varied_calibrations() {
  std::vector<VariedReport> all;
  const auto add = [&](std::string name, CalibrationReport report, DccOptions options = {}) {
    all.push_back({std::move(name), std::move(report), std::move(options)});
  };
  add("whole", full_report(),
      {.files = {{kCalibrationFile, std::string(64, '1')}, {"report, second edition.pdf", std::string(64, '2')}},
       .pdf = ReadableReport{"report.pdf", std::string("%PDF-1.6\n\0\xff", 11)}});
  all.back().report.logo = Logo{"image/png", "iVBORw0KGgo="};
  add("simulated", sample_calibration());
  add("empty draft", {});
  CalibrationReport draft = sample_calibration();
  draft.state = ReportState::draft;
  draft.authorised.reset();
  draft.missing = {"order.toml: customer.name", "order.toml: laboratory.country"};
  draft.ended = "soon";
  draft.laboratory.country = "Germany";
  add("draft", draft);
  CalibrationReport draft_without_axes;
  draft_without_axes.results = {
      {.group = Group::bias, .key = "stabilised_bias", .columns = {{"bias", "°/h", {{}, {}}}}}};
  add("draft of nothing known", draft_without_axes);
  const std::string hostile = " \"'<script>alert(1)</script>&amp;]]><!-- \x1b[31m \xff\xfe \u202e \uFFFF\r\n\t%s {} ";
  add("hostile", report_with_texts(hostile));
  add("long", report_with_texts(std::string(300, 'W')));
  add("Chinese", report_with_texts("陀螺仪温度补偿 校准证书 " + std::string(20, 'x')));
  add("blank", [] {
    CalibrationReport report = report_with_texts(" \t\n");
    report.state = ReportState::draft;
    return report;
  }());
  add("without model", report_without_model());
  add("one axis", report_with_unnamed_axis());
  add("many axes", report_with_many_axes());
  add("without U", report_with_changed_values([](ReportedValue& value, int) { value = {.value = value.value}; }));
  add("half known", report_with_changed_values([](ReportedValue& value, int i) {
        if (i % 3 == 0) value.value = kNoNumber;
        if (i % 5 == 0) value.standard_uncertainty = kNoNumber;
        if (i % 7 == 0) value.degrees_of_freedom = kNoEnd;
      }));
  add("extreme", report_with_changed_values([](ReportedValue& value, int i) {
        constexpr std::array kSizes{1e-300, 1e300, -1e-9, 1e17, 0.0, -0.0, 4.9e-324};
        value.value = kSizes[static_cast<std::size_t>(i) % kSizes.size()];
        value.standard_uncertainty = kSizes[static_cast<std::size_t>(i / 2) % kSizes.size()];
        value.coverage_factor = i % 11 == 0 ? 0.3 : 12.7062047;
      }));
  add("superseded", superseded_report());
  add("in German", report_only_in_german());
  add("strange units", report_with_unusual_units());
  add("every verdict", report_with_every_verdict());
  return all;
}

CalibrationReport random_calibration(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto below = [&](std::uint64_t count) { return engine() % count; };
  CalibrationReport report = sample_calibration();
  report.state = below(2) == 0 ? ReportState::draft : ReportState::authorised;
  report.simulated = below(2) == 0;
  for_each_text(report, [&](std::string& text) {
    if (below(4) != 0) return;
    text.clear();
    for (std::uint64_t i = below(40); i > 0; --i) text += static_cast<char>(below(256));
  });
  for_each_value(report, [&](ReportedValue& value) {
    constexpr std::array kOdd{kNoNumber, kNoEnd, -kNoEnd, 0.0, -1.0, 1e-200, 1e200};
    for (double* number :
         {&value.value, &value.standard_uncertainty, &value.coverage_factor, &value.degrees_of_freedom})
      if (below(6) == 0) *number = kOdd[below(kOdd.size())];
  });
  std::erase_if(report.results, [&](const ResultTable&) { return below(3) == 0; });
  std::erase_if(report.conformity, [&](const Conformity&) { return below(3) == 0; });
  std::erase_if(report.item.axes, [&](const std::string&) { return below(3) == 0; });
  if (below(3) == 0) report.replaces.reset();
  if (below(3) == 0) report.equipment.clear();
  if (below(3) == 0) report.files.clear();
  return report;
}

}  // namespace gyrotherm::report
