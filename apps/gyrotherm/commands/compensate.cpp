// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>

#include "acquisition/exchange/channel_summary.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/schema.hpp"
#include "analysis/model/stream.hpp"
#include "analysis/tracking/bias_tracker.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/bias_tracking.hpp"
#include "apps/gyrotherm/compensation_table.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/count_text.hpp"

namespace gyrotherm::app {
namespace {

struct CompensateArguments {
  std::string model, outside = "continue";
  bool uncertainty = false;
  bool unverified = false;
  data::AxisChoice axis;
  BiasTrackingArguments tracking;
};

/// Returns U, °/h, of a mean whose worst input lies `excess` outside the trained range.
using UncertaintyFunction = std::function<double(double excess)>;

/// Returns one line per row, empty if the row has no value. With `expanded`, U is a second field.
std::string format_rows(const Eigen::VectorXd& values, const UncertaintyFunction& expanded,
                        const Eigen::VectorXd& excess) {
  std::string lines;
  for (Eigen::Index row = 0; row < values.size(); ++row) {
    const bool known = std::isfinite(values(row));
    if (known) fmt::format_to(std::back_inserter(lines), "{:.7f}", values(row));
    if (expanded) lines += ',';
    if (expanded && known) fmt::format_to(std::back_inserter(lines), "{:.7f}", expanded(excess(row)));
    lines += '\n';
  }
  return lines;
}

/// A row with a temperature or bias that no instrument measures.
struct ImpossibleValue {
  Eigen::Index row{};
  std::string text;
};

/// Compensates the rows of standard input and, if requested, tracks their residual bias.
class Compensation {
 public:
  using Noise = std::optional<tracking::BiasNoise>;
  [[nodiscard]] static Result<Compensation> open(const model::Model& model, CompensationTable table,
                                                 model::Outside outside, const Noise& noise,
                                                 const UncertaintyFunction& expanded);

  [[nodiscard]] const CompensationTable& table() const { return table_; }
  /// Prints the compensated bias of each row. Fails with bad_file at a row with a missing slot or a slot that is not
  /// greater than the previous one. The rows before it are printed first.
  [[nodiscard]] Result<void> print_compensated(Console& console, const record::LiveRows& rows);
  [[nodiscard]] long long outside() const { return stream_.outside(); }
  [[nodiscard]] long long missing_s() const { return missing_s_; }

 private:
  Compensation(CompensationTable table, model::CompensationStream stream)
      : table_(std::move(table)), stream_(std::move(stream)) {}

  using Rows = Eigen::Ref<const data::SampleMatrix>;
  [[nodiscard]] Eigen::Index count_rows_in_order(const Rows& rows);
  [[nodiscard]] std::optional<ImpossibleValue> find_impossible(const Rows& rows) const;
  struct Pace {
    Eigen::Index row{};
    double step_s{};
    bool is_averaged{};  ///< the slots are this far apart, too
  };
  [[nodiscard]] std::optional<Pace> find_seconds(const Rows& rows, Eigen::VectorXd& seconds);
  [[nodiscard]] std::string compensate_rows(const Rows& rows, const Eigen::VectorXd& seconds);

