// Where the two libraries are, and what counts calls.
#pragma once

#include <string>

namespace dacrt::compare {

/// This program.
std::string OwnPath();

/// dacrt's libembree3.so.3 and the counting library: beside this program, or where they are
/// installed. Throw std::runtime_error if they are not there.
std::string FindDropIn();
std::string FindCounter();

/// The libembree3.so.3 that the system finds. Throws std::runtime_error if there is none, or if it
/// is `drop_in`.
std::string FindEmbree(const std::string& drop_in);

/// Whether both are the same file.
bool IsSameFile(const std::string& a, const std::string& b);

}  // namespace dacrt::compare
