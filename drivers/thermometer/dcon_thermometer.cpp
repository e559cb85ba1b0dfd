// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/dcon_thermometer.hpp"

#include <fmt/format.h>

#include <cassert>
#include <charconv>
#include <utility>

#include "drivers/checksum.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/line/text_exchange.hpp"
#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::string_view kOverRange = "+9999";
constexpr std::string_view kUnderRange = "-0000";
constexpr std::size_t kLongestValue = 8;
constexpr std::size_t kSumDigits = 2;

std::string checksum_text(std::string_view text) { return fmt::format("{:02X}", sum8(std::as_bytes(std::span(text)))); }

std::optional<std::uint8_t> parse_hex(std::string_view text) {
  if (text.size() != 2 || text.find_first_not_of("0123456789ABCDEF") != std::string_view::npos) return std::nullopt;
  std::uint8_t value{};
  std::from_chars(text.data(), text.data() + text.size(), value, 16);
  return value;
}

std::string address_text(char lead, std::uint8_t address) { return fmt::format("{}{:02X}", lead, address); }

tl::unexpected<Fault> corrupted_fault(std::string_view line, std::string_view expected) {
  return failure(FaultKind::corrupted, "", fmt::format("\"{}\" is not {}", line, expected));
}

/// Splits a text before each sign. Returns an empty list if it does not begin with a sign.
std::vector<std::string_view> split_at_signs(std::string_view text) {
  std::vector<std::string_view> values;
  if (text.find_first_of("+-") != 0) return values;
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of("+-", 1), text.size());
    values.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return values;
}

}  // namespace

std::string seal_dcon(const std::string& text, DconChecksum checksum) {
  return checksum == DconChecksum::on ? text + checksum_text(text) : text;
}

Result<std::string_view> unseal_dcon(std::string_view line, DconChecksum checksum) {
  if (checksum == DconChecksum::off) return line;
  if (line.size() < kSumDigits) return corrupted_fault(line, "an answer with a checksum");
  const auto text = line.substr(0, line.size() - kSumDigits);
  const auto sum = checksum_text(text);
  if (line.substr(text.size()) != sum)
    return failure(FaultKind::corrupted, "",
                   fmt::format("\"{}\" has the checksum {}, expected {}", text, line.substr(text.size()), sum));
  return text;
}

std::string dcon_read_all(std::uint8_t address) { return address_text('#', address); }

std::string dcon_query(std::uint8_t address, std::string_view what) { return address_text('$', address).append(what); }

Result<std::string_view> decode_dcon_answer(std::string_view line, std::uint8_t address) {
  if (line == address_text('?', address)) return failure(FaultKind::refused, "", "command refused by the module");
  const auto lead = address_text('!', address);
  if (!line.starts_with(lead)) return corrupted_fault(line, fmt::format("an answer of module {:02X}", address));
  return line.substr(lead.size());
}

Result<DconConfiguration> decode_dcon_configuration(std::string_view text) {
  const auto wrong = [&] { return corrupted_fault(text, "a configuration TTCCFF"); };
  if (text.size() != 6) return wrong();
  const auto type = parse_hex(text.substr(0, 2)), baud = parse_hex(text.substr(2, 2)),
             format = parse_hex(text.substr(4));
  if (!type || !baud || !format) return wrong();
  return DconConfiguration{*type, *baud, *format};
}

std::string encode_dcon_configuration(const DconConfiguration& configuration) {
  return fmt::format("{:02X}{:02X}{:02X}", configuration.type, configuration.baud, configuration.format);
}

Result<std::uint8_t> decode_dcon_type(std::string_view text, int input) {
  const auto lead = fmt::format("C{}R", input);
  const auto type = text.starts_with(lead) ? parse_hex(text.substr(lead.size())) : std::nullopt;
  if (!type) return corrupted_fault(text, fmt::format("the type of input {}", input));
  return *type;
}

std::optional<TemperatureRange> dcon_range(std::uint8_t type) {
  switch (type) {
    case 0x0E: return TemperatureRange{{0}, {760}};
    case 0x0F: return TemperatureRange{{0}, {1370}};
    case 0x10: return TemperatureRange{{-100}, {400}};
    case 0x11: return TemperatureRange{{0}, {1000}};
    default: return std::nullopt;
  }
}

