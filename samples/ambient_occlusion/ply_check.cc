#include "ambient_occlusion/ply_check.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "ambient_occlusion/error.h"

namespace ao {
namespace {

// One value of so many bytes, or a list of such values after its length.
struct Property {
  int bytes;
  int length_bytes = 0;  // 0: not a list
};

struct Element {
  uint64_t count;
  std::vector<Property> properties;

  bool HasList() const {
    return std::any_of(properties.begin(), properties.end(),
                       [](const Property& property) { return property.length_bytes > 0; });
  }
};

struct Header {
  std::string format;
  std::vector<Element> elements;
  bool complete = false;
};

int BytesOf(const std::string& type) {
  static const std::map<std::string, int> kBytes = {
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto found = kBytes.find(type);
  return found == kBytes.end() ? 0 : found->second;
}

Header ReadHeader(std::istream& file) {
  Header header;
  std::string line;
  while (!header.complete && std::getline(file, line)) {
    std::istringstream words(line);
    std::string keyword;
    words >> keyword;
    if (keyword == "format") {
      words >> header.format;
    } else if (keyword == "element") {
      std::string name;
      Element element{};
      words >> name >> element.count;
      header.elements.push_back(element);
    } else if (keyword == "property" && !header.elements.empty()) {
      std::string type;
      std::string length_type;
      words >> type;
      if (type == "list") words >> length_type >> type;
      header.elements.back().properties.push_back({BytesOf(type), BytesOf(length_type)});
    }
    header.complete = keyword == "end_header";
  }
  return header;
}

bool SkipBytes(std::istream& file, uint64_t bytes) {
  file.ignore(std::streamsize(bytes));
  return uint64_t(file.gcount()) == bytes;
}

bool SkipBinary(std::istream& file, const Property& property, bool big_endian) {
  uint64_t values = 1;
  if (property.length_bytes > 0) {
    std::array<unsigned char, 8> bytes;
    if (!file.read(reinterpret_cast<char*>(bytes.data()), property.length_bytes)) return false;
    if (!big_endian) std::reverse(bytes.begin(), bytes.begin() + property.length_bytes);
    values = 0;
    for (int i = 0; i < property.length_bytes; ++i) values = values << 8 | bytes[i];
  }
  return SkipBytes(file, values * property.bytes);
}

bool SkipAscii(std::istream& file, const Property& property) {
  std::string word;
  uint64_t values = 1;
  if (property.length_bytes > 0 && !(file >> values)) return false;
  for (uint64_t i = 0; i < values; ++i) {
    if (!(file >> word)) return false;
  }
  return true;
}

bool SkipElement(std::istream& file, const Element& element, const std::string& format) {
  if (format != "ascii" && !element.HasList()) {
    uint64_t bytes = 0;
    for (const Property& property : element.properties) bytes += property.bytes;
    return SkipBytes(file, bytes * element.count);
  }
  for (uint64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      const bool complete = format == "ascii"
                                ? SkipAscii(file, property)
                                : SkipBinary(file, property, format == "binary_big_endian");
      if (!complete) return false;
    }
  }
  return true;
}

}  // namespace

void CheckPlyIsComplete(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const Header header = ReadHeader(file);
  if (!header.complete) throw Error(ExitCode::kMesh, "there is no complete PLY header in it");
  const bool complete = std::all_of(
      header.elements.begin(), header.elements.end(),
      [&](const Element& element) { return SkipElement(file, element, header.format); });
  if (!complete) throw Error(ExitCode::kMesh, "the file ends before all that its header announces");
}

}  // namespace ao
