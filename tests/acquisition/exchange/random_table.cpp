// SPDX-License-Identifier: Apache-2.0
#include "tests/acquisition/exchange/random_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace gyrotherm::exchange {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Unit {
  const char* name{};
  /// The conversion of a number: °C or °/h = number × scale + offset.
  double scale = 1, offset = 0;
};

/// A notation of an instant, which is given in seconds since 1970 and since the first row.
struct TimeStyle {
  std::string name{};
  /// The titles of its columns.
  std::vector<std::string> titles{};
  /// Returns its cells.
  std::function<std::vector<std::string>(double utc_s, double s)> write{};
  bool tells_utc = false;
};

class TableWriter {
 public:
  explicit TableWriter(std::uint64_t seed) : random_(seed) {}

  RandomTable write() {
    separator_ = pick<char>({',', ';', '\t', ';', ','});
    decimal_ = separator_ == ',' ? '.' : pick<char>({'.', ',', '.'});
    marker_ = pick<std::string>({"-none-", "", "NaN", "---", "OVLD", "-none-", "-none-"});
    digits_ = pick<int>({2, 3, 4});
    const std::size_t rows = 60 + random_() % 200;
    const double step_s = pick<double>({1, 10, 10, 5, 2, 20, 60});
    start_s_ = std::floor(1735689600.0 + static_cast<double>(random_() % 60'000'000));
    const TimeStyle time = time_style(step_s);
    const Unit temperature =
        pick<Unit>({{"degC"}, {"°C"}, {"°C"}, {"K", 1, -273.15}, {"°F", 5.0 / 9, -160.0 / 9}, {"C"}});
    const Unit rate = pick<Unit>({{"deg/h"},
                                  {"°/h"},
                                  {"°/s", 3600},
                                  {"dps", 3600},
                                  {"mdps", 3.6},
                                  {"rad/s", 206264.80624709636},
                                  {"mrad/s", 206.26480624709636},
                                  {"deg/hr"}});
    const std::size_t thermometers = 1 + random_() % 3, axes = pick<std::size_t>({1, 1, 3});
    cell_units_ = chance(12) && separator_ != ' ';
    draw("separator " + std::string(separator_ == '\t' ? "tab" : std::string(1, separator_)) + ", decimal " + decimal_ +
         ", " + time.name + ", step " + fmt::format("{}", step_s) + ", " + temperature.name + ", " + rate.name);
    write_header(time, thermometers, axes, temperature, rate);
    write_rows(time, rows, step_s, thermometers, axes, temperature, rate);
    damage_first_rows();
    return std::move(table_);
  }

 private:
  template <class T>
  T pick(std::initializer_list<T> from) {
    return from.begin()[random_() % from.size()];
  }
  bool chance(unsigned one_in) { return random_() % one_in == 0; }
  double uniform() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  void draw(const std::string& what) { table_.drawn += (table_.drawn.empty() ? "" : ", ") + what; }

  std::string number(double value, int digits) const {
    auto text = fmt::format("{:.{}f}", value, digits);
    if (decimal_ == ',') std::replace(text.begin(), text.end(), '.', ',');
    return text;
  }

  struct Civil {
    int year{}, month{}, day{}, hour{}, minute{}, second{};
  };
  static Civil civil(double utc_s) {
    using std::chrono::floor, std::chrono::days, std::chrono::seconds;
    const std::chrono::sys_seconds at{seconds(std::llround(utc_s))};
    const auto midnight = floor<days>(at);
    const std::chrono::year_month_day date(midnight);
    const std::chrono::hh_mm_ss clock(at - midnight);
    return {int(date.year()),           int(unsigned(date.month())),  int(unsigned(date.day())),
            int(clock.hours().count()), int(clock.minutes().count()), int(clock.seconds().count())};
  }
  static std::string clock(const Civil& c) { return fmt::format("{:02}:{:02}:{:02}", c.hour, c.minute, c.second); }
  static std::string clock_12(const Civil& c) {
    return fmt::format("{}:{:02}:{:02} {}", c.hour % 12 == 0 ? 12 : c.hour % 12, c.minute, c.second,
                       c.hour < 12 ? "AM" : "PM");
  }

  TimeStyle counted(const std::string& title, double units_per_s, int digits) {
    const double from = chance(3) ? 0 : std::floor(1000 * (uniform() + 1));
    return {title, {title}, [this, units_per_s, digits, from](double, double s) {
              return std::vector{number((s + from) * units_per_s, digits)};
            }};
  }
  TimeStyle dated(const std::string& name, std::vector<std::string> titles,
                  std::function<std::vector<std::string>(const Civil&)> write) {
    return {name, std::move(titles), [write](double utc_s, double) { return write(civil(utc_s)); }, true};
  }