Result<std::vector<Result<Celsius>>> decode_dcon_readings(std::string_view line, std::uint8_t address,
                                                          std::span<const TemperatureRange> ranges) {
  if (line.starts_with('?')) {
    // A refusal, by this module or by another one.
    auto refusal = decode_dcon_answer(line, address);
    return failure(std::move(refusal.error()));
  }
  const auto not_readings = [&] { return corrupted_fault(line, fmt::format("{} readings", ranges.size())); };
  if (!line.starts_with('>')) return not_readings();
  const auto values = split_at_signs(line.substr(1));
  if (values.size() != ranges.size()) return not_readings();

  std::vector<Result<Celsius>> readings;
  readings.reserve(ranges.size());
  std::size_t width = 0;
  for (const auto text : values) {
    const auto place = fmt::format("input {}", readings.size());
    if (text == kOverRange || text == kUnderRange) {
      const auto* what = text == kOverRange ? "over range" : "under range";
      readings.push_back(failure(FaultKind::out_of_range, place, fmt::format("{} ({})", what, text)));
      continue;
    }
    const auto value = parse_signed_decimal(text);
    const bool has_point = text.find('.') != std::string_view::npos;
    if (!value || !has_point || text.size() > kLongestValue || (width != 0 && text.size() != width))
      return not_readings();
    width = text.size();
    readings.push_back(check_range(ranges[readings.size()], {*value}, place));
  }
  return readings;
}

std::string encode_dcon_readings(std::span<const double> celsius, const TemperatureRange& range, int decimals) {
  std::string line = ">";
  for (const double reading : celsius) {
    if (reading >= range.lowest.value && reading <= range.highest.value)
      line += fmt::format("{:+07.{}f}", reading, decimals);
    else
      line += reading < range.lowest.value ? kUnderRange : kOverRange;
  }
  return line;
}

namespace {

tl::unexpected<Fault> type_fault(std::uint8_t type, std::string where) {
  return failure(FaultKind::mismatch, std::move(where),
                 fmt::format("set to type {:02X}, expected thermocouple J, K, T or E (0E to 11)", type));
}

std::shared_ptr<TextExchange> make_exchange(std::unique_ptr<ByteStream> line, const DconOptions& options) {
  return std::make_shared<TextExchange>(std::move(line), TextExchangeOptions{.question_end = "\r",
                                                                             .answer_end = "\r",
                                                                             .within = options.within,
                                                                             .pause = options.pause,
                                                                             .is_only_instrument = false,
                                                                             .clock = options.clock});
}

class DconThermometer final : public Thermometer {
 public:
  /// All modules on a line must share one exchange, which does not accept a late answer of one module for another one.
  DconThermometer(std::shared_ptr<TextExchange> exchange, std::string place, DconOptions options)
      : exchange_(std::move(exchange)), place_(std::move(place)), options_(options) {}

  Result<std::string> identify() override {
    ranges_.clear();
    name_.clear();
    auto name = query_module("M");
    if (!name) return failure(add_location(place_, std::move(name.error())));
    auto found = read_settings();
    if (!found) return failure(add_location(place_, std::move(found.error())));
    ranges_ = std::move(found->ranges);
    name_ = *name;
    types_ = found->types;
    return fmt::format("{} at {:02X}, type {:02X}", *name, options_.address, fmt::join(found->types, " "));
  }

  std::vector<Result<Celsius>> read() override {
    auto found = readings();
    if (!found) ranges_.clear();  // another module may answer next
    return add_locations(place_, kDconInputs, std::move(found));
  }

 private:
  using Ranges = std::vector<TemperatureRange>;
  struct Settings {
    Ranges ranges;
    std::vector<std::uint8_t> types;  ///< one, or one per input
  };

  /// Sends a question and returns the answer without its checksum.
  [[nodiscard]] Result<std::string> query(std::string_view question) {
    const auto sealed = [&](const std::string& text) { return seal_dcon(text, options_.checksum); };
    // Unlike readings, the answer with the name contains the address.
    const ResyncQuery resync{.question = sealed(dcon_query(options_.address, "M")),
                             .answer_begins = fmt::format("!{:02X}{}", options_.address, name_)};
    auto answer = exchange_->query(sealed(std::string(question)), resync).and_then([&](const auto& line) {
      return unseal_dcon(line, options_.checksum).map([](auto text) { return std::string(text); });
    });
    if (!answer && answer.error().where.empty()) answer.error().where = question;
    return answer;
  }

  /// Returns the text after the address in the answer to "$AA" and `what`.
  [[nodiscard]] Result<std::string> query_module(std::string_view what) {
    const auto question = dcon_query(options_.address, what);
    return resynchronise_after(query(question).and_then([&](const std::string& line) -> Result<std::string> {
      auto rest = decode_dcon_answer(line, options_.address);
      if (rest) return std::string(*rest);
      rest.error().where = question;
      return failure(std::move(rest.error()));
    }));
  }

  /// Returns the answer. If it could not be decoded, the next query resynchronises the line first, because readings do
  /// not contain the address: the rest of this answer could be taken for that of another module.
  template <typename T>
  [[nodiscard]] Result<T> resynchronise_after(Result<T> answer) const {
    if (!answer && answer.error().kind == FaultKind::corrupted) exchange_->reject_answer();
    return answer;
  }

