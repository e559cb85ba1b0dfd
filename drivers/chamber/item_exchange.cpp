// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/item_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>

#include "drivers/chamber/expression_example.hpp"
#include "drivers/chamber/text_registers.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr double kMostDecimals = 6;

const RegisterItem& named_item(const RegisterMap& map, std::string_view name) {
  const auto* found = map.find(name);
  assert(found && "parse_register_map() refuses such a map");
  return *found;
}

Result<int> read_decimals(const RegisterItem& item, const ValueOf& value_of) {
  return value_of(item).and_then([&](double decimals) -> Result<int> {
    if (decimals >= 0 && decimals <= kMostDecimals) return static_cast<int>(decimals);
    return failure(FaultKind::corrupted, place(item), fmt::format("{:g} decimals", decimals));
  });
}

Result<bool> read_is_fahrenheit(const RegisterItem& item, const ValueOf& value_of) {
  return value_of(item).and_then([&](double code) -> Result<bool> {
    const auto word = meaning(item, code);
    if (word == "celsius" || word == "fahrenheit") return word == "fahrenheit";
    return failure(FaultKind::corrupted, place(item), fmt::format("{} is neither celsius nor fahrenheit", word));
  });
}

/// Default tolerance of a value read back, as a fraction of the resolution: above rounding errors, below one step.
constexpr double kSameStep = 0.75;
/// Interval between reads of a register while waiting for its value.
constexpr Duration kPollInterval = std::chrono::milliseconds(100);
/// Time for which settings are not read again, about one second.
constexpr Duration kContextLifetime = std::chrono::milliseconds(1500);
/// Time in which a unit cannot be replaced by another one.
constexpr Duration kRecognisedFor = std::chrono::seconds(2);

Fault add_item_location(const RegisterItem& item, Fault fault) {
  if (fault.where == item.name) fault.where = place(item);
  return fault;
}

}  // namespace

Result<ItemContext> read_context(const RegisterMap& map, const RegisterItem& item, const ValueOf& value_of) {
  ItemContext context;
  if (!item.decimals.empty()) {
    const auto decimals = read_decimals(named_item(map, item.decimals), value_of);
    if (!decimals) return failure(decimals.error());
    context.decimals = *decimals;
  }
  if (!item.unit.empty()) {
    const auto fahrenheit = read_is_fahrenheit(named_item(map, item.unit), value_of);
    if (!fahrenheit) return failure(fahrenheit.error());
    context.fahrenheit = *fahrenheit;
  }
  return context;
}

double finest_step(const RegisterItem& item) {
  constexpr double kFahrenheitPerKelvin = 1.8;
  return item.fahrenheit ? item.resolution / kFahrenheitPerKelvin : item.resolution;
}

namespace {

/// Returns whether `c` is in the class "A-C5", or outside the class "!A-C5".
bool is_in_class(std::string_view characters, char c) {
  const bool negated = characters.starts_with('!');
  if (negated) characters.remove_prefix(1);
  bool is_one = false;
  while (!characters.empty()) {
    const bool is_range = characters.size() > 2 && characters[1] == '-';
    const char last = is_range ? characters[2] : characters[0];
    is_one = is_one || (c >= characters[0] && c <= last);
    characters.remove_prefix(is_range ? 3 : 1);
  }
  return is_one != negated;
}

/// First token of a non-empty pattern, and the remaining pattern.
struct PatternToken {
  char kind{};  ///< '*', '?', '[' or 'c'
  std::string_view characters;
  std::string_view rest;
};

PatternToken first_token(std::string_view pattern) {
  const char first = pattern.front();
  if (first == '*' || first == '?') return {first, pattern.substr(0, 1), pattern.substr(1)};
  const auto end = first == '[' ? pattern.find(']') : std::string_view::npos;
  if (end == std::string_view::npos) return {'c', pattern.substr(0, 1), pattern.substr(1)};
  return {'[', pattern.substr(1, end - 1), pattern.substr(end + 1)};
}

bool is_one_of(const PatternToken& token, char c) {
  if (token.kind == '?') return true;
  return token.kind == '[' ? is_in_class(token.characters, c) : token.characters.front() == c;
}

}  // namespace

bool matches(std::string_view pattern, std::string_view text) {
  if (pattern.empty()) return text.empty();
  const auto token = first_token(pattern);
  if (token.kind != '*') return !text.empty() && is_one_of(token, text.front()) && matches(token.rest, text.substr(1));
  for (std::size_t from = 0; from <= text.size(); ++from)
    if (matches(token.rest, text.substr(from))) return true;
  return false;
}

