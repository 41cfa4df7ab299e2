// What the process takes.
#pragma once

#include <cstddef>

namespace dacrt::tests {

/// Bytes of the heap that are in use.
std::size_t HeapInUse();

/// The most physical memory that the process has held since the last call, in bytes.
std::size_t TakePeakMemory();

}  // namespace dacrt::tests
