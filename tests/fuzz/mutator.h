#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpate::fuzz {

/// Damages inputs in the ways that files get damaged and that readers get wrong: bits, bytes and words changed, parts
/// left out, repeated (up to tens of thousands of times), swapped, taken from another input; numbers replaced by such
/// as no one thinks of.
class Mutator {
 public:
  /// @param seeds  at least one
  Mutator(std::uint64_t seed, std::vector<std::string> seeds);

  /// Input `number` of this seed: of the same seed always the same, on every machine, whatever came before. The first
  /// are the seeds themselves.
  std::string input(std::uint64_t number) const;

 private:
  std::uint64_t seed_;
  std::vector<std::string> seeds_, words_;
};

}  // namespace palpate::fuzz
