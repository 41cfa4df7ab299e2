// Arrays that outlive the expression in which they are named.
#pragma once

#include <ranges>

namespace dacrt {

/// Contiguous elements that stay where they are when the expression ends: a std::vector, std::array
/// or array with a name, a std::span; not a temporary std::vector.
template <class Range>
concept ArrayInPlace = std::ranges::contiguous_range<Range> && std::ranges::sized_range<Range> &&
    std::ranges::borrowed_range<Range>;

}  // namespace dacrt
