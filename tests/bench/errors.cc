#include "errors.h"

#include <cstdio>

namespace dacrt::bench {
namespace {

int Report(const char* program, const std::exception& error, ExitCode code) {
  std::fprintf(stderr, "%s: %s\n", program, error.what());
  return code;
}

}  // namespace

int RunGuarded(const char* program, const std::function<int()>& run) {
  try {
    return run();
  } catch (const UsageError& error) {
    return Report(program, error, kUsage);
  } catch (const UnreadableScene& error) {
    return Report(program, error, kUnreadableScene);
  } catch (const Disagreement& error) {
    return Report(program, error, kDisagreement);
  } catch (const OutputError& error) {
    return Report(program, error, kOutput);
  } catch (const std::exception& error) {
    return Report(program, error, kFailure);
  }
}

}  // namespace dacrt::bench
