// The arithmetic in which everything is made that is kept between calls.
#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

namespace dacrt {

/// Rounds to nearest and takes small numbers for what they are, as programs do that set nothing
/// else, as long as it lives. For what one caller makes and others use, whose flags may be other
/// ones.
class OrdinaryArithmetic {
 public:
  OrdinaryArithmetic(const OrdinaryArithmetic&) = delete;
  OrdinaryArithmetic& operator=(const OrdinaryArithmetic&) = delete;

#if defined(__SSE2__)
  // The vector unit's flags only: nothing is computed by the older one, whose flags take long to
  // set.
  OrdinaryArithmetic() : callers_(_mm_getcsr()) {
    if (IsOther()) _mm_setcsr(kOrdinary);
  }
  ~OrdinaryArithmetic() {
    if (IsOther()) _mm_setcsr(callers_);
  }

 private:
  static constexpr unsigned kOrdinary = 0x1F80;  ///< as processes begin: no exception traps
  static constexpr unsigned kRaised = 0x3F;      ///< bits that say what happened
  bool IsOther() const { return (callers_ & ~kRaised) != kOrdinary; }
  const unsigned callers_;
#else
  OrdinaryArithmetic() {
    std::fegetenv(&callers_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~OrdinaryArithmetic() { std::fesetenv(&callers_); }

 private:
  std::fenv_t callers_;
#endif
};

}  // namespace dacrt
