#include "mtled/matrix/matrix_case.h"

#include <array>
#include <stdexcept>
#include <string>

#include "mtled/matrix/matrix_draws.h"

namespace palpate::tools {
namespace {

struct Family {
  MatrixCase (*draw)(Lot&);
  double share;  // of all cases
};

constexpr std::array families{Family{drawConfined, 0.12}, Family{drawSheared, 0.12},
                              Family{drawAffine, 0.08},   Family{drawBetweenPlates, 0.10},
                              Family{drawTwisted, 0.13},  Family{drawConfinedCore, 0.05},
                              Family{drawSphere, 0.05},   Family{drawBent, 0.13},
                              Family{drawPress, 0.14},    Family{drawBonded, 0.08}};

}  // namespace

MatrixCase drawCase(unsigned seed) {
  Lot lot(seed);
  double place = lot.between(0, 1);
  std::size_t family = 0;
  while (family + 1 < families.size() && place >= families[family].share) place -= families[family++].share;
  // Some draws ask for more than their tissue can bear in closed form: then others are drawn.
  for (int attempt = 0; attempt < 20; ++attempt) {
    try {
      MatrixCase one = families[family].draw(lot);
      one.seed = seed;
      one.scene.name = "matrix " + std::to_string(seed);
      return one;
    } catch (const std::runtime_error&) {
    }
  }
  throw std::logic_error("seed " + std::to_string(seed) + " draws nothing that has a closed form");
}

}  // namespace palpate::tools
