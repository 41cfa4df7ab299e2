#include "isa.h"

namespace dacrt::bench {

std::vector<std::string> IsasHere() {
  std::vector<std::string> names;
  if (__builtin_cpu_supports("avx512vl")) names.push_back("avx512");
  if (__builtin_cpu_supports("avx2")) names.push_back("avx2");
  names.push_back("sse4.2");
  return names;
}

std::vector<std::string> IsasWithin(const std::string& isa) {
  if (isa == "avx512") return {"avx2", "avx512"};
  return {isa};
}

}  // namespace dacrt::bench