  CompensationTable table_;
  model::CompensationStream stream_;
  std::optional<tracking::RestTracker> tracker_;
  UncertaintyFunction expanded_;
  double last_slot_ = -1;
  std::optional<double> late_s_, previous_slot_;  ///< time minus slot, slot
  double shift_s_{};                              ///< accumulated difference of seconds and slots
  long long rows_{}, rows_off_{};                 ///< all rows, irregularly timed rows
  long long missing_s_{};                         ///< seconds without a row
};

Result<Compensation> Compensation::open(const model::Model& model, CompensationTable table, model::Outside outside,
                                        const Noise& noise, const UncertaintyFunction& expanded) {
  auto stream = model::CompensationStream::open(model, table.thermometers(), outside);
  if (!stream) return failure(stream.error());
  Compensation compensation(std::move(table), std::move(*stream));
  compensation.expanded_ = expanded;
  if (noise) {
    const int rows = rows_in_cluster(model);
    compensation.tracker_.emplace(state_space(*noise, rows), rows);
  }
  return compensation;
}

Result<void> Compensation::print_compensated(Console& console, const record::LiveRows& rows) {
  const auto columns = static_cast<Eigen::Index>(rows.columns().size());
  const auto count = static_cast<Eigen::Index>(rows.lines().size());
  const Eigen::Map<const data::SampleMatrix> numbers(rows.numbers().data(), count, columns);
  const Eigen::Index in_order = count_rows_in_order(numbers);
  const auto impossible = find_impossible(numbers.topRows(in_order));
  const Eigen::Index good = impossible ? impossible->row : in_order;
  Eigen::VectorXd seconds;
  if (const auto pace = table_.has_seconds() ? find_seconds(numbers.topRows(good), seconds) : std::nullopt)
    return failure(
        FaultKind::bad_file, fmt::format("stdin:{}:1", rows.lines()[static_cast<std::size_t>(pace->row)]),
        fmt::format("compensate requires one row per second, but these rows are {:g} s apart; {}", pace->step_s,
                    pace->is_averaged ? "export the record without --every" : advice_for_spacing(pace->step_s)));
  if (good > 0) console.print(compensate_rows(numbers.topRows(good), seconds));
  if (good == count) return {};
  if (impossible)
    return failure(FaultKind::bad_file, fmt::format("stdin:{}:1", rows.lines()[static_cast<std::size_t>(good)]),
                   impossible->text);
  const double slot = table_.slot(numbers)(good);
  return failure(
      FaultKind::bad_file, fmt::format("stdin:{}:1", rows.lines()[static_cast<std::size_t>(good)]),
      fmt::format("{}, expected a whole number from {:.0f} to {}",
                  std::isnan(slot) ? "no slot" : fmt::format("slot {:.12g}", slot), last_slot_ + 1, record::kMaxSlots));
}

/// Returns the first row with a value that is impossible. Missing values are possible.
std::optional<ImpossibleValue> Compensation::find_impossible(const Rows& rows) const {
  const auto temperatures = table_.temperatures_c(rows);
  const Eigen::VectorXd bias = table_.bias_deg_per_h(rows);
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    for (Eigen::Index i = 0; i < temperatures.cols(); ++i)
      if (const double t = temperatures(row, i); t < exchange::kAbsoluteZero_c || t > exchange::kHottest_c)
        return ImpossibleValue{row, fmt::format("{} is {:g} °C, which is impossible; expected an empty field for a "
                                                "missing reading",
                                                table_.thermometers()[static_cast<std::size_t>(i)], t)};
    if (std::abs(bias(row)) > exchange::kFastest_deg_per_h)
      return ImpossibleValue{row, fmt::format("the bias is {:g} °/h, which is impossible", bias(row))};
  }
  return std::nullopt;
}

/// Returns the number of leading rows with valid, increasing slots, and remembers the last of these slots.
Eigen::Index Compensation::count_rows_in_order(const Rows& rows) {
  if (!table_.has_seconds()) return rows.rows();
  const Eigen::VectorXd slots = table_.slot(rows);
  Eigen::Index row = 0;
  for (; row < slots.size(); last_slot_ = slots(row++)) {
    const bool is_next =
        slots(row) > last_slot_ && slots(row) <= record::kMaxSlots && std::floor(slots(row)) == slots(row);
    if (!is_next) break;
  }
  return row;
}

/// Computes the second of each row from its slot and the accumulated difference of time and slot. Records of this
/// project have one row per second and skip the slots of missing rows. Imported records number their rows and keep the
/// times of their file. Rows that `export --every` has averaged skip slots throughout. Returns the first row that
/// follows its predecessor by clearly less than a second, or at which at least half of the rows so far are not one
/// second apart; nothing if there is no such row.
std::optional<Compensation::Pace> Compensation::find_seconds(const Rows& rows, Eigen::VectorXd& seconds) {
  constexpr double kOff_s = 0.5;
  constexpr int kMinRowsOff = 3;
  const Eigen::VectorXd slots = table_.slot(rows), times = table_.time_s(rows);
  seconds = slots;
  for (Eigen::Index row = 0; row < seconds.size(); ++row) {
    const double late_s = times(row) - slots(row), more_s = late_s - std::exchange(late_s_, late_s).value_or(late_s);
    const double slot_step = slots(row) - std::exchange(previous_slot_, slots(row)).value_or(slots(row) - 1);
    ++rows_;
    const double step_s = slot_step + more_s;
    if (std::abs(step_s - 1) > kOff_s) {
      const bool are_most = ++rows_off_ >= kMinRowsOff && 2 * rows_off_ >= rows_;
      if (are_most || more_s < -kOff_s) return Pace{row, step_s, slot_step > 1};
    }
    if (std::abs(more_s) > kOff_s) shift_s_ += std::round(more_s);
    seconds(row) += shift_s_;
  }
  return std::nullopt;
}

std::string Compensation::compensate_rows(const Rows& rows, const Eigen::VectorXd& seconds) {
  const data::SampleMatrix temperatures_c = table_.temperatures_c(rows);
  const Eigen::VectorXd bias = table_.bias_deg_per_h(rows);
  Eigen::VectorXd compensated =
      table_.has_seconds() ? stream_.push_at(seconds, temperatures_c, bias) : stream_.push(temperatures_c, bias);
  for (const auto& gap : stream_.gaps()) missing_s_ += gap.seconds;
  if (!tracker_) return format_rows(compensated, expanded_, stream_.excess());
  auto gap = stream_.gaps().begin();
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    if (gap != stream_.gaps().end() && gap->row == row) tracker_->skip_rows((gap++)->seconds);
    compensated(row) -= tracker_->push(compensated(row), table_.is_at_rest(rows, row)).deg_per_h;
  }
  return format_rows(compensated, expanded_, stream_.excess());
}

