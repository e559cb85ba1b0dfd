#include "analysis/svm/kernel_source.hpp"

#include <algorithm>
#include <cassert>

namespace gyrotherm {

void MatrixSource::single_row(Eigen::Index i, float* out) const {
  const auto row = matrix_.col(i);
  for (Eigen::Index j = 0; j < row.size(); ++j) out[j] = static_cast<float>(row[j]);
  std::fill(out + row.size(), out + padded_row(row.size()), 0.0F);
}

void MatrixSource::double_column(Eigen::Index i, Eigen::Index from, double* out) const {
  const auto column = matrix_.col(i);
  std::copy(column.data() + from, column.data() + column.size(), out + from);
  std::fill(out + column.size(), out + padded_column(column.size()), 0.0);
}

float* KernelMemory::singles(Eigen::Index n) {
  const std::size_t size = static_cast<std::size_t>(n) * padded_row(n);
  if (size > singles_size_) {
    singles_.reset();
    singles_ = std::make_unique_for_overwrite<float[]>(size);
    singles_size_ = size;
  }
  return singles_.get();
}

double* KernelMemory::column(Eigen::Index n, std::size_t k) {
  if (padded_column(n) > column_size_) {
    columns_.clear();
    column_size_ = padded_column(n);
  }
  while (columns_.size() <= k) columns_.push_back(std::make_unique_for_overwrite<double[]>(column_size_));
  return columns_[k].get();
}

std::size_t least_kernel_bytes(Eigen::Index n) {
  return static_cast<std::size_t>(n) * padded_row(n) * sizeof(float) +
         Kernel::kSpare * padded_column(n) * sizeof(double);
}

Kernel::Kernel(const KernelSource& source, KernelMemory& memory, std::size_t column_bytes)
    : source_(source),
      memory_(memory),
      row_stride_(padded_row(source.size())),
      singles_(memory.singles(source.size())),
      has_row_(static_cast<std::size_t>(source.size())),
      columns_(static_cast<std::size_t>(source.size())),
      most_(std::max<std::size_t>(column_bytes / (sizeof(double) * padded_column(source.size())), 1)) {}

const float* Kernel::row(Eigen::Index i) {
  float* row = singles_ + static_cast<std::size_t>(i) * row_stride_;
  if (!has_row_[i]) source_.single_row(i, row);
  has_row_[i] = 1;
  return row;
}

const double* Kernel::column(Eigen::Index i) {
  if (columns_[i] != nullptr) return columns_[i];
  columns_[i] = source_.stored_column(i);
  if (columns_[i] != nullptr) return columns_[i];
  if (made_ < most_) {
    double* made = memory_.column(size(), kSpare + made_++);
    source_.double_column(i, 0, made);
    return columns_[i] = made;
  }
  return passing_column(i, 0);
}

double* Kernel::passing_column(Eigen::Index i, Eigen::Index from) {
  double* spare = memory_.column(size(), spare_++ % kSpare);
  source_.double_column(i, from, spare);
  return spare;
}

}  // namespace gyrotherm
