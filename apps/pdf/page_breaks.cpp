// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/page_breaks.hpp"

#include <algorithm>
#include <utility>

namespace gyrotherm::report {
namespace {

/// Pieces that keep together.
struct Chain {
  std::size_t first{}, last{};
  double height{};      ///< with the spaces inside
  double shrinkable{};  ///< of it
};

class Pages {
 public:
  Pages(const std::vector<Extent>& extents, double page_height) : extents_(extents), room_(page_height) {}

  std::vector<Placement> fill() && {
    for (std::size_t i = 0; i < extents_.size();) {
      Chain chain = chain_of(i, last_kept_with(i));
      if (!fits_a_page(chain)) chain = chain_of(i, i);
      if (!fits(chain) && top_ > 0) turn();
      place(chain);
      i = chain.last + 1;
    }
    return std::move(placed_);
  }

 private:
  std::size_t last_kept_with(std::size_t first) const {
    while (extents_[first].keep_with_next && first + 1 < extents_.size()) ++first;
    return first;
  }

  Chain chain_of(std::size_t first, std::size_t last) const {
    Chain chain{.first = first, .last = last, .height = 0, .shrinkable = 0};
    for (std::size_t i = first; i <= last; ++i) {
      chain.height += extents_[i].height + (i > first ? extents_[i].space_before : 0);
      chain.shrinkable += shrinkable(extents_[i]);
    }
    return chain;
  }

  static double shrinkable(const Extent& extent) {
    return extent.least_height > 0 ? extent.height - extent.least_height : 0;
  }

  /// What comes before the first piece: its space, or what is repeated at the top of a page.
  double before(std::size_t first) const { return top_ > 0 ? extents_[first].space_before : extents_[first].repeated; }

  bool fits(const Chain& chain) const {
    return top_ + before(chain.first) + chain.height - chain.shrinkable <= room_ + kRounding;
  }

  bool fits_a_page(const Chain& chain) const {
    return extents_[chain.first].repeated + chain.height - chain.shrinkable <= room_ + kRounding;
  }

  void turn() {
    ++page_;
    top_ = 0;
  }

  void place(const Chain& chain) {
    const double too_much = std::max(0.0, top_ + before(chain.first) + chain.height - room_);
    const double taken = chain.shrinkable > 0 ? std::min(1.0, too_much / chain.shrinkable) : 0;
    for (std::size_t i = chain.first; i <= chain.last; ++i) {
      const Extent& extent = extents_[i];
      const bool repeats = top_ == 0 && extent.repeated > 0;
      top_ += i == chain.first ? before(i) : extent.space_before;
      const double height = extent.height - taken * shrinkable(extent);
      placed_.push_back({.page = page_, .top = top_, .height = height, .repeats = repeats});
      top_ += height;
    }
  }

  static constexpr double kRounding = 1e-6;
  const std::vector<Extent>& extents_;
  double room_;
  double top_ = 0;
  std::size_t page_ = 0;
  std::vector<Placement> placed_{};
};

}  // namespace

std::vector<Placement> page_breaks(const std::vector<Extent>& extents, double page_height) {
  return Pages(extents, page_height).fill();
}

}  // namespace gyrotherm::report