constexpr std::size_t kMostInput = 1 << 20;
constexpr int kNoTimeout = -1;

/// Returns true if a read would not block: there is input, its end or an error. Returns false once a stop is requested.
bool has_input(int timeout_ms) {
  std::array<pollfd, 2> waits{{{STDIN_FILENO, POLLIN, 0}, {interrupt_descriptor(), POLLIN, 0}}};
  while (::poll(waits.data(), waits.size(), timeout_ms) < 0) {
    if (errno != EINTR || interrupted()) return false;
  }
  return waits[0].revents != 0 && !interrupted();
}

/// Reader of standard input. It returns the available bytes without waiting for a full buffer.
class StandardInput {
 public:
  /// Waits for input, then returns the available bytes, at most one megabyte. Returns an empty text at the end of the
  /// input and after a stop was requested. Fails with storage. The text is valid until the next call.
  [[nodiscard]] Result<std::string_view> next() {
    buffer_.resize(kMostInput);
    std::size_t taken = 0;
    for (int timeout_ms = kNoTimeout; taken < kMostInput && has_input(timeout_ms); timeout_ms = 0) {
      const ssize_t count = ::read(STDIN_FILENO, buffer_.data() + taken, kMostInput - taken);
      if (count == 0) break;
      if (count > 0) {
        taken += static_cast<std::size_t>(count);
      } else if (errno != EINTR && errno != EAGAIN) {
        return failure(FaultKind::storage, "stdin", std::strerror(errno));
      }
    }
    return std::string_view(buffer_.data(), taken);
  }

 private:
  std::string buffer_;
};

/// Opens the compensation of an input, given its header and the comments before the header.
using CompensationFactory = std::function<Result<Compensation>(const std::vector<std::string>& header,
                                                               const std::vector<std::string>& comments)>;

/// Compensates standard input until its end or a stop request: all available rows, then waits for more. Rows that
/// arrive together are processed together, and a single row immediately. Prints `head` before the first row. Sets
/// `compensation` once the header has been read.
Result<void> compensate_input(Console& console, const CompensationFactory& open, std::string_view head,
                              std::optional<Compensation>& compensation) {
  const auto choose = [&](const std::vector<std::string>& header,
                          const std::vector<std::string>& comments) -> Result<std::vector<std::size_t>> {
    auto opened = open(header, comments);
    if (!opened) return failure(opened.error());
    compensation.emplace(std::move(*opened));
    console.print(head);
    return compensation->table().columns();
  };
  StandardInput input;
  record::LiveRows rows("stdin", choose);
  for (bool more = true; more && !console.has_lost_data();) {
    const auto piece = input.next();
    if (!piece) return failure(piece.error());
    more = !piece->empty();
    const auto read = more ? rows.take(*piece) : interrupted() ? Result<void>{} : rows.finish();
    const auto compensated = rows.lines().empty() ? Result<void>{} : compensation->print_compensated(console, rows);
    rows.forget_rows();
    if (!compensated) return failure(compensated.error());
    if (!read) return failure(read.error());
  }
  return {};
}

/// Returns the function that computes U of a mean over the model's cluster length. Returns an empty function if it was
/// not requested. Fails with usage if the model has no budget. The model must outlive the result.
Result<UncertaintyFunction> expanded_uncertainty(const model::Model& model, bool requested) {
  if (!requested) return UncertaintyFunction();
  if (!model.uncertainty)
    return failure(FaultKind::usage, "--uncertainty", "the model has no uncertainty budget; train it again");
  return UncertaintyFunction(
      [&model](double excess) { return expanded_outside(*model.uncertainty, model.cluster_length_s, excess); });
}