std::string make_example(std::string_view pattern) {
  constexpr std::string_view kCharacters = "A0BCDEFGHIJKLMNOPQRSTUVWXYZ123456789abcdefghijklmnopqrstuvwxyz -_.";
  std::string example;
  while (!pattern.empty()) {
    const auto token = first_token(pattern);
    pattern = token.rest;
    if (token.kind == '*') continue;
    const bool is_named = token.kind == 'c' || (token.kind == '[' && !token.characters.starts_with('!'));
    const auto fits = std::ranges::find_if(kCharacters, [&](char c) { return is_one_of(token, c); });
    example += is_named || fits == kCharacters.end() ? token.characters.front() : *fits;
  }
  return example;
}

Result<void> check_fingerprint(const RegisterMap& map, const Fingerprint& print, double found) {
  constexpr std::uint32_t kAllBits = 0xFFFFFFFF;
  const auto bits = lower_bits(found), wanted = lower_bits(print.value);
  const bool has_same_bits = bits && wanted && (*bits & print.mask) == (*wanted & print.mask);
  if (print.mask == kAllBits ? found == print.value : has_same_bits) return {};
  return failure(FaultKind::mismatch, place(named_item(map, print.item)),
                 fmt::format("reads {}, expected {} for a {} {}", found, print.value, map.vendor, map.name));
}

Result<ItemExchange::Shown> ItemExchange::read_shown(const RegisterItem& item) {
  if (item.type == RegisterType::text) {
    auto found = read_text(item);
    if (!found) return failure(found.error());
    return Shown{std::move(*found), std::nullopt};
  }
  const auto found = read(item);
  if (!found) return failure(found.error());
  return Shown{item.codes.empty() ? fmt::format("{}", *found) : meaning(item, *found), *found};
}

Result<void> ItemExchange::check(const Fingerprint& print, const Shown& shown) const {
  if (shown.value) return check_fingerprint(map_, print, *shown.value);
  if (fits(print, shown.words)) return {};
  return failure(FaultKind::mismatch, place(item(print.item)),
                 fmt::format("reads \"{}\", expected {}\"{}\"", shown.words,
                             print.is_expression ? "a text that fits the pattern " : "", print.pattern));
}

Result<void> ItemExchange::check(const VerifiedSetting& setting, const Shown& shown) const {
  if (setting.verifies.empty()) return {};
  const auto fits = shown.value ? evaluate(setting.when, item(setting.item), *shown.value)
                                : Result<bool>(matches(setting.pattern, shown.words));
  if (!fits) return failure(fits.error());
  if (*fits) return {};
  return failure(FaultKind::mismatch, place(item(setting.item)),
                 fmt::format("is {}, expected: {}", shown.words, setting.verifies));
}

Result<void> ItemExchange::add_property(const std::string& name, const VerifiedSetting* setting, IdentityFound& found) {
  const auto shown = read_shown(item(name));
  const bool is_missing = !shown && shown.error().kind == FaultKind::refused;
  const auto what = setting != nullptr && !setting->verifies.empty() ? setting->verifies : name;
  if (is_missing) {
    found.not_verified.push_back(fmt::format("{} (the unit has no {})", what, place(item(name))));
    return {};
  }
  if (!shown) return failure(shown.error());
  if (setting != nullptr)
    if (auto good = check(*setting, *shown); !good) return good;
  found.verified.push_back(what == name ? fmt::format("{} = {}", name, shown->words) : what);
  found.who += fmt::format(", {} = {}", name, shown->words);
  return {};
}

Result<IdentityFound> ItemExchange::recognise(const RegisterItem& instead) {
  IdentityFound found{.who = fmt::format("{} {}", map_.vendor, map_.name), .verified = {}, .not_verified = {}};
  const auto& wanted = map_.verification;
  const auto shown = read_shown(map_.identity ? item(map_.identity->item) : instead);
  if (!shown) another_answers_ = another_answers_ || shown.error().kind == FaultKind::refused;
  if (!shown) return failure(shown.error());
  const auto refuse = [this](Fault fault) {
    another_answers_ = true;
    return failure(std::move(fault));
  };
  if (map_.identity) {
    for (const auto& other : wanted.other_maps)
      if (check(other.print, *shown))
        return refuse({FaultKind::mismatch, place(item(other.print.item)),
                       fmt::format("is {}: {}; use the map {}", shown->words, other.what, other.map)});
    if (auto same = check(*map_.identity, *shown); !same) return refuse(std::move(same.error()));
    found.who += fmt::format(" ({} = {}", map_.identity->item, shown->words);
    found.verified.push_back(wanted.verifies.empty() ? found.who + ")" : wanted.verifies);
  } else {
    found.who += " (its map describes no identity to check";
  }
  for (const auto& name : wanted.shows)
    if (auto added = add_property(name, nullptr, found); !added) return failure(std::move(added.error()));
  found.who += ")";
  another_answers_ = false;
  recognised_ = found.who;
  recognised_at_ = pauses_.now();
  recognised_item_ = &instead;
  return found;
}

