#include "mtled/scan/case_regions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "base/input_error.h"
#include "base/number_text.h"
#include "imaging/image.h"

namespace palpate::tools {

std::vector<NamedBall> ballsOf(const std::string& option, const std::vector<std::string>& values, bool lps) {
  std::vector<NamedBall> balls;
  for (const std::string& value : values) {
    const std::string text = option + " " + value;
    std::istringstream in(value);
    double number[4] = {};
    bool right = true;
    for (int n = 0; n < 4; ++n) {
      char comma = 0;
      right = right && (n == 0 || (in >> comma && comma == ',')) && in >> number[n] && std::isfinite(number[n]);
    }
    std::string rest;
    if (!right || in >> rest || !(number[3] > 0))
      throw InputError({}, text + " is no ball",
                       "give its middle and radius in mm, X,Y,Z,R, such as " + option + " 2,-30,-71,12");
    const double side = lps ? -mm : mm;
    balls.push_back({Vec3(side * number[0], side * number[1], mm * number[2]), mm * number[3], text});
  }
  return balls;
}

void checkBalls(const std::vector<NamedBall>& balls, const TriangleSurface& surface) {
  std::size_t left = surface.vertices.size();
  for (const NamedBall& ball : balls) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& X : surface.vertices) nearest = std::min(nearest, (X - ball.centre).norm());
    if (nearest > ball.radius)
      throw InputError({},
                       ball.text + ": the organ's surface is " + format("%.3g", nearest / mm) +
                           " mm from the middle of this ball, and not in it",
                       "coordinates are the scan's, in mm, as --frame says (ras where it is not given): look them up "
                       "in a viewer, or give a larger radius");
  }
  if (balls.empty()) return;
  for (const Vec3& X : surface.vertices)
    left -= std::any_of(balls.begin(), balls.end(),
                        [&](const NamedBall& ball) { return (X - ball.centre).norm() <= ball.radius; });
  if (left == 0)
    throw InputError({}, balls.front().text + ": the whole surface is in it", "give a smaller radius, in mm");
}

}  // namespace palpate::tools
