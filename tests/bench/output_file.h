// Files that are written whole or not at all.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace dacrt::bench {

/// Writes `text` beside `path` and moves it there, so that `path` is never half written.
/// Throws OutputError (errors.h).
void WriteFile(const std::filesystem::path& path, const std::string& text);

/// The document as text. Bytes that are no UTF-8, as paths may have, are replaced.
std::string JsonText(const nlohmann::ordered_json& json);

}  // namespace dacrt::bench
