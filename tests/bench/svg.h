// Drawings as SVG: a handful of shapes, y downwards, in pixels.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace dacrt::bench {

class Svg {
 public:
  enum class Anchor { kStart, kMiddle, kEnd };
  struct Point {
    double x, y;
  };
  struct TextStyle {
    Anchor anchor = Anchor::kStart;
    double size = 11;
    bool bold = false;
    const char* colour = "#222222";
  };

  void Rect(Point corner, double width, double height, const char* fill);
  void Line(Point from, Point to, const char* stroke, double width = 1);
  void Dashes(Point from, Point to, const char* stroke);
  void Polyline(const std::vector<Point>& points, const char* stroke);
  void Dot(Point centre, double radius, const char* fill);

  /// The text stands on `at`.
  void Text(Point at, const std::string& text, const TextStyle& style);

  /// The document, on white.
  std::string Finish(double width, double height) const;

 private:
  std::string body_;
};

}  // namespace dacrt::bench
