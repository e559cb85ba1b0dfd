// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/item_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>

namespace gyrotherm::drivers {
namespace {

constexpr double kMostDecimals = 6;

const RegisterItem& named(const RegisterMap& map, std::string_view name) {
  const auto* found = map.find(name);
  assert(found && "parse_register_map() lets no such map pass");
  return *found;
}

Result<int> decimals_of(const RegisterItem& item, const ValueOf& value_of) {
  return value_of(item).and_then([&](double decimals) -> Result<int> {
    if (decimals >= 0 && decimals <= kMostDecimals) return static_cast<int>(decimals);
    return failure(FaultKind::corrupted, place(item), fmt::format("{:g} decimals", decimals));
  });
}

Result<bool> fahrenheit_of(const RegisterItem& item, const ValueOf& value_of) {
  return value_of(item).and_then([&](double code) -> Result<bool> {
    const auto word = meaning(item, code);
    if (word == "celsius" || word == "fahrenheit") return word == "fahrenheit";
    return failure(FaultKind::corrupted, place(item), fmt::format("{} is neither celsius nor fahrenheit", word));
  });
}

/// Of a register's resolution: more than rounding can make, less than a step to the next value.
constexpr double kSameStep = 0.75;
/// Between two looks at a register that is waited for.
constexpr Duration kLookAgain = std::chrono::milliseconds(100);
/// What a controller's settings were read as counts for so long: about the second in which they were read.
constexpr Duration kKnownFor = std::chrono::milliseconds(1500);

Fault at(const RegisterItem& item, Fault fault) {
  if (fault.where == item.name) fault.where = place(item);
  return fault;
}

}  // namespace

Result<ItemContext> context_of(const RegisterMap& map, const RegisterItem& item, const ValueOf& value_of) {
  ItemContext context;
  if (!item.decimals.empty()) {
    const auto decimals = decimals_of(named(map, item.decimals), value_of);
    if (!decimals) return failure(decimals.error());
    context.decimals = *decimals;
  }
  if (!item.unit.empty()) {
    const auto fahrenheit = fahrenheit_of(named(map, item.unit), value_of);
    if (!fahrenheit) return failure(fahrenheit.error());
    context.fahrenheit = *fahrenheit;
  }
  return context;
}

double finest_step(const RegisterItem& item) {
  constexpr double kFahrenheitPerKelvin = 1.8;
  return item.fahrenheit ? item.resolution / kFahrenheitPerKelvin : item.resolution;
}

bool matches(std::string_view pattern, std::string_view text) {
  const auto star = pattern.find('*');
  if (star == std::string_view::npos) return pattern == text;
  if (!text.starts_with(pattern.substr(0, star))) return false;
  pattern.remove_prefix(star + 1);
  for (std::size_t from = star; from <= text.size(); ++from)
    if (matches(pattern, text.substr(from))) return true;
  return false;
}

Result<void> check_fingerprint(const RegisterMap& map, double found) {
  const auto& print = *map.identity;
  const auto masked = [&](double value) {
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(value)) & print.mask;
  };
  constexpr std::uint32_t kAllBits = 0xFFFFFFFF;
  if (print.mask == kAllBits ? found == print.value : masked(found) == masked(print.value)) return {};
  return failure(FaultKind::mismatch, place(named(map, print.item)),
                 fmt::format("holds {}, expected {} of a {} {}", found, print.value, map.vendor, map.name));
}

Result<std::string> ItemExchange::identify(const RegisterItem& instead) {
  auto found = ask_who(instead);
  if (found) recognised_ = *found;
  recognised_by_ = &instead;
  return found;
}

Result<std::string> ItemExchange::ask_who(const RegisterItem& instead) {
  const auto who = fmt::format("{} {}", map_.vendor, map_.name);
  if (!map_.identity) return read(instead).map([&](double) { return who + " (its map has no fingerprint to check)"; });
  const auto& print = item(map_.identity->item);
  if (print.type == RegisterType::text) {
    const auto found = read_text(print);
    if (!found) return found;
    if (matches(map_.identity->pattern, *found)) return fmt::format("{} ({} = {})", who, print.name, *found);
    return failure(FaultKind::mismatch, place(print),
                   fmt::format("reads \"{}\", expected \"{}\"", *found, map_.identity->pattern));
  }
  const auto found = read(print);
  if (!found) return failure(found.error());
  if (auto same = check_fingerprint(map_, *found); !same) return failure(std::move(same.error()));
  return fmt::format("{} ({} = {})", who, print.name, *found);
}

const RegisterItem& ItemExchange::item(std::string_view name) const { return named(map_, name); }

