/// Words of register maps, and of the rig files that name one, with what they stand for.
#pragma once

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"

namespace gyrotherm {

inline constexpr Vocabulary<WordOrder, 4> kWordOrders{
    {{"abcd", WordOrder::abcd}, {"cdab", WordOrder::cdab}, {"badc", WordOrder::badc}, {"dcba", WordOrder::dcba}}};
inline constexpr Vocabulary<LinkKind, 3> kLinkKinds{
    {{"tcp", LinkKind::tcp}, {"rtu", LinkKind::rtu}, {"rtu_over_tcp", LinkKind::rtu_over_tcp}}};
inline constexpr Vocabulary<ReadFunction, 4> kReadFunctions{{{"coils", ReadFunction::coils},
                                                             {"discrete_inputs", ReadFunction::discrete_inputs},
                                                             {"holding_registers", ReadFunction::holding_registers},
                                                             {"input_registers", ReadFunction::input_registers}}};
inline constexpr Vocabulary<WriteFunction, 3> kWriteFunctions{{{"coil", WriteFunction::coil},
                                                               {"one_register", WriteFunction::one_register},
                                                               {"registers", WriteFunction::registers}}};
inline constexpr Vocabulary<Confidence, 4> kConfidences{{{"verified", Confidence::verified},
                                                         {"manual", Confidence::manual},
                                                         {"secondary", Confidence::secondary},
                                                         {"unverified", Confidence::unverified}}};

}  // namespace gyrotherm
