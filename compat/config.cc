#include "config.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <string>
#include <vector>

#include "boundary.h"

namespace dacrt::compat {
namespace {

enum class Kind { kIdentifier, kInteger, kReal, kSymbol };

struct Token {
  Kind kind;
  std::string_view text;
};

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)); }
bool IsIdentifierStart(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) || c == '_' || c == '.';
}
bool IsIdentifierPart(char c) { return IsIdentifierStart(c) || IsDigit(c); }

/// Length of the run at `text`'s start, from `from` on, of characters for which `is_part` holds.
template <class Predicate>
std::size_t RunLength(std::string_view text, std::size_t from, Predicate is_part) {
  const auto begin = text.begin() + static_cast<std::ptrdiff_t>(std::min(from, text.size()));
  return static_cast<std::size_t>(std::find_if_not(begin, text.end(), is_part) - begin);
}

/// The number at the start of `text`, if there is one.
Token NumberAt(std::string_view text) {
  std::size_t length = text.front() == '+' || text.front() == '-';
  const std::size_t digits = RunLength(text, length, IsDigit);
  if (digits == 0) return {Kind::kSymbol, text.substr(0, 1)};
  length += digits;
  Kind kind = Kind::kInteger;
  if (length < text.size() && text[length] == '.') {
    kind = Kind::kReal;
    length += 1 + RunLength(text, length + 1, IsDigit);
  }
  if (length < text.size() && (text[length] == 'e' || text[length] == 'E')) {
    const std::size_t sign = length + 1 < text.size() && text[length + 1] == '-';
    const std::size_t exponent = RunLength(text, length + 1 + sign, IsDigit);
    if (exponent > 0) {
      kind = Kind::kReal;
      length += 1 + sign + exponent;
    }
  }
  return {kind, text.substr(0, length)};
}

Token TokenAt(std::string_view text) {
  if (IsIdentifierStart(text.front())) {
    return {Kind::kIdentifier, text.substr(0, RunLength(text, 0, IsIdentifierPart))};
  }
  return NumberAt(text);
}

std::vector<Token> Tokenize(std::string_view text) {
  std::vector<Token> tokens;
  while (!text.empty()) {
    if (std::isspace(static_cast<unsigned char>(text.front()))) {
      text.remove_prefix(1);
    } else {
      tokens.push_back(TokenAt(text));
      text.remove_prefix(tokens.back().text.size());
    }
  }
  return tokens;
}

// Embree's keys by the type of their values, with a space around each. Most mean nothing to dacrt,
// but a value of the wrong type is an error in Embree, so it is one here.
constexpr std::string_view kIntegerKeys =
    " threads user_threads set_affinity start_threads verbose benchmark hugepages"
    " float_exceptions enable_selockmemoryprivilege presplits"
    " alloc_main_block_size alloc_num_main_slots alloc_single_thread_alloc alloc_thread_block_size"
    " instancing_block_size instancing_open_max instancing_open_max_depth instancing_open_min"
    " object_accel_max_leaf_size object_accel_min_leaf_size"
    " object_accel_mb_max_leaf_size object_accel_mb_min_leaf_size ";
constexpr std::string_view kRealKeys =
    " cache_size tessellation_cache_size instancing_open_factor max_spatial_split_replications ";
constexpr std::string_view kIdentifierKeys =
    " isa max_isa max_builder_isa frequency_level"
    " accel accel_mb builder builder_mb traverser traverser_mb"
    " tri_accel tri_accel_mb tri_builder tri_builder_mb tri_traverser tri_traverser_mb"
    " quad_accel quad_accel_mb quad_builder quad_builder_mb quad_traverser quad_traverser_mb"
    " line_accel line_accel_mb line_builder line_builder_mb line_traverser line_traverser_mb"
    " hair_accel hair_accel_mb hair_builder hair_builder_mb hair_traverser hair_traverser_mb"
    " object_accel object_accel_mb object_builder object_builder_mb"
    " subdiv_accel subdiv_accel_mb grid_accel grid_accel_mb ";

bool Contains(std::string_view keys, std::string_view key) {
  return keys.find(" " + std::string(key) + " ") != std::string_view::npos;
}

/// The engine's best instruction set that needs nothing beyond Embree's `isa`. An unknown name
/// means SSE2, as in Embree.
InstructionSet LimitFromIsa(std::string_view isa) {
  std::string name(isa);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name == "avx512") return InstructionSet::kAvx512;
  if (name == "avx2") return InstructionSet::kAvx2;
  if (name == "sse42" || name == "sse4.2" || name == "avx" || name == "avxi") {
    return InstructionSet::kSse4;
  }
  return InstructionSet::kScalar;
}

bool IsEmbreeKey(std::string_view key) {
  return Contains(kIntegerKeys, key) || Contains(kRealKeys, key) || Contains(kIdentifierKeys, key);
}

