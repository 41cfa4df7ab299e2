#include "program_comparison.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <vector>

#include "errors.h"
#include "exit_codes.h"
#include "format.h"
#include "libraries.h"
#include "output_file.h"
#include "program_run.h"
#include "progress.h"
#include "table.h"
#include "verdict.h"

namespace dacrt::compare {
namespace {

using bench::Fixed;
using bench::Grouped;

/// The run whose time in the library is the median.
const ProgramRun& MedianRun(std::vector<ProgramRun>& runs) {
  std::ranges::sort(runs, {}, &ProgramRun::SecondsInside);
  return runs[(runs.size() - 1) / 2];
}

std::string Ended(const ProgramRun& run) {
  std::string text = "exit code ";
  text += std::to_string(run.exit_code);
  if (!run.last_words.empty()) text.append(", after \"").append(run.last_words).append("\"");
  return text;
}

void CheckWithEmbree(const std::string& program, const ProgramRun& run, const Options& options) {
  if (run.devices == 0) {
    throw ProgramError(program + ": makes no call of Embree 3 that can be seen (" + Ended(run) +
                       ")");
  }
  if (IsSameFile(run.library, options.drop_in)) {
    throw ProgramError(program + ": runs with " + run.library +
                       " already, which is dacrt's; name Embree's with --embree");
  }
  if (run.exit_code != 0) throw ProgramError(program + ": does not run with Embree: " + Ended(run));
}

void CheckWithDacrt(const std::string& program, const ProgramRun& run, const Options& options) {
  if (run.devices > 0 && !IsSameFile(run.library, options.drop_in)) {
    throw ProgramError(program + ": does not let itself be given dacrt's library: it takes " +
                       run.library);
  }
}

std::string Ratio(double embree, double dacrt) {
  return embree > 0 && dacrt > 0 ? Fixed(embree / dacrt, 2) : "";
}

nlohmann::ordered_json ToJson(const ProgramRun& run) {
  nlohmann::ordered_json calls = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < kKinds; ++k) {
    for (std::size_t f = 0; f < kForms; ++f) {
      const CallTotals& totals = run.of[k][f];
      if (totals.calls == 0) continue;
      calls.push_back({{"calls", NameOf(static_cast<Kind>(k), static_cast<Form>(f))},
                       {"number", totals.calls},
                       {"rays", totals.rays},
                       {"in_callbacks", totals.inner_calls},
                       {"seconds", totals.seconds}});
    }
  }
  return {{"library", run.library},
          {"exit_code", run.exit_code},
          {"seconds", run.seconds},
          {"seconds_inside", run.SecondsInside()},
          {"peak_bytes", run.peak_bytes},
          {"refused_geometries", run.refused_geometries},
          {"calls", calls}};
}

struct Report {
  const ProgramRun& embree;
  const ProgramRun& dacrt;

  std::vector<Compared> Print() const {
    bench::Table table({"calls", "number", "rays", "Embree s", "dacrt s", "ratio"}, 1);
    std::vector<Compared> parts;
    for (std::size_t k = 0; k < kKinds; ++k) {
      for (std::size_t f = 0; f < kForms; ++f) {
        const CallTotals &a = embree.of[k][f], &b = dacrt.of[k][f];
        if (a.calls == 0 && b.calls == 0) continue;
        const Kind kind = static_cast<Kind>(k);
        const Form form = static_cast<Form>(f);
        std::string name = NameOf(kind, form);
        if (a.inner_calls > 0) name += " (" + Grouped(a.inner_calls) + " in callbacks)";
        table.Add({name, Grouped(a.calls), kind == Kind::kCommit ? "" : Grouped(a.rays),
                   Fixed(a.seconds, 4), Fixed(b.seconds, 4), Ratio(a.seconds, b.seconds)});
        if (a.seconds > 0 && b.seconds > 0) {
          parts.push_back({NameOf(kind, form), kind, form, a.seconds, b.seconds});
        }
      }
    }
    const auto add = [&](const char* name, double a, double b, int digits) {
      table.Add({name, "", "", Fixed(a, digits), Fixed(b, digits), Ratio(a, b)});
    };
    add("in the library, all threads", embree.SecondsInside(), dacrt.SecondsInside(), 4);
    add("from start to end", embree.seconds, dacrt.seconds, 4);
    add("peak memory, MB", static_cast<double>(embree.peak_bytes) / 1e6,
        static_cast<double>(dacrt.peak_bytes) / 1e6, 1);
    table.Print(std::cout);
    return parts;
  }

  /// Geometries that dacrt alone refuses.
  uint32_t Refused() const {
    return dacrt.refused_geometries - std::min(dacrt.refused_geometries, embree.refused_geometries);
  }

