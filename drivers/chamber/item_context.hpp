/// What the instrument itself has set of a register's form: where its decimal point is, and whether it shows °F.
#pragma once

#include <functional>

#include "core/result.hpp"
#include "drivers/chamber/register_item.hpp"
#include "drivers/chamber/register_map.hpp"

namespace gyrotherm {

using ValueOf = std::function<Result<double>(const RegisterItem&)>;

/// The context of `item` as the registers that it names say it; empty if it names none. `value_of` gives such a
/// register's value. Fails as that does, or with corrupted if the value is no count of decimals from 0 to 6 or no unit.
[[nodiscard]] Result<ItemContext> context_of(const RegisterMap& map, const RegisterItem& item, const ValueOf& value_of);

}  // namespace gyrotherm