Result<IdentityFound> ItemExchange::identify(const RegisterItem& instead) {
  auto found = recognise(instead);
  if (!found) return found;
  const auto& wanted = map_.verification;
  for (const auto& setting : wanted.settings)
    if (auto added = add_property(setting.item, &setting, *found); !added) return failure(std::move(added.error()));
  const bool reads_unit = std::ranges::any_of(map_.items, [](const auto& one) { return !one.unit.empty(); });
  if (reads_unit) found->verified.emplace_back("°C or °F, read with each value");
  found->not_verified.insert(found->not_verified.end(), wanted.not_verified.begin(), wanted.not_verified.end());
  return found;
}

ItemExchange::ItemExchange(const RegisterMap& map, Registers& registers, Pauses& pauses)
    : map_(map), registers_(registers), pauses_(pauses) {
  std::vector<const RegisterItem*> all;
  for (const auto& one : map.items) all.push_back(&one);
  contexts_ = find_context_items(all);
}

const RegisterItem& ItemExchange::item(std::string_view name) const { return named_item(map_, name); }

std::vector<const RegisterItem*> ItemExchange::find_context_items(std::span<const RegisterItem* const> items) const {
  std::vector<const RegisterItem*> context;
  for (const auto* one : items)
    for (const auto* name : {&one->decimals, &one->unit}) {
      if (name->empty()) continue;
      const auto* other = &item(*name);
      if (std::ranges::find(context, other) == context.end()) context.push_back(other);
    }
  return context;
}

Result<Snapshot> ItemExchange::read_spans(std::span<const ReadSpan> spans) {
  Snapshot snapshot;
  for (const auto& span : spans) {
    auto words = registers_.read(span.function, span.first, span.count);
    if (!words) return failure(std::move(words.error()));
    snapshot.add(span, std::move(*words));
  }
  cache_latest_settings(snapshot);
  return snapshot;
}

Result<double> ItemExchange::value_in(const Snapshot& snapshot, const RegisterItem& item) const {
  const auto words = snapshot.find_words(item);
  if (words.size() != word_count(item)) return failure(FaultKind::refused, place(item), "not read");
  const auto context = read_context(
      map_, item, [&](const RegisterItem& other) { return value_or_latest(other, value_in(snapshot, other)); });
  if (!context) return failure(context.error());
  return decode_answer(context->is_empty() ? item : apply_context(item, *context), words);
}

Result<double> ItemExchange::decode_answer(const RegisterItem& item, std::span<const std::uint16_t> words) const {
  if (has_no_value(map_, item, words))
    return failure(FaultKind::out_of_range, place(item), "the unit answered without a value for this item");
  auto value = decode(item, words);
  return value ? value : failure(add_item_location(item, std::move(value.error())));
}

Result<double> ItemExchange::read(const RegisterItem& item) {
  const RegisterItem* const self = &item;
  auto wanted = find_context_items(std::span(&self, 1));
  wanted.push_back(self);
  auto snapshot = read_spans(plan_reads(wanted, map_.holes, map_.link.modbus.read_at_most));
  const auto alone = read_span(item);
  if (!snapshot && falls_back_ && wanted.size() > 1) snapshot = read_spans(std::span(&alone, 1));
  return snapshot.and_then([&](const Snapshot& found) { return value_in(found, item); });
}