std::vector<const RegisterItem*> ItemExchange::needed_by(std::span<const RegisterItem* const> items) const {
  std::vector<const RegisterItem*> context;
  for (const auto* one : items)
    for (const auto* name : {&one->decimals, &one->unit}) {
      if (name->empty()) continue;
      const auto* other = &item(*name);
      if (std::ranges::find(context, other) == context.end()) context.push_back(other);
    }
  return context;
}

Result<Snapshot> ItemExchange::look(std::span<const ReadSpan> spans) {
  Snapshot snapshot;
  for (const auto& span : spans) {
    auto words = registers_.read(span.function, span.first, span.count);
    if (!words) return failure(std::move(words.error()));
    snapshot.add(span, std::move(*words));
  }
  return snapshot;
}

Result<double> ItemExchange::value_in(const Snapshot& snapshot, const RegisterItem& item) const {
  const auto words = snapshot.words_of(item);
  if (words.size() != word_count(item)) return failure(FaultKind::refused, place(item), "not read");
  const auto context = context_of(map_, item, [&](const RegisterItem& other) { return value_in(snapshot, other); });
  if (!context) return failure(context.error());
  auto value = context->is_empty() ? decode(item, words) : decode(in_context(item, *context), words);
  return value ? value : failure(at(item, std::move(value.error())));
}

Result<double> ItemExchange::read(const RegisterItem& item) {
  const RegisterItem* const self = &item;
  auto wanted = needed_by(std::span(&self, 1));
  wanted.push_back(self);
  return look(plan_reads(wanted, map_.holes, map_.link.modbus.read_at_most)).and_then([&](const Snapshot& snapshot) {
    return value_in(snapshot, item);
  });
}

Result<std::vector<std::uint16_t>> ItemExchange::read_words(const RegisterItem& item) {
  auto words = registers_.read(read_function(item), item.address, word_count(item));
  if (words && words->size() != word_count(item))
    return failure(FaultKind::corrupted, place(item), "another number of registers");
  return words;
}

Result<std::string> ItemExchange::read_text(const RegisterItem& item) {
  return read_words(item).map([&](const auto& words) { return decode_text(item.text, words); });
}

Result<CivilTime> ItemExchange::read_date(const RegisterItem& item) {
  const auto words = read_words(item);
  if (!words) return failure(words.error());
  auto time = decode_date(item.date, *words);
  if (!time) time.error().where = place(item);
  return time;
}

void ItemExchange::know(const Snapshot& found) {
  known_ = found;
  known_since_ = pauses_.now();
}

bool ItemExchange::knows(const RegisterItem& item) const {
  return pauses_.now() - known_since_ <= kKnownFor && !known_.words_of(item).empty();
}

Result<double> ItemExchange::context_value(const RegisterItem& item) {
  return knows(item) ? value_in(known_, item) : read(item);
}

/// The item alone is read if all that it needs to be understood is known.
Result<double> ItemExchange::read_in_known_context(const RegisterItem& item) {
  const RegisterItem* const self = &item;
  const auto context = needed_by(std::span(&self, 1));
  if (!std::ranges::all_of(context, [&](const auto* other) { return knows(*other); })) return read(item);
  const auto in_context = in_its_context(item);
  if (!in_context) return failure(in_context.error());
  const auto span = span_of(item);
  const auto found = look(std::span(&span, 1));
  if (!found) return failure(found.error());
  auto value = decode(*in_context, found->words_of(item));
  return value ? value : failure(at(item, std::move(value.error())));
}

Result<RegisterItem> ItemExchange::in_its_context(const RegisterItem& item) {
  return context_of(map_, item, [&](const RegisterItem& other) { return context_value(other); })
      .map([&](const ItemContext& context) { return in_context(item, context); });
}

/// A bit field leaves the other bits of its register as they are.
Result<std::vector<std::uint16_t>> ItemExchange::words_for(const RegisterItem& item, double value) {
  auto words = encode(item, value);
  const double written = decode_as_written(item, words);
  if (std::abs(written - value) > finest_step(item))
    return failure(FaultKind::out_of_range, place(item), fmt::format("cannot hold {}", value));
  if (item.type != RegisterType::bits || !item.readable) return words;
  const auto present = read_words(item);
  if (!present) return failure(present.error());
  words[0] = with_other_bits(item, words[0], present->front());
  return words;
}

bool ItemExchange::is_trusted() {
  const auto now = registers_.breaks();
  if (now == trusted_ || recognised_.empty()) return true;
  const auto before = recognised_;
  const auto who = identify(*recognised_by_);
  recognised_ = before;
  if (!who || *who != before || registers_.breaks() != now) return false;
  trusted_ = now;
  return true;
}

