#include "svg.h"

#include "format.h"

namespace dacrt::bench {
namespace {

constexpr const char* kAnchors[] = {"start", "middle", "end"};  // by Svg::Anchor

// ` name="value"`
std::string Attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + value + '"';
}

std::string Attribute(const char* name, double value) { return Attribute(name, Fixed(value, 1)); }

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string Ends(Svg::Point from, Svg::Point to) {
  return Attribute("x1", from.x) + Attribute("y1", from.y) + Attribute("x2", to.x) +
         Attribute("y2", to.y);
}

}  // namespace

void Svg::Rect(Point corner, double width, double height, const char* fill) {
  body_ += "<rect" + Attribute("x", corner.x) + Attribute("y", corner.y) +
           Attribute("width", width) + Attribute("height", height) + Attribute("fill", fill) +
           "/>\n";
}

void Svg::Line(Point from, Point to, const char* stroke, double width) {
  body_ += "<line" + Ends(from, to) + Attribute("stroke", stroke) +
           Attribute("stroke-width", width) + "/>\n";
}

void Svg::Dashes(Point from, Point to, const char* stroke) {
  body_ += "<line" + Ends(from, to) + Attribute("stroke", stroke) +
           Attribute("stroke-dasharray", "4 3") + "/>\n";
}

void Svg::Polyline(const std::vector<Point>& points, const char* stroke) {
  std::string list;
  for (const Point& point : points) {
    if (!list.empty()) list += ' ';
    list += Fixed(point.x, 1) + ',' + Fixed(point.y, 1);
  }
  body_ += "<polyline" + Attribute("points", list) + Attribute("fill", "none") +
           Attribute("stroke", stroke) + Attribute("stroke-width", 2) + "/>\n";
}

void Svg::Dot(Point centre, double radius, const char* fill) {
  body_ += "<circle" + Attribute("cx", centre.x) + Attribute("cy", centre.y) +
           Attribute("r", radius) + Attribute("fill", fill) + "/>\n";
}

void Svg::Text(Point at, const std::string& text, const TextStyle& style) {
  body_ += "<text" + Attribute("x", at.x) + Attribute("y", at.y) +
           Attribute("font-size", style.size) + Attribute("fill", style.colour) +
           Attribute("text-anchor", kAnchors[static_cast<int>(style.anchor)]) +
           (style.bold ? Attribute("font-weight", "bold") : "") + ">" + Escaped(text) + "</text>\n";
}

std::string Svg::Finish(double width, double height) const {
  return "<svg" + Attribute("xmlns", "http://www.w3.org/2000/svg") + Attribute("width", width) +
         Attribute("height", height) +
         Attribute("viewBox", "0 0 " + Fixed(width, 1) + ' ' + Fixed(height, 1)) +
         Attribute("font-family", "Helvetica, Arial, sans-serif") +
         ">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" + body_ + "</svg>\n";
}

}  // namespace dacrt::bench