Result<std::vector<std::uint16_t>> ItemExchange::read_words(const RegisterItem& item) {
  auto words = registers_.read(read_function(item), item.address, word_count(item));
  if (words && words->size() != word_count(item))
    return failure(FaultKind::corrupted, place(item), "wrong number of registers");
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

void ItemExchange::keep_snapshot(const Snapshot& found) {
  known_ = found;
  known_since_ = pauses_.now();
}

void ItemExchange::cache_latest_settings(const Snapshot& found) {
  for (const auto* item : contexts_) {
    if (found.find_words(*item).empty()) continue;
    if (const auto value = value_in(found, *item)) latest_settings_[item->name] = *value;
  }
}

bool ItemExchange::can_skip(const ReadSpan& span) const {
  if (!falls_back_) return false;
  const auto is_needed = [&](const RegisterItem& item) {
    const bool inside =
        read_function(item) == span.function && item.address >= span.first && item.address < span.first + span.count;
    return inside && !latest_settings_.contains(item.name);
  };
  return std::ranges::none_of(map_.items, is_needed);
}

Result<double> ItemExchange::value_or_latest(const RegisterItem& item, Result<double> value) const {
  if (value || !falls_back_) return value;
  const auto before = latest_settings_.find(item.name);
  return before == latest_settings_.end() ? value : Result<double>(before->second);
}

bool ItemExchange::is_known(const RegisterItem& item) const {
  return pauses_.now() - known_since_ <= kContextLifetime && !known_.find_words(item).empty();
}

Result<double> ItemExchange::context_value(const RegisterItem& item) {
  return value_or_latest(item, is_known(item) ? value_in(known_, item) : read(item));
}

/// Reads only the item if its context is known.
Result<double> ItemExchange::read_in_known_context(const RegisterItem& item) {
  const RegisterItem* const self = &item;
  const auto context = find_context_items(std::span(&self, 1));
  if (!std::ranges::all_of(context, [&](const auto* other) { return is_known(*other); })) return read(item);
  const auto in_context = resolve_context(item);
  if (!in_context) return failure(in_context.error());
  const auto span = read_span(item);
  const auto found = read_spans(std::span(&span, 1));
  if (!found) return failure(found.error());
  return decode_answer(*in_context, found->find_words(item));
}

Result<RegisterItem> ItemExchange::resolve_context(const RegisterItem& item) {
  return read_context(map_, item, [&](const RegisterItem& other) { return context_value(other); })
      .map([&](const ItemContext& context) { return apply_context(item, context); });
}

/// Returns the words for a value. For a bit field, the other bits of the register remain unchanged.
Result<std::vector<std::uint16_t>> ItemExchange::encode_value(const RegisterItem& item, double value) {
  auto words = encode(item, value);
  const double written = decode_as_written(item, words);
  if (std::abs(written - value) > finest_step(item))
    return failure(FaultKind::out_of_range, place(item), fmt::format("cannot hold {}", value));
  if (item.type != RegisterType::bits || !item.readable) return words;
  const auto present = read_words(item);
  if (!present) return failure(present.error());
  words[0] = merge_bits(item, words[0], present->front());
  return words;
}

ItemExchange::UnitCheck ItemExchange::check_unit() {
  const auto now = registers_.breaks();
  if (now == accepted_breaks_ || recognised_.empty()) return UnitCheck::same;
  const auto before = recognised_;
  const auto asked_at = recognised_at_;
  const auto who = recognise(*recognised_item_);
  recognised_ = before;
  const bool is_same = who && who->who == before && registers_.breaks() == now;
  if (!is_same) recognised_at_ = asked_at;
  if (is_same) accepted_breaks_ = now;
  if (is_same) return UnitCheck::same;
  const bool has_answered = who || who.error().kind == FaultKind::mismatch || who.error().kind == FaultKind::refused;
  if (has_answered) another_answers_ = true;
  return has_answered && registers_.breaks() == now ? UnitCheck::another : UnitCheck::unanswered;
}

Result<void> ItemExchange::write_words(const RegisterItem& item, std::span<const std::uint16_t> words) {
  if (check_unit() != UnitCheck::same) return not_sent_fault(item);
  return registers_.write(write_function(item.write_function, words.size()), item.address, words);
}

/// Writes the words, even to a unit that does not answer. Does not query a unit that was identified recently, because
/// on a line that loses every second exchange the query would succeed and the write would be lost.
Result<void> ItemExchange::write_safe_words(const RegisterItem& item, std::span<const std::uint16_t> words) {
  const bool is_recent = !recognised_.empty() && pauses_.now() - recognised_at_ < kRecognisedFor;
  if (!is_recent && check_unit() == UnitCheck::another) return not_sent_fault(item);
  return registers_.write(write_function(item.write_function, words.size()), item.address, words);
}

Result<void> ItemExchange::write_unconfirmed(const RegisterItem& item, double value) {
  if (another_answers_) return not_sent_fault(item);
  const auto latest = [&](const RegisterItem& other) {
    return value_or_latest(other, failure(FaultKind::refused, place(other), "was never read"));
  };
  const auto context = read_context(map_, item, latest);
  if (!context) return failure(context.error());
  if (item.type == RegisterType::bits && item.readable)
    return failure(FaultKind::refused, place(item), "the other bits of its register are unknown");
  for (const auto& name : item.also)
    if (auto same = write_unconfirmed(this->item(name), value); !same) return same;
  auto words = encode(apply_context(item, *context), value);
  if (item.companion) {
    const auto more = encode(this->item(item.companion->item), item.companion->value);
    words.insert(words.end(), more.begin(), more.end());
  }
  return registers_.write_unconfirmed(write_function(item.write_function, words.size()), item.address, words);
}

Result<void> ItemExchange::perform_unconfirmed(const Sequence& sequence) {
  Result<void> all;
  for (const auto& step : sequence) {
    if (step.only_if) continue;
    if (step.kind == SequenceStep::Kind::pause) pauses_.rest(step.duration);
    if (step.kind != SequenceStep::Kind::write || step.source != SequenceStep::Source::number) continue;
    if (auto done = write_unconfirmed(item(step.item), step.value); !done && all) all = std::move(done);
  }
  return all;
}

tl::unexpected<Fault> ItemExchange::not_sent_fault(const RegisterItem& item) const {
  return failure(FaultKind::disconnected, place(item),
                 "not sent: the line was interrupted and the unit has not been identified since");
}

Result<void> ItemExchange::write_words(const RegisterItem& item, std::span<const std::uint16_t> words, int tries) {
  if (tries == 1) return write_words(item, words);
  for (;;) {
    auto sent = write_safe_words(item, words);
    if (sent || sent.error().kind == FaultKind::refused || --tries == 0) return sent;
    registers_.end_rest();
  }
}

Result<void> ItemExchange::write(const RegisterItem& item, double value, int tries) {
  const auto set = resolve_context(item);
  if (!set) return failure(set.error());
  auto words = encode_value(*set, value);
  if (!words) return failure(words.error());
  for (const auto& name : item.also) {
    const auto& other = this->item(name);
    const auto same = encode_value(other, value).and_then([&](const auto& its) { return write_words(other, its); });
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
  if (tries == 1 || !is_seen || sent.error().kind == FaultKind::refused) return sent;
  registers_.end_rest();
  if (check_unit() == UnitCheck::another) return sent;
  return wait_until_seen(*set, written) ? Result<void>{} : sent;
}

Result<void> ItemExchange::wait_until_seen(const RegisterItem& written, double value) {
  const auto& shown = written.seen_in.empty() ? item(written.name) : item(written.seen_in);
  const double tolerance = written.tolerance.value_or(kSameStep * finest_step(written));
  const auto end = pauses_.now() + written.seen_within;
  while (true) {
    const auto found = read_in_known_context(shown);
    // An answer without a value is followed by one with the value, if the unit needs time.
    if (!found && found.error().kind != FaultKind::out_of_range) return failure(found.error());
    if (found && std::abs(*found - value) <= tolerance) return {};
    if (!found && pauses_.now() >= end) return failure(found.error());
    if (pauses_.now() >= end)
      return failure(FaultKind::mismatch, place(shown),
                     fmt::format("reads {:.6g} after {:.6g} was written", *found, value));
    pauses_.rest(std::min(kPollInterval, end - pauses_.now()));
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
    const auto fits = evaluate(condition, shown, *found);
    if (!fits) return failure(fits.error());
    if (*fits) return {};
    if (pauses_.now() >= end)
      return failure(FaultKind::timeout, place(shown),
                     fmt::format("is {}, expected {} within {:g} s", meaning(shown, *found),
                                 condition.meanings.empty() ? "the expected value"
                                                            : fmt::format("{}", fmt::join(condition.meanings, " or ")),
                                 to_seconds(within)));
    pauses_.rest(std::min(kPollInterval, end - pauses_.now()));
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
  return write_date(target, add_duration(*now, step.duration));
}

Result<void> ItemExchange::perform_step(const SequenceStep& step, const Parameters& parameters) {
  if (step.only_if) {
    const auto found = read(item(step.only_if->item));
    if (!found) return failure(found.error());
    const auto fits = evaluate(*step.only_if, item(step.only_if->item), *found);
    if (!fits) return failure(fits.error());
    if (!*fits) return {};
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

Result<void> ItemExchange::perform_every_step(const Sequence& sequence) {
  Result<void> all;
  for (const auto& step : sequence)
    if (auto done = perform_step(step, {}); !done && all) all = std::move(done);
  return all;
}

}  // namespace gyrotherm::drivers