  TimeStyle time_style(double step_s) {
    switch (random_() % 18) {
      case 0: return counted(pick<std::string>({"Time [s]", "t (s)", "time_s", "Zeit [s]", "Elapsed [sec]"}), 1, 1);
      case 1: return counted(pick<std::string>({"Time [ms]", "millis", "t_ms"}), 1e3, 0);
      case 2: return counted(pick<std::string>({"Time [us]", "TimeUS", "time (µs)"}), 1e6, 0);
      case 3: return counted(pick<std::string>({"Time [min]", "t (min)", "Elapsed [minutes]"}), 1 / 60.0, 5);
      case 4: return counted(pick<std::string>({"Time [h]", "Time (hours)", "t [hr]"}), 1 / 3600.0, 7);
      case 5: return counted("Time [d]", 1 / 86400.0, 9);
      case 6: return counted("Time", 1, 0);
      case 7:
        return dated("ISO", {"timestamp"}, [](const Civil& c) {
          return std::vector{fmt::format("{}-{:02}-{:02}T{}Z", c.year, c.month, c.day, clock(c))};
        });
      case 8:
        return dated("ISO with a blank", {"Date/Time"}, [](const Civil& c) {
          return std::vector{fmt::format("{}-{:02}-{:02} {}", c.year, c.month, c.day, clock(c))};
        });
      case 9:
        return dated("dd.mm.yyyy", {"Zeit"}, [](const Civil& c) {
          return std::vector{fmt::format("{:02}.{:02}.{} {}", c.day, c.month, c.year, clock(c))};
        });
      case 10:
        return dated("mm/dd/yyyy AM", {"Date"}, [](const Civil& c) {
          return std::vector{fmt::format("{}/{}/{} {}", c.month, c.day, c.year, clock_12(c))};
        });
      case 11:
        return dated("yyyy/mm/dd", {"Date Time"}, [](const Civil& c) {
          return std::vector{fmt::format("{}/{:02}/{:02} {}", c.year, c.month, c.day, clock(c))};
        });
      case 12:
        return dated("compact", {"Stamp"}, [](const Civil& c) {
          return std::vector{
              fmt::format("{}{:02}{:02}T{:02}{:02}{:02}Z", c.year, c.month, c.day, c.hour, c.minute, c.second)};
        });
      case 13:
        return dated("two columns", {"Date", "Time"}, [](const Civil& c) {
          return std::vector{fmt::format("{}-{:02}-{:02}", c.year, c.month, c.day), clock(c)};
        });
      case 14:
        return dated("two columns, German", {"Datum", "Uhrzeit"}, [](const Civil& c) {
          return std::vector{fmt::format("{:02}.{:02}.{}", c.day, c.month, c.year), clock(c)};
        });
      case 15:
        return {"serial date",
                {pick<std::string>({"Date", "Time", "Zeit"})},
                [this](double utc_s, double) { return std::vector{number(utc_s / 86400 + 25569, 9)}; },
                true};
      case 16:
        return {"since 1970",
                {"time"},
                [](double utc_s, double) { return std::vector{fmt::format("{:.0f}", utc_s)}; },
                true};
      default: break;
    }
    if (step_s * 260 > 80'000) return counted("Time [s]", 1, 1);
    return {"time of day", {"Time"}, [](double utc_s, double) { return std::vector{clock(civil(utc_s))}; }, false};
  }

  std::string titled(const std::string& name, const Unit& unit) {
    if (cell_units_) return name;
    return name + pick<std::string>({" [", " ("}) + unit.name;
  }
  static std::string closed(const std::string& title) {
    const auto bracket = title.find_last_of("[(");
    return bracket == std::string::npos ? title : title + (title[bracket] == '[' ? "]" : ")");
  }
  std::string joined(const std::vector<std::string>& cells) const {
    std::string line;
    for (const auto& cell : cells) {
      const bool quotes = cell.find(separator_) != std::string::npos;
      line += (&cell == &cells.front() ? "" : std::string(1, separator_)) + (quotes ? "\"" + cell + "\"" : cell);
    }
    return line;
  }

  void write_header(const TimeStyle& time, std::size_t thermometers, std::size_t axes, const Unit& temperature,
                    const Unit& rate) {
    std::vector<std::string> titles = time.titles;
    const bool duplicates = thermometers > 1 && chance(10);
    for (std::size_t i = 0; i < thermometers; ++i)
      titles.push_back(closed(titled(duplicates ? "Temp" : "T" + std::to_string(i + 1), temperature)));
    for (std::size_t i = 0; i < axes; ++i)
      titles.push_back(closed(titled(axes == 1 ? "Gyro" : fmt::format("gyro_{}", "xyz"[i]), rate)));
    if (duplicates) draw("equal names");
    switch (random_() % 8) {
      case 0:
        draw("preamble");
        table_.text += "Instrument: 34970A\nSerial: 42\nOperator: N. N.\n\n";
        break;
      case 1:
        draw("padded preamble");
        table_.text += "Title" + std::string(titles.size() - 1, separator_) + "\n";
        break;
      case 2:
        draw("comments");
        table_.text += "# made by hand\n# twice\n";
        break;
      default: break;
    }
    trails_ = chance(12);
    if (trails_) draw("trailing separators");
    table_.text += joined(titles) + (trails_ && chance(2) ? std::string(1, separator_) : "") + "\n";
    header_ = joined(titles);
  }

  /// Returns a line that cannot be read.
  std::string damaged_line(const std::string& line) {
    switch (random_() % 4) {
      case 0: return line.substr(0, line.find(separator_) + 1) + "\n";
      case 1: return header_ + "\n";
      case 2: return std::string(1 + random_() % 300, '\0') + "\n";
      default: return line + line + "\n";
    }
  }

  /// Adds unreadable lines before and among the first rows.
  void damage_first_rows() {
    constexpr std::size_t kFirstRows = 6;
    table_.damaged_text = table_.text;
    table_.damaged_in_text = table_.damaged;
    for (std::size_t row = kFirstRows; row-- > 0;) {
      if (row > 0 && chance(2)) continue;
      const auto& later = lines_[lines_.size() / 2 + random_() % 20].text;
      const auto cells = trails_ ? later.substr(0, later.size() - 1) : later;
      const auto damage = chance(2) ? damaged_line(later) : cells + "#\n";
      table_.damaged_text.insert(lines_[row].at, damage);
      ++table_.damaged_in_text;
    }
  }

  void write_rows(const TimeStyle& time, std::size_t rows, double step_s, std::size_t thermometers, std::size_t axes,
                  const Unit& temperature, const Unit& rate) {
    table_.temperatures_c.resize(thermometers);
    table_.rates_deg_per_h.resize(axes);
    if (time.tells_utc) table_.started_utc_s = start_s_;
    const std::size_t damage = chance(5) ? 1 + random_() % 3 : 0;
    const bool has_minus = chance(6);
    const double span = static_cast<double>(rows) * step_s;
    if (damage > 0) draw("damage");
    const double low_c = -20 + 20 * uniform(), high_c = 45 + 10 * uniform(), base = 20 * uniform();
    for (std::size_t i = 0; i < rows; ++i) {
      const double s = static_cast<double>(i) * step_s;
      auto cells = time.write(start_s_ + s, s);
      table_.time_s.push_back(s);
      for (std::size_t t = 0; t < thermometers; ++t) {
        const double c = low_c + (high_c - low_c) * 0.5 * (1 - std::cos(6.28 * s / span)) + static_cast<double>(t);
        cells.push_back(cell(c, temperature, 3, table_.temperatures_c[t], has_minus));
      }
      for (std::size_t a = 0; a < axes; ++a)
        cells.push_back(
            cell(base + 0.1 * static_cast<double>(a) + uniform(), rate, 8, table_.rates_deg_per_h[a], has_minus));
      const auto line = joined(cells) + (trails_ ? std::string(1, separator_) : "");
      if (damage > 0 && i > 10 && i % (rows / (damage + 1)) == 0 && table_.damaged < damage) {
        table_.text += damaged_line(line);
        ++table_.damaged;
      }
      lines_.push_back({table_.text.size(), line});
      table_.text += line + "\n";
    }
  }

  std::string cell(double value, const Unit& unit, int digits, std::vector<double>& truth, bool has_minus) {
    if (marker_ != "-none-" && chance(30)) {
      truth.push_back(kNone);
      return marker_;
    }
    const double raw = (value - unit.offset) / unit.scale;
    auto text = fmt::format("{:.{}f}", raw, digits);
    truth.push_back(std::stod(text) * unit.scale + unit.offset);
    text = number(raw, digits);
    if (has_minus && text.starts_with('-')) text.replace(0, 1, "\xE2\x88\x92");
    return cell_units_ ? text + " " + unit.name : text;
  }

  std::mt19937_64 random_;
  RandomTable table_{};
  char separator_ = ',', decimal_ = '.';
  std::string marker_{}, header_{};
  struct Line {
    std::size_t at{};  ///< first byte in the text
    std::string text{};
  };
  std::vector<Line> lines_{};  ///< readable rows
  int digits_{};
  double start_s_{};
  bool cell_units_ = false, trails_ = false;
};

}  // namespace

RandomTable random_table(std::uint64_t seed) { return TableWriter(seed).write(); }

}  // namespace gyrotherm::exchange
