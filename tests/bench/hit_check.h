// That every method finds the same hits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "ray_buffer.h"

namespace dacrt::bench {

/// Compares the hits in one batch, bit for bit, each time that it has been traced.
class HitCheck {
 public:
  explicit HitCheck(Query query) : query_(query) {}

  /// Keeps the hits of the first call. Throws Disagreement (errors.h) from a later one unless its
  /// hits are the same. `method` is what found them.
  void Check(const std::string& method, const RayBuffer& rays);

 private:
  [[noreturn]] void Fail(const std::string& method, const RayBuffer& rays, std::size_t differences,
                         std::size_t first) const;

  const Query query_;
  std::string first_method_;
  std::vector<uint64_t> fingerprints_;
};

}  // namespace dacrt::bench
