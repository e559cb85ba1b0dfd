#include "drivers/chamber/modbus_chamber.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace gyrotherm {

namespace {

/// Of a register's resolution: more than rounding can make, less than a step to the next value.
constexpr double kSameStep = 0.75;

std::string place(const RegisterItem& item) { return fmt::format("chamber register {} ({})", item.address, item.name); }

/// The registers from the first word of the first item to the last word of the last.
struct Block {
  std::uint16_t first{};
  std::uint16_t count{};
};

class ModbusChamber final : public Chamber {
 public:
  ModbusChamber(RegisterMap map, std::unique_ptr<Registers> registers)
      : map_(std::move(map)),
        registers_(std::move(registers)),
        air_(item("air_temperature")),
        set_point_(item("set_point")),
        identity_(map_.identity ? &item(map_.identity->item) : nullptr),
        block_(common_block()) {}

  Result<std::string> identify() override;
  Result<ChamberState> read() override;
  Result<void> head_for(Celsius target) override;
  Result<void> start() override;
  Result<void> stop() override;

 private:
  [[nodiscard]] const RegisterItem& item(std::string_view name) const;
  [[nodiscard]] Block common_block() const;
  [[nodiscard]] Result<double> read_item(const RegisterItem& item);
  [[nodiscard]] Result<void> write_item(const RegisterItem& item, double value, const RegisterItem& seen_in);
  [[nodiscard]] Result<void> check_identity(double found) const;
  [[nodiscard]] Result<ChamberState> read_block();
  [[nodiscard]] Result<void> switch_to(std::int64_t code);

  RegisterMap map_;
  std::unique_ptr<Registers> registers_;
  const RegisterItem& air_;
  const RegisterItem& set_point_;
  const RegisterItem* identity_;
  Block block_;
};

const RegisterItem& ModbusChamber::item(std::string_view name) const {
  const auto* found = map_.find(name);
  assert(found && "parse_register_map() lets no such map pass");
  return *found;
}

Block ModbusChamber::common_block() const {
  int first = std::min(air_.address, set_point_.address);
  int end = std::max(air_.address + word_count(air_.type), set_point_.address + word_count(set_point_.type));
  if (identity_) {
    first = std::min<int>(first, identity_->address);
    end = std::max(end, identity_->address + word_count(identity_->type));
  }
  return {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(end - first)};
}

Result<double> ModbusChamber::read_item(const RegisterItem& item) {
  const auto words = registers_->read(item.address, word_count(item.type));
  if (!words) return failure(words.error());
  return decode(item, *words);
}

/// Writes `value`, then asks `seen_in` for it: an acknowledged write is not yet an applied one.
Result<void> ModbusChamber::write_item(const RegisterItem& item, double value, const RegisterItem& seen_in) {
  const auto words = encode(item, value);
  const auto written = decode(item, words);
  if (!written || std::abs(*written - value) > item.resolution)
    return failure(FaultKind::out_of_range, place(item), fmt::format("cannot hold {}", value));
  if (auto sent = registers_->write(item.address, words); !sent) return sent;

  const auto found = read_item(seen_in);
  if (!found) return failure(found.error());
  if (std::abs(*found - *written) < kSameStep * item.resolution) return {};
  return failure(FaultKind::mismatch, place(seen_in), fmt::format("reads {} after {} was written", *found, *written));
}

Result<void> ModbusChamber::check_identity(double found) const {
  if (found == map_.identity->value) return {};
  return failure(FaultKind::mismatch, place(*identity_),
                 fmt::format("holds {}, expected {} of a {} {}", found, map_.identity->value, map_.vendor, map_.name));
}

Result<std::string> ModbusChamber::identify() {
  const auto who = fmt::format("{} {}", map_.vendor, map_.name);
  const auto found = read_item(identity_ ? *identity_ : air_);
  if (!found) return failure(found.error());
  if (!identity_) return who + " (its map has no fingerprint to check)";
  if (auto same = check_identity(*found); !same) return failure(std::move(same.error()));
  return fmt::format("{} ({} = {})", who, identity_->name, *found);
}

Result<ChamberState> ModbusChamber::read_block() {
  const auto words = registers_->read(block_.first, block_.count);
  if (!words) return failure(words.error());
  const auto value = [&](const RegisterItem& item) {
    return decode(item, std::span(*words).subspan(item.address - block_.first, word_count(item.type)));
  };
  if (identity_) {
    const auto same = value(*identity_).and_then([&](double found) { return check_identity(found); });
    if (!same) return failure(same.error());
  }
  const auto air = value(air_), set_point = value(set_point_);
  if (!air) return failure(air.error());
  if (!set_point) return failure(set_point.error());
  return ChamberState{{*air}, {*set_point}};
}

Result<ChamberState> ModbusChamber::read() {
  if (map_.one_block) return read_block();
  const auto air = read_item(air_);
  if (!air) return failure(air.error());
  const auto set_point = read_item(set_point_);
  if (!set_point) return failure(set_point.error());
  return ChamberState{{*air}, {*set_point}};
}

Result<void> ModbusChamber::head_for(Celsius target) { return write_item(set_point_, target.value, set_point_); }

Result<void> ModbusChamber::switch_to(std::int64_t code) {
  return write_item(item(map_.control->commanded), static_cast<double>(code), item(map_.control->active));
}

Result<void> ModbusChamber::start() { return map_.control ? switch_to(map_.control->on) : Result<void>{}; }

Result<void> ModbusChamber::stop() {
  if (!map_.control) return failure(FaultKind::refused, "chamber stop", "its register map has no [control]");
  return switch_to(map_.control->off);
}

}  // namespace

std::unique_ptr<Chamber> make_modbus_chamber(RegisterMap map, std::unique_ptr<Registers> registers) {
  return std::make_unique<ModbusChamber>(std::move(map), std::move(registers));
}

}  // namespace gyrotherm
