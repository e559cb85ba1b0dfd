// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/gnuplot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <vector>

#include "acquisition/exchange/export_choice.hpp"
#include "acquisition/exchange/grouping.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

struct Curve {
  std::string name;
  std::vector<double> values{};
};

/// Returns a text in single quotes, in which gnuplot interprets only the quote itself.
std::string quoted_for_gnuplot(std::string_view text) {
  std::string quoted = "'";
  for (const char c : plain(text)) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

std::vector<Curve> temperatures(const record::Record& record) {
  std::vector<Curve> curves{{"set point", record.set_point_c}, {"chamber air", record.chamber_air_c}};
  if (record.info.imported) curves.clear();
  for (std::size_t i = 0; i < record.info.thermometers.size(); ++i)
    curves.push_back({record.info.thermometers[i].name, calibrated_temperatures(record, i)});
  return curves;
}

std::vector<Curve> rates(const record::Record& record) {
  std::vector<Curve> curves;
  for (std::size_t unit = 0; unit < record.info.units.size(); ++unit)
    for (std::size_t axis = 0; axis < record.info.units[unit].axes.size(); ++axis)
      curves.push_back({record::axis_label(record.info.units[unit], axis), axis_rates(record, unit, axis)});
  return curves;
}

/// Returns whether any curve has a point. gnuplot aborts a script at a plot without points.
bool has_point(const std::vector<Curve>& curves) {
  return std::ranges::any_of(curves, [](const Curve& curve) {
    return std::ranges::any_of(curve.values, [](double value) { return std::isfinite(value); });
  });
}

/// Returns the commands for a plot of the columns from `first` on.
std::string plot_commands(const std::vector<Curve>& curves, std::size_t first, std::string_view label) {
  std::string text = fmt::format("set ylabel '{}'\nplot ", label);
  for (std::size_t i = 0; i < curves.size(); ++i)
    text += fmt::format("{}$rows using ($1/3600):{} with lines title {}", i == 0 ? "" : ", \\\n     ", first + i,
                        quoted_for_gnuplot(curves[i].name));
  return text + "\n";
}

/// Finds the rows that follow missing rows. In a record of gyrotherm the usual distance is one step. For an imported
/// record, the import has defined the gaps.
class Gaps {
 public:
  explicit Gaps(const record::Record& record)
      : record_(record), slots_(usual_step(record.slot)), seconds_(usual_step(record.time_s)) {}
  [[nodiscard]] bool has_gap_before(std::size_t row) const {
    if (row == 0) return false;
    if (record_.info.imported) return record_.time_s[row] - record_.time_s[row - 1] > kGapInUsualSteps * seconds_;
    return slots_ > 0 && record_.slot[row] / slots_ - record_.slot[row - 1] / slots_ > 1;
  }

 private:
  const record::Record& record_;
  std::int64_t slots_;
  double seconds_;
};

/// Writes the data. An empty line is a gap, across which gnuplot draws no line.
void add_rows(std::string& text, const record::Record& record, const std::vector<Curve>& curves) {
  const Gaps gaps(record);
  for (std::size_t row = 0; row < record.slot.size(); ++row) {
    if (gaps.has_gap_before(row)) text += '\n';
    fmt::format_to(std::back_inserter(text), "{}", record.time_s[row]);
    for (const Curve& curve : curves)
      if (const double value = curve.values[row]; std::isfinite(value))
        fmt::format_to(std::back_inserter(text), " {}", value);
      else
        text += " NaN";
    text += '\n';
  }
}

}  // namespace

std::string gnuplot_script(const record::Record& record) {
  constexpr std::size_t kFirstColumn = 2;  // after the time
  const auto above = temperatures(record), below = rates(record);
  auto all = above;
  all.insert(all.end(), below.begin(), below.end());
  const auto title = fmt::format("{}{} on {}", is_simulated(record.info) ? "SIMULATED: " : "", record.info.profile_name,
                                 record.info.rig_name);
  std::string text = fmt::format("# run {}; gnuplot -p FILE shows it\n$rows << end_of_rows\n", plain(record.info.id));
  add_rows(text, record, all);
  text += fmt::format(
      "end_of_rows\nset termoption noenhanced\nset multiplot layout {},1 title {}\nset xlabel 'time [h]'\nset grid\n"
      "set key outside right\n",
      has_point(above) && has_point(below) ? 2 : 1, quoted_for_gnuplot(title));
  if (has_point(above)) text += plot_commands(above, kFirstColumn, "temperature [°C]");
  if (has_point(below)) text += plot_commands(below, kFirstColumn + above.size(), "rate [°/h]");
  return text + "unset multiplot\n";
}

}  // namespace gyrotherm::exchange