  bool RunsWithDacrt() const { return dacrt.exit_code == 0 && dacrt.devices > 0 && Refused() == 0; }

  /// Programs that draw for a while make more calls where these are faster.
  bool HasSameWork() const {
    uint64_t rays[2] = {0, 0};
    for (std::size_t k = 0; k < kKinds; ++k) {
      for (std::size_t f = 0; f < kForms; ++f) {
        rays[0] += embree.of[k][f].rays;
        rays[1] += dacrt.of[k][f].rays;
      }
    }
    const auto [least, most] = std::minmax(rays[0], rays[1]);
    return static_cast<double>(most - least) <= 0.02 * static_cast<double>(most);
  }
};

/// For programs whose runs do not make the same calls: time for each of Embree's rays.
void ScaleToSameWork(const Report& report, std::vector<Compared>& parts, Compared& total) {
  total.dacrt = 0;
  for (Compared& part : parts) {
    const auto k = static_cast<std::size_t>(part.kind), f = static_cast<std::size_t>(part.form);
    const CallTotals &a = report.embree.of[k][f], &b = report.dacrt.of[k][f];
    const bool has_rays = part.kind != Kind::kCommit;
    const double work = has_rays ? static_cast<double>(a.rays) / static_cast<double>(b.rays)
                                 : static_cast<double>(a.calls) / static_cast<double>(b.calls);
    part.dacrt *= work;
    total.dacrt += part.dacrt;
  }
}

/// The lines that end the report. Prints what is to be read before them. Throws ProgramError.
std::vector<std::string> Judge(const std::string& program, const Report& report) {
  if (report.dacrt.exit_code != 0 || report.dacrt.devices == 0) {
    return {"verdict: stay: it does not run with dacrt: " + Ended(report.dacrt)};
  }
  std::vector<Compared> parts = report.Print();
  std::puts("");
  if (const uint32_t refused = report.Refused()) {
    return {"verdict: stay: " + std::to_string(refused) +
            " of its geometries are of types that dacrt does not have (subdivision surfaces, "
            "curves)"};
  }
  Compared total{"in the library", Kind::kClosest, Form::kSingle, report.embree.SecondsInside(),
                 report.dacrt.SecondsInside()};
  if (!report.HasSameWork()) {
    std::puts("The runs trace different numbers of rays: the verdict goes by the time a ray.");
    std::erase_if(parts, [&](const Compared& part) {
      const auto& of = report.dacrt.of[static_cast<std::size_t>(part.kind)];
      return part.kind != Kind::kCommit && of[static_cast<std::size_t>(part.form)].rays == 0;
    });
    ScaleToSameWork(report, parts, total);
  }
  if (parts.empty()) {
    throw ProgramError(program + ": makes a device, and no call that takes time");
  }
  return Verdict(parts, &total, {report.embree.peak_bytes, report.dacrt.peak_bytes});
}

}  // namespace

int CompareProgram(const Options& options) {
  const std::string& program = options.command.front();
  const std::string counter = FindCounter();
  const auto folder = [](const std::string& library) {
    return library.empty() ? "" : std::filesystem::path(library).parent_path().string();
  };
  std::vector<ProgramRun> embree_runs, dacrt_runs;
  {
    bench::Progress progress(static_cast<std::size_t>(2 * options.repeat));
    for (int round = 0; round < options.repeat; ++round) {
      progress.Show("with Embree");
      embree_runs.push_back(RunProgram(options.command, counter, folder(options.embree), ""));
      CheckWithEmbree(program, embree_runs.back(), options);
      progress.Skip(1);
      progress.Show("with dacrt");
      dacrt_runs.push_back(
          RunProgram(options.command, counter, folder(options.drop_in), options.config));
      CheckWithDacrt(program, dacrt_runs.back(), options);
      progress.Skip(1);
    }
  }
  const Report report{MedianRun(embree_runs), MedianRun(dacrt_runs)};
  std::printf("%s, median of %d runs\nEmbree: %s\ndacrt: %s\n\n", program.c_str(), options.repeat,
              report.embree.library.c_str(), options.drop_in.c_str());
  const std::vector<std::string> verdict = Judge(program, report);
  for (const std::string& line : verdict) std::puts(line.c_str());
  if (!options.json.empty()) {
    const nlohmann::ordered_json json = {{"program", options.command},
                                         {"embree", ToJson(report.embree)},
                                         {"dacrt", ToJson(report.dacrt)},
                                         {"verdict", verdict}};
    bench::WriteFile(options.json, bench::JsonText(json));
  }
  return report.RunsWithDacrt() ? bench::kSuccess : kNotForDacrt;
}

}  // namespace dacrt::compare
