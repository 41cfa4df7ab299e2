#include "memory_figures.h"

#include <malloc.h>

#include <fstream>
#include <string>

namespace dacrt::tests {

std::size_t HeapInUse() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

std::size_t TakePeakMemory() {
  std::size_t kilobytes = 0;
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) kilobytes = std::stoull(line.substr(6));
  }
  std::ofstream("/proc/self/clear_refs") << 5;  // the kernel's way to begin anew
  return kilobytes << 10;
}

}  // namespace dacrt::tests