Result<void> ItemExchange::write_words(const RegisterItem& item, std::span<const std::uint16_t> words) {
  if (!is_trusted())
    return failure(FaultKind::disconnected, place(item), "not sent: the line broke, and who answers now was not asked");
  return registers_.write(write_function(item.write_function, words.size()), item.address, words);
}

Result<void> ItemExchange::write_words(const RegisterItem& item, std::span<const std::uint16_t> words, int tries) {
  for (;;) {
    auto sent = write_words(item, words);
    if (sent || sent.error().kind == FaultKind::refused || --tries == 0) return sent;
    registers_.insist();
    if (!is_trusted()) return sent;
  }
}

Result<void> ItemExchange::write(const RegisterItem& item, double value, int tries) {
  const auto set = in_its_context(item);
  if (!set) return failure(set.error());
  auto words = words_for(*set, value);
  if (!words) return failure(words.error());
  for (const auto& name : item.also) {
    const auto& other = this->item(name);
    const auto same = words_for(other, value).and_then([&](const auto& its) { return write_words(other, its); });
    if (!same) return same;
  }
  const double written = decode_as_written(*set, std::span(*words).first(word_count(item)));
  if (item.companion) {
    const auto more = encode(this->item(item.companion->item), item.companion->value);
    words->insert(words->end(), more.begin(), more.end());
  }
  auto sent = write_words(item, *words, tries);
  const bool is_seen = !item.self_clearing && !item.seen_later && (item.readable || !item.seen_in.empty());
  if (sent) return is_seen ? wait_until_seen(*set, written) : Result<void>{};
  registers_.insist();
  if (tries == 1 || !is_seen || sent.error().kind == FaultKind::refused || !is_trusted()) return sent;
  return wait_until_seen(*set, written) ? Result<void>{} : sent;
}

Result<void> ItemExchange::wait_until_seen(const RegisterItem& written, double value) {
  const auto& shown = written.seen_in.empty() ? item(written.name) : item(written.seen_in);
  const double tolerance = written.tolerance.value_or(kSameStep * finest_step(written));
  const auto end = pauses_.now() + written.seen_within;
  while (true) {
    const auto found = read_in_known_context(shown);
    if (!found) return failure(found.error());
    if (std::abs(*found - value) <= tolerance) return {};
    if (pauses_.now() >= end)
      return failure(FaultKind::mismatch, place(shown), fmt::format("reads {} after {} was written", *found, value));
    pauses_.rest(std::min(kLookAgain, end - pauses_.now()));
  }
}

Result<void> ItemExchange::write_date(const RegisterItem& item, const CivilTime& time) {
  return write_words(item, encode_date(item.date, time));
}

Result<void> ItemExchange::wait_until(const Condition& condition, Duration within) {
  const auto& shown = item(condition.item);
  const auto end = pauses_.now() + within;
  while (true) {
    const auto found = read(shown);
    if (!found) return failure(found.error());
    if (holds(condition, *found)) return {};
    if (pauses_.now() >= end)
      return failure(FaultKind::timeout, place(shown),
                     fmt::format("is {} and not {} after {:g} s", meaning(shown, *found),
                                 condition.meanings.empty() ? "what was waited for"
                                                            : fmt::format("{}", fmt::join(condition.meanings, " or ")),
                                 to_seconds(within)));
    pauses_.rest(std::min(kLookAgain, end - pauses_.now()));
  }
}

Result<void> ItemExchange::write_step(const SequenceStep& step, const Parameters& parameters) {
  const auto& target = item(step.item);
  switch (step.source) {
    case SequenceStep::Source::number: return write(target, step.value);
    case SequenceStep::Source::program: return write(target, parameters.program + step.value);
    case SequenceStep::Source::step: return write(target, parameters.step + step.value);
    case SequenceStep::Source::date: break;
  }
  const auto now = read_date(item(step.date_of));
  if (!now) return failure(now.error());
  return write_date(target, later(*now, step.duration));
}

Result<void> ItemExchange::perform_step(const SequenceStep& step, const Parameters& parameters) {
  if (step.only_if) {
    const auto found = read(item(step.only_if->item));
    if (!found) return failure(found.error());
    if (!holds(*step.only_if, *found)) return {};
  }
  if (step.kind == SequenceStep::Kind::write) return write_step(step, parameters);
  if (step.kind == SequenceStep::Kind::wait) return wait_until(step.until, step.duration);
  pauses_.rest(step.duration);
  return {};
}

Result<void> ItemExchange::perform(const Sequence& sequence, const Parameters& parameters) {
  for (const auto& step : sequence)
    if (auto done = perform_step(step, parameters); !done) return done;
  return {};
}

}  // namespace gyrotherm::drivers
