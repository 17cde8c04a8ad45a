#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "base/place_hash.h"
#include "base/types.h"

namespace palpate {

/// Answers about some places in space, by the places' bits: for functions of them alone. What is kept saves time and
/// changes no answer. What was not asked between two calls of next() is forgotten.
template <std::size_t Size, class Answer>
class PlacesAsked {
 public:
  using Places = std::array<Vec3, Size>;  // m

  /// The answer if it is known, else null.
  const Answer* find(const Places& places) const {
    for (const auto* answers : {&asked_, &known_})
      if (const auto found = answers->find(places); found != answers->end()) return &found->second;
    return nullptr;
  }
  /// Each that was asked, known or not.
  void keep(const Places& places, const Answer& answer) { asked_.emplace(places, answer); }
  void next() {
    known_ = std::move(asked_);
    asked_.clear();
  }

 private:
  struct Hash {
    std::size_t operator()(const Places& places) const {
      std::uint64_t hash = 0;
      for (const Vec3& x : places) hash = hashOf(x, hash);
      return hash;
    }
  };
  std::unordered_map<Places, Answer, Hash> known_, asked_;
};

/// What was asked of one surface.
struct SurfaceMemory {
  PlacesAsked<4, bool> holds;  // whether a cell is inside (background_cells.h)
  PlacesAsked<3, double> gap;  // m, mean height of the surface above a facet (volume_fit.h)

  void next() { holds.next(), gap.next(); }
};

}  // namespace palpate