/// Describes U of a mean over the model's cluster length. The model must have a budget.
std::string describe_uncertainty(const model::Model& model) {
  const model::CombinedUncertainty combined = mean_uncertainty(*model.uncertainty, model.cluster_length_s);
  return fmt::format(
      "U = {:.5f} °/h (k = {:.2f}, {:.0f} %) applies to a mean of these rows over {:g} s inside the trained range; "
      "outside it, U is larger; the noise of a single row is not included",
      combined.expanded_deg_per_h, combined.coverage_factor, 100 * model::kCoverage, model.cluster_length_s);
}

/// Describes the lag of the compensation and its cost.
std::string describe_latency(const model::Model& model) {
  const std::string means = fmt::format("inputs are means over the last {:g} s", model.cluster_length_s);
  if (!is_led(model)) return fmt::format("{}: the compensation lags by {:g} s", means, model.cluster_length_s / 2);
  return fmt::format(
      "{}, which lag by {:g} s; the compensation is extrapolated by the same time: error in training {:.2g} °/h rms, "
      "compared with {:.2g} °/h with the lag",
      means, model.latency->lag_s, model.latency->led_rms_deg_per_h, model.latency->lagging_rms_deg_per_h);
}

Result<Exit> compensate(Console& console, const CompensateArguments& options) {
  const auto outside = model::parse_outside(options.outside);
  if (!outside) return failure(outside.error());
  const auto model = load_model(options.model);
  if (!model) return failure(model.error());
  if (options.uncertainty && options.tracking.track)
    return failure(FaultKind::usage, "--uncertainty",
                   "not valid with --track; U applies to the residual bias without tracking");
  const auto noise =
      find_tracking_noise(console, *model, options.tracking, {.unverified = options.unverified, .axis = options.axis});
  if (!noise) return failure(noise.error());
  const auto expanded = expanded_uncertainty(*model, options.uncertainty);
  if (!expanded) return failure(expanded.error());
  watch_for_interrupts(SecondInterrupt::ends);
  std::optional<Compensation> compensation;
  const auto open = [&](const std::vector<std::string>& header,
                        const std::vector<std::string>& comments) -> Result<Compensation> {
    auto table = CompensationTable::of(header, comments, *model, axis_for(*model, options.axis), noise->has_value());
    if (!table) return failure(table.error());
    if (!table->has_seconds() && options.axis != data::AxisChoice{})
      return failure(FaultKind::usage, options.axis.unit.empty() ? "--axis" : "--unit",
                     "not valid for a table whose last column is a bias; it has only one");
    const std::string bias_zero = table->bias_zero();
    auto opened = Compensation::open(*model, std::move(*table), *outside, *noise, *expanded);
    if (!opened) return opened;
    for (const std::string& warning :
         origin_warnings(*model, {.of = axis_for(*model, options.axis), .bias_zero = bias_zero}))
      console.print_message("warning: " + warning);
    if (*noise)
      console.print_message("tracking the residual bias, " + describe(**noise) +
                            ": the last column at_rest must be 0 where the gyro moves");
    console.print_message(describe_latency(*model));
    if (options.uncertainty) console.print_message(describe_uncertainty(*model));
    return opened;
  };
  const auto compensated = compensate_input(
      console, open, *expanded ? "compensated_bias_deg_per_h,U_deg_per_h\n" : "compensated_bias_deg_per_h\n",
      compensation);
  if (compensation && compensation->outside() > 0) {
    console.print_message(fmt::format("{} had an input outside the trained range ({})",
                                      format_count(compensation->outside(), "row"), name(*outside)));
  }
  if (compensation && compensation->missing_s() > 0) {
    console.print_message(
        fmt::format("{} seconds are missing between the rows; after each gap, rows have no value until their "
                    "mean is complete again",
                    compensation->missing_s()));
  }
  if (!compensated) return failure(compensated.error());
  return Exit::done;
}

}  // namespace

void add_compensate(Program& program) {
  auto [command, options] =
      add_command(program, "compensate",
                  "Compensates 1-Hz rows: reads temperatures (°C) and raw bias (°/h) with a header like "
                  "\"A,B,C,bias\", or a table written by export; writes the compensated bias.",
                  "gyrotherm compensate model.json < rows.csv", compensate);
  command.add_option("model", options.model, "the model")->type_name(value::kModel)->required();
  add_outside_option(command, options.outside, "not compensated, an empty line");
  command.add_flag("--uncertainty", options.uncertainty,
                   "a second column: the expanded uncertainty U of a mean over the model's cluster length");
  add_tracking_options(command, options.tracking,
                       "also track the residual bias by a Kalman filter while the gyro is at rest, and subtract it; a "
                       "last column at_rest (1 or 0) marks the rows at rest");
  add_axis_options(command, options.axis);
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
