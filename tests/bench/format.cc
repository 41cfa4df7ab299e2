#include "format.h"

#include <cstdio>

namespace dacrt::bench {

std::string Fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

std::string Significant(double value) { return Fixed(value, value < 1 ? 3 : value < 10 ? 2 : 1); }

std::string Seconds(double seconds) {
  return Fixed(seconds, seconds < 1 ? 4 : seconds < 10 ? 3 : seconds < 100 ? 2 : 1);
}

std::string ThreadsText(int threads) {
  return std::to_string(threads) + (threads == 1 ? " thread" : " threads");
}

std::string Grouped(std::size_t count) {
  std::string text = std::to_string(count);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ' ');
  return text;
}

std::string Squared(std::size_t side) { return std::to_string(side) + "^2"; }

}  // namespace dacrt::bench
