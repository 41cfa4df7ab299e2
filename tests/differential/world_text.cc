#include "world_text.h"

#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <istream>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <type_traits>

namespace dacrt::tests {
namespace {

/// Writing and reading visit the same members in the same order.
class Writer {
 public:
  explicit Writer(std::ostream& out) : out_(out) {}

  void Name(const char* name) { out_ << '\n' << name; }
  void NewLine() { out_ << '\n'; }

  void Value(float& value) {
    // Hexadecimal: exact, and short where the value is round.
    char text[32];
    std::snprintf(text, sizeof(text), " %a", static_cast<double>(value));
    out_ << text;
  }
  void Value(uint32_t& value) { out_ << ' ' << value; }
  void Value(std::string& value) { out_ << ' ' << (value.empty() ? "-" : value); }

 private:
  std::ostream& out_;
};

class Reader {
 public:
  explicit Reader(std::istream& in) : in_(in) {}

  void Name(const char* name) {
    const std::string token = Token();
    if (token != name) {
      throw std::runtime_error("expected " + std::string(name) + ", found " + token);
    }
  }
  void NewLine() {}

  void Value(float& value) {
    const std::string token = Token();
    char* end = nullptr;
    value = std::strtof(token.c_str(), &end);
    if (*end != '\0') throw std::runtime_error("expected a number, found " + token);
  }
  void Value(uint32_t& value) {
    const std::string token = Token();
    char* end = nullptr;
    const unsigned long number = std::strtoul(token.c_str(), &end, 10);
    if (*end != '\0' || number > UINT32_MAX) {
      throw std::runtime_error("expected a count, found " + token);
    }
    value = static_cast<uint32_t>(number);
  }
  void Value(std::string& value) {
    value = Token();
    if (value == "-") value.clear();
  }

 private:
  std::string Token() {
    std::string token;
    while (in_ >> token && token.starts_with('#')) {
      in_.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    if (!in_) throw std::runtime_error("the text ends too early");
    return token;
  }

  std::istream& in_;
};

template <typename Archive, typename T>
requires std::is_enum_v<T> || std::is_same_v<T, bool>
void Visit(Archive& archive, T& value) {
  auto number = static_cast<uint32_t>(value);
  archive.Value(number);
  value = static_cast<T>(number);
}

template <typename Archive, typename T>
requires std::is_same_v<T, float> || std::is_same_v<T, uint32_t> || std::is_same_v<T, std::string>
void Visit(Archive& archive, T& value) { archive.Value(value); }

template <typename Archive, typename T, std::size_t kCount>
void Visit(Archive& archive, std::array<T, kCount>& values) {
  for (T& value : values) Visit(archive, value);
}

template <typename Archive, typename... Values>
void VisitField(Archive& archive, const char* name, Values&... values) {
  archive.Name(name);
  (Visit(archive, values), ...);
}

template <typename Archive>
void Visit(Archive& archive, Float3& vector) {
  for (float* const value : {&vector.x, &vector.y, &vector.z}) archive.Value(*value);
}

template <typename Archive>
void Visit(Archive& archive, Vertex& vertex) {
  for (float* const value : {&vertex.x, &vertex.y, &vertex.z, &vertex.radius}) {
    archive.Value(*value);
  }
}

template <typename Archive>
void Visit(Archive& archive, Placement& placement) {
  Visit(archive, placement.matrix);
  Visit(archive, placement.parts);
}

template <typename Archive>
void Visit(Archive& archive, RTCRayHit& record) {
  // As bits, because what a record holds before a call may be anything.
  auto words = std::bit_cast<std::array<uint32_t, sizeof(RTCRayHit) / sizeof(uint32_t)>>(record);
  Visit(archive, words);
  record = std::bit_cast<RTCRayHit>(words);
}

/// Items a line each, after their number.
template <typename Archive, typename Item>
void VisitItems(Archive& archive, const char* name, std::vector<Item>& items) {
  auto count = static_cast<uint32_t>(items.size());
  VisitField(archive, name, count);
  items.resize(count);
  for (Item& item : items) {
    archive.NewLine();
    Visit(archive, item);
  }
}

template <typename Archive, typename Item>
void Visit(Archive& archive, std::vector<Item>& items) {
  VisitItems(archive, "step", items);
}

template <typename Archive>
void Visit(Archive& archive, WorldGeometry& g) {
  VisitField(archive, "geometry", g.shape, g.id, g.mask);
  VisitField(archive, "state", g.enabled, g.attached, g.quality);
  VisitField(archive, "filters", g.closest_filter, g.any_filter);
  VisitField(archive, "time", g.time_begin, g.time_end);
  VisitField(archive, "layout", g.layout.memory, g.layout.offset, g.layout.gap);
  VisitItems(archive, "vertices", g.vertices);
  VisitItems(archive, "normals", g.normals);
  VisitItems(archive, "primitives", g.primitives);
  VisitField(archive, "instance", g.instanced_scene, g.in_parts, g.transform_format,
             g.traces_again);
  VisitItems(archive, "placements", g.placements);
}

template <typename Archive>
void Visit(Archive& archive, WorldScene& scene) {
  VisitField(archive, "scene", scene.flags, scene.quality);
  VisitItems(archive, "geometries", scene.geometries);
}

template <typename Archive>
void Visit(Archive& archive, Change& change) {
  VisitField(archive, "change", change.kind, change.scene, change.geometry, change.shift,
             change.mask, change.closest_filter, change.any_filter);
}

template <typename Archive>
void Visit(Archive& archive, Batch& batch) {
  VisitField(archive, "batch", batch.query, batch.context_filter, batch.rays_per_call,
             batch.ray_kind);
  Form& form = batch.form;
  VisitField(archive, "form", form.call, form.coherent, form.lanes, form.gap);
  VisitItems(archive, "rays", batch.rays);
}

template <typename Archive>
void Visit(Archive& archive, Stage& stage) {
  VisitItems(archive, "changes", stage.changes);
  VisitItems(archive, "batches", stage.batches);
}

template <typename Archive>
void Visit(Archive& archive, World& world) {
  VisitField(archive, "world", world.real_config, world.drop_in_config);
  VisitItems(archive, "scenes", world.scenes);
  VisitItems(archive, "stages", world.stages);
}

}  // namespace

void Write(std::ostream& out, const World& world) {
  Writer writer(out);
  World copy = world;
  Visit(writer, copy);
  out << '\n';
}

World ReadWorld(std::istream& in) {
  Reader reader(in);
  World world;
  Visit(reader, world);
  return world;
}

}  // namespace dacrt::tests
