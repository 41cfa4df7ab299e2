#include "output_file.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <system_error>

#include "errors.h"

namespace dacrt::bench {

void WriteFile(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::path unfinished = path;
  unfinished += ".unfinished";
  std::ofstream file(unfinished, std::ios::binary);
  file << text;
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(unfinished, path, error);
  if (!file || error) {
    std::filesystem::remove(unfinished, error);
    throw OutputError(path.string() + ": cannot be written");
  }
}

std::string JsonText(const nlohmann::ordered_json& json) {
  constexpr int kIndent = 1;
  return json.dump(kIndent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace dacrt::bench
