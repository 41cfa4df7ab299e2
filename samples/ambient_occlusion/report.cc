#include "ambient_occlusion/report.h"

#include <sys/resource.h>

#include <cstdio>

namespace ao {
namespace {

std::string WithThousands(uint64_t number) {
  std::string digits = std::to_string(number);
  for (int place = int(digits.size()) - 3; place > 0; place -= 3) digits.insert(place, 1, ',');
  return digits;
}

void PrintRow(const char* step, const std::string& count, double seconds) {
  std::printf("%-13s %13s %9.3f", step, count.c_str(), seconds);
}

void PrintTraced(const char* step, const Traced& traced) {
  PrintRow(step, WithThousands(traced.rays), traced.seconds);
  if (traced.rays > 0) std::printf(" %10.2f", double(traced.rays) / traced.seconds / 1e6);
  std::printf("\n");
}

}  // namespace

void Print(const Report& report) {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%s: %s triangles\n", report.mesh.c_str(), WithThousands(report.triangles).c_str());
  std::printf("%-13s %13s %9s %10s\n", "", "rays", "seconds", "M rays/s");
  PrintRow("commit", "", report.commit_seconds);
  std::printf("\n");
  PrintTraced("closest hit", report.closest_hit);
  PrintTraced("occlusion", report.occlusion);
  std::printf("peak memory: %ld MB\n", usage.ru_maxrss / 1024);
  std::printf("picture: %s\n", report.picture.c_str());
}

}  // namespace ao