void ApplyEmbreeKey(Config& config, std::string_view key, const Token& value) {
  const bool is_integer = value.kind == Kind::kInteger;
  if (Contains(kIntegerKeys, key) && !is_integer) {
    throw ApiError(RTC_ERROR_UNKNOWN, "config: ", key, " = ", value.text, " is no integer");
  }
  if (Contains(kRealKeys, key) && !is_integer && value.kind != Kind::kReal) {
    throw ApiError(RTC_ERROR_UNKNOWN, "config: ", key, " = ", value.text, " is no number");
  }
  if (Contains(kIdentifierKeys, key) && value.kind != Kind::kIdentifier) {
    throw ApiError(RTC_ERROR_UNKNOWN, "config: ", key, " = ", value.text, " is no name");
  }
  if (key == "threads") {
    // As in Embree, 0 and less mean all.
    const int threads = std::atoi(std::string(value.text).c_str());
    config.settings.threads = static_cast<uint32_t>(std::clamp(threads, 0, 1024));
  }
  if (key == "verbose") config.verbose = std::atoi(std::string(value.text).c_str());
  if (key == "isa") config.isa = LimitFromIsa(value.text);
  if (key == "max_isa") {
    config.isa =
        std::min({config.isa, LimitFromIsa(value.text), AvailableInstructionSets().back()});
  }
  if (key == "isa" || key == "max_isa") config.settings.instruction_set = config.isa;
}

/// `value` as a number from `least` to `most`.
uint64_t MpiNumber(std::string_view name, std::string_view value, uint64_t least, uint64_t most) {
  uint64_t number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error == std::errc() && end == value.data() + value.size() && number >= least &&
      number <= most) {
    return number;
  }
  throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "config: dacrt_mpi", name, " = ", value,
                 " is no number from ", least, " to ", most);
}

/// `name` begins behind "mpi".
void ApplyMpiKey(Config& config, std::string_view name, std::string_view value) {
  if (name == "_timeout") {
    config.mpi_options.timeout_seconds =
        static_cast<double>(MpiNumber(name, value, 1, 1'000'000));
  } else if (name == "_least_rays") {
    config.mpi_options.least_rays = MpiNumber(name, value, 0, UINT32_MAX);
  } else if (name == "_piece_rays") {
    config.mpi_options.piece_rays = MpiNumber(name, value, 1, 1u << 20);
  } else if (name == "_geometry_ids") {
    config.mpi_geometry_ids = static_cast<uint32_t>(MpiNumber(name, value, 0, UINT32_MAX));
  } else if (!name.empty()) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "config: there is no key dacrt_mpi", name);
  } else if (value == "none") {
    config.mpi_mode.reset();
  } else if (value == "replicate") {
    config.mpi_mode = mpi::Mode::kReplicate;
  } else if (value == "divide") {
    config.mpi_mode = mpi::Mode::kDivide;
  } else {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "config: dacrt_mpi = ", value,
                   " is neither replicate nor divide nor none");
  }
}

void ApplyOwnKey(Config& config, std::string_view name, std::string_view value) {
  if (name.starts_with("mpi")) return ApplyMpiKey(config, name.substr(3), value);
  if (name != "ignore_masks") {
    SetByName(config.settings, name, value);
  } else if (value == "0" || value == "1") {
    config.ignore_masks = value == "1";
  } else {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "config: dacrt_ignore_masks = ", value,
                   " is neither 0 nor 1");
  }
}

}  // namespace

void ApplyConfig(Config& config, std::string_view text) {
  constexpr std::string_view kOwnPrefix = "dacrt_";
  const std::vector<Token> tokens = Tokenize(text);
  for (std::size_t i = 0; i < tokens.size();) {
    const Token key = tokens[i++];
    const bool is_own = key.text.starts_with(kOwnPrefix);
    if (!is_own && !IsEmbreeKey(key.text)) continue;
    if (i == tokens.size() || tokens[i].text != "=") {
      if (!is_own) continue;
      throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "config: ", key.text, " has no value");
    }
    ++i;
    Token value = i < tokens.size() ? tokens[i++] : Token{Kind::kSymbol, "nothing"};
    if (is_own) {
      // Embree's grammar reads "8M" as two words, and passes over the second.
      while (i < tokens.size() && tokens[i].kind != Kind::kSymbol &&
             tokens[i].text.data() == value.text.data() + value.text.size()) {
        value.text = {value.text.data(), value.text.size() + tokens[i++].text.size()};
      }
      ApplyOwnKey(config, key.text.substr(kOwnPrefix.size()), value.text);
    } else {
      ApplyEmbreeKey(config, key.text, value);
    }
  }
}

Config ReadConfig(const char* text) {
  Config config;
  if (const char* const environment = std::getenv("DACRT_CONFIG")) {
    ApplyConfig(config, environment);
  }
  if (text) ApplyConfig(config, text);
  if (!ProcessorHas(config.isa)) {
    throw ApiError(RTC_ERROR_UNSUPPORTED_CPU, "config: isa = ", Name(config.isa),
                   ", which this processor does not have");
  }
  return config;
}

}  // namespace dacrt::compat