  [[nodiscard]] Result<Settings> read_settings() {
    const auto configuration =
        query_module("2").and_then([](const auto& text) { return decode_dcon_configuration(text); });
    if (!configuration) return failure(configuration.error());
    if (!configuration->in_engineering_units())
      return failure(FaultKind::mismatch, "",
                     fmt::format("set to format {:02X}, expected engineering units", configuration->format));
    if (options_.type && configuration->type != *options_.type)
      return failure(FaultKind::mismatch, "",
                     fmt::format("set to type {:02X}, expected {:02X}", configuration->type, *options_.type));
    if (const auto range = dcon_range(configuration->type))
      return Settings{Ranges(kDconInputs, *range), {configuration->type}};
    auto each = read_settings_per_input();
    if (!each && each.error().kind == FaultKind::refused) return type_fault(configuration->type, "");
    return each;
  }

  [[nodiscard]] Result<Settings> read_settings_per_input() {
    Settings read_settings;
    for (int input = 0; input < static_cast<int>(kDconInputs); ++input) {
      const auto type = query_module(fmt::format("8C{}", input)).and_then([&](const auto& text) {
        return decode_dcon_type(text, input);
      });
      if (!type) return failure(type.error());
      const auto range = dcon_range(*type);
      if (!range) return type_fault(*type, fmt::format("input {}", input));
      read_settings.ranges.push_back(*range);
      read_settings.types.push_back(*type);
    }
    return read_settings;
  }

  [[nodiscard]] Result<std::vector<Result<Celsius>>> readings() {
    if (ranges_.empty()) {
      auto found = read_settings();
      if (!found) return failure(std::move(found.error()));
      if (!types_.empty() && found->types != types_)
        return failure(
            FaultKind::mismatch, "",
            fmt::format("set to type {:02X}, was {:02X}", fmt::join(found->types, " "), fmt::join(types_, " ")));
      ranges_ = std::move(found->ranges);
    }
    return resynchronise_after(query(dcon_read_all(options_.address)).and_then([&](const std::string& line) {
      return decode_dcon_readings(line, options_.address, ranges_);
    }));
  }

  std::shared_ptr<TextExchange> exchange_;
  std::string place_;
  DconOptions options_;
  Ranges ranges_;  ///< empty: settings not read
  /// Latest identity. A module with another name or type is not accepted after a lost answer.
  std::string name_;
  std::vector<std::uint8_t> types_;
};

/// Driver for several modules on one line.
class DconModules final : public Thermometer {
 public:
  struct Module {
    std::unique_ptr<Thermometer> thermometer;
    Backoff backoff{};
    Fault last_fault{};
    int silences = 0;  ///< consecutive missing answers
  };
  explicit DconModules(std::vector<Module> modules) : modules_(std::move(modules)) {}

  Result<std::string> identify() override {
    std::string all;
    for (auto& module : modules_) {
      auto identity = module.thermometer->identify();
      if (!identity) return identity;
      all += (all.empty() ? "" : ", ") + *identity;
    }
    return all;
  }

  std::uint64_t breaks() const override { return breaks_; }

  std::vector<Result<Celsius>> read() override {
    std::vector<Result<Celsius>> all;
    for (auto& module : modules_) {
      if (module.backoff.left() > Duration::zero()) {
        all.insert(all.end(), kDconInputs, failure(module.last_fault));
        continue;
      }
      auto readings = module.thermometer->read();
      const auto& first = readings.front();
      const bool silent =
          !first && (first.error().kind == FaultKind::timeout || first.error().kind == FaultKind::disconnected);
      if (silent) module.last_fault = first.error();
      silent ? module.backoff.note_failure(module.last_fault.what) : module.backoff.note_success();
      if (!silent && module.silences >= kSilencesBeforeDoubt) ++breaks_;
      module.silences = silent ? module.silences + 1 : 0;
      all.insert(all.end(), std::make_move_iterator(readings.begin()), std::make_move_iterator(readings.end()));
    }
    return all;
  }

 private:
  /// Number of consecutive missing answers after which the module may have been replaced, although the line did not
  /// break.
  static constexpr int kSilencesBeforeDoubt = 2;
  std::vector<Module> modules_;
  std::uint64_t breaks_ = 0;
};

}  // namespace

std::unique_ptr<Thermometer> make_dcon_thermometer(std::unique_ptr<ByteStream> line, std::string place,
                                                   DconOptions options) {
  return std::make_unique<DconThermometer>(make_exchange(std::move(line), options), std::move(place), options);
}

std::unique_ptr<Thermometer> make_dcon_modules(std::unique_ptr<ByteStream> line, const std::string& place,
                                               const std::vector<std::uint8_t>& addresses, const DconOptions& options) {
  const auto exchange = make_exchange(std::move(line), options);
  std::vector<DconModules::Module> modules;
  for (const auto address : addresses) {
    auto module_options = options;
    module_options.address = address;
    modules.push_back({.thermometer = std::make_unique<DconThermometer>(
                           exchange, fmt::format("{} module {:02X}", place, address), module_options),
                       .backoff = Backoff(options.clock)});
  }
  return std::make_unique<DconModules>(std::move(modules));
}

}  // namespace gyrotherm::drivers
