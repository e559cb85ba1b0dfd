/// Pieces of the reader of a rig file's [virtual] table.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/toml_reader.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm {

/// Numbers with a condition; one that breaks it is a mistake at its key.
[[nodiscard]] double positive(const TomlTable& table, const char* key);
[[nodiscard]] double not_negative(const TomlTable& table, const char* key);
[[nodiscard]] double not_negative(const TomlTable& table, const char* key, double fallback);
/// A time constant that a step of one second can follow.
[[nodiscard]] double time_constant_s(const TomlTable& table, const char* key);
[[nodiscard]] double time_constant_s(const TomlTable& table, const char* key, double fallback);
/// As many numbers as wanted, none below `least`; on a mistake that many zeros.
[[nodiscard]] std::vector<double> numbers(const TomlTable& table, const char* key, std::size_t count, double least);

/// [virtual.network] and [virtual.bias] of a rig whose body is "reference".
[[nodiscard]] LumpedGyroParameters read_lumped_gyro(const TomlTable& table);

/// [virtual.thermal] with its spread, and [virtual.bias] of a rig whose body is "twin". The model is left
/// empty: another file has it.
[[nodiscard]] ReducedGyroParameters read_reduced_gyro(const TomlTable& table);

}  // namespace gyrotherm
